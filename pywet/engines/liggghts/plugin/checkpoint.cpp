// Checkpoints: the plugin's state at a step, stored next to the engine's restart file of that step.
//
// Written under a temporary name; worker.py renames both files when both are complete; the process that started the run
// removes older ones. The state ends with a checksum.
#include "checkpoint.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace pywet {

namespace {

const char MAGIC[16] = "pywet state 5\n";

struct Head {
  char magic[16];
  int64_t step, formations, ruptures, spheres, triangles, bridges;
  double initial, left, retired, formed, ruptured;
};

uint32_t check_sum(const char *data, size_t size) {  // CRC-32
  uint32_t table[256], c = 0xFFFFFFFFu;
  for (uint32_t k = 0; k < 256; k++) {
    table[k] = k;
    for (int bit = 0; bit < 8; bit++) table[k] = table[k] & 1 ? (table[k] >> 1) ^ 0xEDB88320u : table[k] >> 1;
  }
  for (const char *end = data + size; data < end; data++) c = table[(c ^ uint8_t(*data)) & 0xFF] ^ (c >> 8);
  return ~c;
}

template <class T>
void put(std::vector<char> &out, const T *from, size_t n) {
  const char *bytes = reinterpret_cast<const char *>(from);
  out.insert(out.end(), bytes, bytes + n * sizeof(T));
}

void need(bool good, const std::string &file) {
  if (!good)
    throw std::runtime_error("the checkpoint " + file +
                             " is damaged or of another scene; expected one of this run: remove engine.partial and call again");
}

// Reads a state file item by item; sizes given in the file are checked, so that no read goes beyond its end.
class Reader {
 public:
  Reader(const char *from, const char *end, const std::string &file) : from_(from), end_(end), file_(file) {}

  template <class T>
  const T *next(int64_t n) {
    need(n >= 0 && n <= int64_t((end_ - from_) / sizeof(T)), file_);
    const T *at = reinterpret_cast<const T *>(from_);
    from_ += n * sizeof(T);
    return at;
  }
  int64_t count() { return *next<int64_t>(1); }
  template <class T>
  void all(std::vector<T> &numbers) {
    const int64_t n = count();
    const T *at = next<T>(n);
    numbers.assign(at, at + n);
  }
  bool ended() const { return from_ == end_; }

 private:
  const char *from_, *end_;
  const std::string &file_;
};

}  // namespace

void Checkpoint::save() {
  logs_.flush();
  const View &at = world_.engine.at;
  const Communicator &ranks = world_.ranks;
  std::vector<SphereState> spheres;
  for (int a = 0; a < at.nlocal; a++) {
    if (world_.spheres.is_retired(at.tag[a])) continue;
    const double *x = at.x[a], *l = at.liquid[a], *f = at.f[a], *t = at.torque[a];
    spheres.push_back({at.tag[a], {x[0], x[1]}, l[FILM], l[LOAD], l[WEIGHED], {l[IMPULSE], l[IMPULSE + 1], l[IMPULSE + 2]},
                       {f[0], f[1], f[2]}, {t[0], t[1], t[2]}});
  }
  spheres = ranks.gathered_first(spheres);
  for (const Coming &c : world_.feed.due(world_.clock.now)) {
    const Vec x = c.at(world_.clock.time);
    spheres.push_back({c.id, {x.x, x.y}, c.film, c.film, c.film, {}, {}, {}});
  }
  std::sort(spheres.begin(), spheres.end(), [](const SphereState &p, const SphereState &q) { return p.id < q.id; });
  Sums sums;
  static_assert(sizeof(Sums) % sizeof(double) == 0, "sums are doubles");
  MPI_Reduce(&energy_.sums, &sums, sizeof(Sums) / sizeof(double), MPI_DOUBLE, MPI_SUM, 0, ranks.all);
  std::vector<WireSpring> springs = faces_.springs(), of_wires = wires_.springs();
  springs.insert(springs.end(), of_wires.begin(), of_wires.end());
  springs = ranks.gathered_first(springs);
  std::sort(springs.begin(), springs.end());
  const std::vector<BridgeRecord> bridges = ranks.gathered_first(standing_.mine());
  double numbers[4] = {energy_.formed, energy_.ruptured, double(standing_.formations), double(standing_.ruptures)};
  ranks.add_up(numbers);
  if (!ranks.first()) return;
  Head head = {};
  std::memcpy(head.magic, MAGIC, sizeof(MAGIC));
  head.step = world_.clock.now; head.formations = int64_t(numbers[2]); head.ruptures = int64_t(numbers[3]);
  head.spheres = int64_t(spheres.size()); head.triangles = int64_t(films_.wall.size());
  head.bridges = int64_t(bridges.size());
  head.initial = films_.initial; head.left = films_.left; head.retired = films_.retired; head.formed = numbers[0]; head.ruptured = numbers[1];
  std::vector<char> out;
  auto put_all = [&](const auto &numbers) {
    const int64_t n = int64_t(numbers.size());
    put(out, &n, 1);
    put(out, numbers.data(), numbers.size());
  };
  put(out, &head, 1);
  put_all(spheres);
  put_all(world_.spheres.retired);
  put(out, &sums, 1);
  put_all(films_.wall);
  put(out, bridges.data(), bridges.size());
  put_all(springs);
  if (world_.laws.shed_drop) shedding_.keep(put_all);
  const uint32_t sum = check_sum(out.data(), out.size());
  put(out, &sum, 1);
  const std::string path = logs_.directory() + "/checkpoint/state." + std::to_string(world_.clock.now) + ".partial";
  FILE *file = fopen(path.c_str(), "wb");
  const bool good = file && fwrite(out.data(), 1, out.size(), file) == out.size() && fflush(file) == 0;
  if (file) fclose(file);
  if (!good) throw std::runtime_error("the checkpoint " + path + " could not be written; is the disk full?");
}

// The file is mapped into memory, so that the ranks of a machine share its pages and do not copy each other's data.
static std::shared_ptr<const char> mapped(const std::string &path, size_t &size) {
  const int file = open(path.c_str(), O_RDONLY);
  struct stat status = {};
  void *at = MAP_FAILED;
  if (file >= 0 && fstat(file, &status) == 0) at = mmap(nullptr, size = status.st_size, PROT_READ, MAP_PRIVATE, file, 0);
  if (file >= 0) close(file);
  if (at == MAP_FAILED) throw std::runtime_error("the checkpoint " + path + " cannot be read");
  return {static_cast<const char *>(at), [n = size](const char *p) { munmap(const_cast<char *>(p), n); }};
}

void Checkpoint::resume(const std::string &state_file) {
  size_t size = 0;
  uint32_t sum = 0;
  file_ = mapped(state_file, size);
  Head head = {};
  if (size > sizeof(head) + sizeof(sum)) {
    size -= sizeof(sum);
    std::memcpy(&sum, file_.get() + size, sizeof(sum));
    if (sum == check_sum(file_.get(), size)) std::memcpy(&head, file_.get(), sizeof(head));
  }
  const size_t ids = world_.spheres.ids(), triangles = films_.wall.size();
  need(std::memcmp(head.magic, MAGIC, sizeof(MAGIC)) == 0 && head.spheres <= world_.spheres.count &&
           head.triangles == int64_t(triangles), state_file);
  Reader from(file_.get() + sizeof(Head), file_.get() + size, state_file);
  count_ = from.count();
  spheres_ = from.next<SphereState>(count_);
  from.all(world_.spheres.retired);
  for (int64_t id : world_.spheres.retired) need(world_.spheres.exists(id), state_file);
  const Sums sums = *from.next<Sums>(1);
  if (world_.ranks.first()) {
    energy_.sums = sums;
    energy_.formed = head.formed;
    energy_.ruptured = head.ruptured;
    standing_.formations = head.formations;
    standing_.ruptures = head.ruptures;
  }
  const int64_t walls = from.count();
  need(walls == int64_t(triangles), state_file);
  const double *wall = from.next<double>(walls);
  films_.wall.assign(wall, wall + walls);
  const View &at = world_.engine.at;
  for (int a = 0; a < at.nlocal; a++) {
    const SphereState &sphere = of(at.tag[a]);
    need(&sphere < spheres_ + count_ && sphere.id == at.tag[a], state_file);
    at.liquid[a][FILM] = sphere.film;
    at.liquid[a][LOAD] = sphere.load;
    at.liquid[a][WEIGHED] = sphere.weighed;
    std::copy(sphere.impulse, sphere.impulse + 3, at.impulse(a));
  }
  const BridgeRecord *bridges = from.next<BridgeRecord>(head.bridges);
  for (const BridgeRecord *b = bridges; b < bridges + head.bridges; b++) need(standing_.has_ends(*b), state_file);
  standing_.expect({file_, bridges}, head.bridges);
  std::vector<WireSpring> springs;
  from.all(springs);
  faces_.take_up(springs);
  wires_.take_up(springs);
  if (world_.rules.weighs) weight_.taken_up();
  if (world_.laws.shed_drop)
    shedding_.keep([&](std::vector<double> &numbers) {
      from.all(numbers);
      need(numbers.empty() || numbers.size() == 3 * ids, state_file);
    });
  need(from.ended(), state_file);
  world_.clock.now = head.step;
  films_.initial = head.initial;
  films_.left = head.left;
  films_.retired = head.retired;
}

const SphereState &Checkpoint::of(int id) const {
  const auto before = [](const SphereState &sphere, int64_t id) { return sphere.id < id; };
  return *std::lower_bound(spheres_, spheres_ + count_, int64_t(id), before);
}

// The set-up of a run evaluates the forces with the velocities of the step itself; in an uninterrupted run the kick that follows
// uses those of half a step earlier.
bool Checkpoint::restore_forces() {
  if (!file_) return false;
  const View &at = world_.engine.at;
  for (int a = 0; a < at.nlocal; a++) {
    const SphereState &saved = of(at.tag[a]);
    std::copy(saved.force, saved.force + 3, at.f[a]);
    std::copy(saved.torque, saved.torque + 3, at.torque[a]);
  }
  file_.reset();
  return true;
}

}  // namespace pywet
