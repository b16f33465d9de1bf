// Checkpoints: the plugin's state at a step, beside the engine's restart file of the same step.
//
// Written under a temporary name; worker.py renames both when both are whole; who started the run
// removes older ones. The state ends with a check sum.
#include "bridges.h"

#include <algorithm>
#include <cstring>

namespace pywet {

namespace {

const char MAGIC[16] = "pywet state 1\n";

struct Head {
  char magic[16];
  int64_t step, formations, ruptures, films, triangles, bridges;
  double initial, formed, ruptured;
};

struct SavedBridge {
  int32_t kind, i, j, triangle;
  double volume, rupture_distance;
};

uint32_t check_sum(const std::vector<char> &data) {  // CRC-32
  uint32_t table[256], c = 0xFFFFFFFFu;
  for (uint32_t k = 0; k < 256; k++) {
    table[k] = k;
    for (int bit = 0; bit < 8; bit++) table[k] = table[k] & 1 ? (table[k] >> 1) ^ 0xEDB88320u : table[k] >> 1;
  }
  for (char byte : data) c = table[(c ^ uint32_t(static_cast<unsigned char>(byte))) & 0xFF] ^ (c >> 8);
  return ~c;
}

template <class T>
void put(std::vector<char> &out, const T *from, size_t n) {
  const char *bytes = reinterpret_cast<const char *>(from);
  out.insert(out.end(), bytes, bytes + n * sizeof(T));
}

template <class T>
void take(const char *&from, T *to, size_t n) {
  std::memcpy(to, from, n * sizeof(T));
  from += n * sizeof(T);
}

}  // namespace

// Called at the end of the plugin's part of a step; forces are complete.
void Bridges::save_state() {
  flush();
  std::vector<double> forces(6 * film.size(), 0.0), all(forces.size());
  for (int a = 0; a < at_.nlocal; a++) {
    std::copy(at_.f[a], at_.f[a] + 3, &forces[6 * at_.tag[a]]);
    std::copy(at_.torque[a], at_.torque[a] + 3, &forces[6 * at_.tag[a] + 3]);
  }
  MPI_Reduce(forces.data(), all.data(), int(forces.size()), MPI_DOUBLE, MPI_SUM, 0, world_);
  Sums sums;
  static_assert(sizeof(Sums) % sizeof(double) == 0, "sums are doubles");
  MPI_Reduce(&energy_.sums, &sums, sizeof(Sums) / sizeof(double), MPI_DOUBLE, MPI_SUM, 0, world_);
  const std::vector<WireSpring> springs = wire_springs();
  if (rank_ > 0) return;
  Head head = {};
  std::memcpy(head.magic, MAGIC, sizeof(MAGIC));
  head.step = now_; head.formations = formations_; head.ruptures = ruptures_;
  head.films = int64_t(film.size()); head.triangles = int64_t(walls.film.size()); head.bridges = int64_t(bridges_.size());
  head.initial = initial_; head.formed = energy_.formed; head.ruptured = energy_.ruptured;
  std::vector<char> out;
  put(out, &head, 1);
  put(out, &sums, 1);
  put(out, film.data(), film.size());
  put(out, walls.film.data(), walls.film.size());
  for (const Bridge &b : bridges_) {
    const SavedBridge saved{b.kind, b.i, b.j, b.triangle, b.volume, b.rupture_distance};
    put(out, &saved, 1);
  }
  put(out, all.data(), all.size());
  const int64_t on_wires = int64_t(springs.size());
  put(out, &on_wires, 1);
  put(out, springs.data(), springs.size());
  if (weighs) {
    put(out, load_.data(), load_.size());
    put(out, weighed_.data(), weighed_.size());
  }
  if (laws.shed_drop) {
    put(out, &left_, 1);
    put(out, felt_.data(), felt_.size());
    put(out, speed_then_.data(), speed_then_.size());
  }
  const uint32_t sum = check_sum(out);
  put(out, &sum, 1);
  const std::string path = directory_ + "/checkpoint/state." + std::to_string(now_) + ".partial";
  FILE *file = fopen(path.c_str(), "wb");
  const bool good = file && fwrite(out.data(), 1, out.size(), file) == out.size() && fflush(file) == 0;
  if (file) fclose(file);
  if (!good) throw std::runtime_error("the checkpoint " + path + " could not be written; is the disk full?");
}

// Every rank reads the same file; called after attach, before the first step.
void Bridges::resume(const std::string &state_file) {
  FILE *file = fopen(state_file.c_str(), "rb");
  if (!file) throw std::runtime_error("the checkpoint " + state_file + " cannot be read");
  std::vector<char> data;
  char block[65536];
  for (size_t n; (n = fread(block, 1, sizeof(block), file)) > 0;) data.insert(data.end(), block, block + n);
  fclose(file);
  uint32_t sum = 0;
  Head head = {};
  bool good = data.size() > sizeof(Head) + sizeof(sum);
  if (good) {
    std::memcpy(&sum, &data[data.size() - sizeof(sum)], sizeof(sum));
    data.resize(data.size() - sizeof(sum));
    std::memcpy(&head, data.data(), sizeof(head));
    good = sum == check_sum(data) && std::memcmp(head.magic, MAGIC, sizeof(MAGIC)) == 0;
  }
  if (!good || head.films != int64_t(film.size()) || head.triangles != int64_t(walls.film.size()))
    throw std::runtime_error("the checkpoint " + state_file + " is damaged or of another scene");
  const char *at = data.data() + sizeof(Head);
  Sums sums;
  take(at, &sums, 1);
  if (rank_ == 0) energy_.sums = sums;
  energy_.formed = head.formed;
  energy_.ruptured = head.ruptured;
  take(at, film.data(), film.size());
  take(at, walls.film.data(), walls.film.size());
  for (size_t id = 1; id < film.size(); id++)
    if (type_of[id] > 0) set_film(int(id), film[id]);
  for (int64_t k = 0; k < head.bridges; k++) {
    SavedBridge saved;
    take(at, &saved, 1);
    Bridge b = made(saved.kind, saved.i, saved.j, saved.volume);
    b.rupture_distance = saved.rupture_distance;
    b.triangle = saved.triangle;
    add(std::move(b));
  }
  saved_forces_.resize(6 * film.size());
  take(at, saved_forces_.data(), saved_forces_.size());
  int64_t on_wires = 0;
  take(at, &on_wires, 1);
  saved_springs_.resize(on_wires);
  take(at, saved_springs_.data(), saved_springs_.size());
  if (weighs) {
    take(at, load_.data(), load_.size());
    take(at, weighed_.data(), weighed_.size());
    heavier_ = true;
    load();
  }
  if (laws.shed_drop) {
    felt_.resize(3 * film.size());
    speed_then_.resize(felt_.size());
    take(at, &left_, 1);
    take(at, felt_.data(), felt_.size());
    take(at, speed_then_.data(), speed_then_.size());
  }
  now_ = head.step;
  initial_ = head.initial;
  formations_ = head.formations;
  ruptures_ = head.ruptures;
}

// The set-up of a run evaluates the forces anew with the speeds of the step itself; the kick that follows in an unbroken run
// uses those of half a step back.
void Bridges::restore_forces() {
  for (int a = 0; a < at_.nlocal; a++) {
    const double *saved = &saved_forces_[6 * at_.tag[a]];
    std::copy(saved, saved + 3, at_.f[a]);
    std::copy(saved + 3, saved + 6, at_.torque[a]);
  }
  saved_forces_.clear();
}

}  // namespace pywet
