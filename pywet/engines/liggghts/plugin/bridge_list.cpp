#include "bridge_list.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pywet {

Bridge BridgeList::made(int kind, int i, int j, double volume) const {
  const Spheres &spheres = world_.spheres;
  Bridge b{kind, i, j, volume, 0.0};
  b.radius_i = spheres.radius(i);
  b.angle_i = spheres.angle(i);
  b.radius_j = kind == SPHERE ? spheres.radius(j) : INF;
  b.angle_j = kind == SPHERE ? spheres.angle(j) : world_.walls.parts[j].contact_angle;
  return b;
}

Bridge BridgeList::made(const BridgeRecord &record) const {
  Bridge b = made(record.kind, record.i, record.j, record.volume);
  b.rupture_distance = record.rupture_distance;
  return b;
}

bool BridgeList::has_ends(const BridgeRecord &record) const {
  const Spheres &spheres = world_.spheres;
  const bool wall = record.kind == LARGE_WALL || record.kind == SMALL_WALL;
  if (!spheres.exists(record.i)) return false;
  return wall ? record.j >= 0 && record.j < int64_t(world_.walls.parts.size()) : record.kind == SPHERE && spheres.exists(record.j);
}

void BridgeList::locate(Bridge &b) const {
  const Engine &engine = world_.engine;
  b.candidate = -1;
  b.a = engine.local(b.i);
  b.b = b.kind == SPHERE ? engine.local(b.j) : -1;
  b.mine = engine.at.owned(b.a);
  b.here = b.mine || engine.at.owned(b.b);
}

void BridgeList::place(Bridge &b) const {
  locate(b);
  if (b.here && b.kind == SPHERE && (b.a < 0 || b.b < 0))
    throw std::runtime_error("the bridge between spheres " + std::to_string(b.i) + " and " + std::to_string(b.j) + " at step " +
                             std::to_string(world_.clock.now) +
                             " reaches beyond the ghost cut-off of this rank; enlarge ghost_cutoff in the deck");
  const View &at = world_.engine.at;
  if (!at.images.any || !b.here || b.kind != SPHERE) return;
  double way[3];
  store(at.apart(b.a, b.b), way);
  for (int axis = 0; axis < 3; axis++)
    if (at.images.along[axis] && std::fabs(way[axis]) > 0.5 * at.images.length[axis] - world_.engine.skin)
      throw std::runtime_error("the bridge between spheres " + std::to_string(b.i) + " and " + std::to_string(b.j) + " at step " +
                               std::to_string(world_.clock.now) + " is nearly as long as half the periodic box, " +
                               number(at.images.length[axis]) + " m, where it could be one with either copy; expected a longer box");
}

void BridgeList::add(Bridge b, const BridgeSums &since) {
  const Laws &laws = world_.laws;
  prepared_.resize(prepared_.size() + laws.lines);
  if (laws.lines > 0)
    laws.prepare(b.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j, prepared_[prepared_.size() - laws.lines].number);
  if (b.kind != SPHERE) {
    b.site = int(sites.size());
    sites.push_back(world_.walls.site_at(b.j));
  }
  bridges.push_back(b);
  sums.push_back(since);
  index(bridges.size() - 1);
  enter(bridges.size() - 1);
}

void BridgeList::remove(size_t k) {
  const int lines = world_.laws.lines;
  const Bridge &b = bridges[k];
  index_.forget(key_of(b.kind, b.i, b.j));
  if (k != bridges.size() - 1) {
    bridges[k] = bridges.back();
    sums[k] = sums.back();
    std::copy(prepared_.end() - lines, prepared_.end(), prepared_.begin() + k * lines);
    index(k);
    enter(k);
  }
  bridges.pop_back();
  sums.pop_back();
  prepared_.resize(prepared_.size() - lines);
}

BridgeRecord BridgeList::record(size_t k) const {
  const Bridge &b = bridges[k];
  return BridgeRecord{b.kind, b.i, b.j, 0, b.volume, b.rupture_distance, sums[k]};
}

std::vector<BridgeRecord> BridgeList::mine() const {
  std::vector<BridgeRecord> records;
  for (size_t k = 0; k < bridges.size(); k++)
    if (bridges[k].mine) records.push_back(record(k));
  return records;
}

void BridgeList::expect(std::shared_ptr<const BridgeRecord> all, int64_t n) {
  recorded_ = std::move(all);
  count_recorded_ = n;
}

// The rank that owned the first end sends every bridge that now has an end on another rank.
void BridgeList::exchange() {
  const View &at = world_.engine.at;
  std::vector<BridgeRecord> leaving;
  for (size_t k = 0; k < bridges.size(); k++) {
    Bridge &b = bridges[k];
    const bool was_mine = b.mine;
    locate(b);
    if (was_mine && !(b.mine && (b.kind != SPHERE || at.owned(b.b)))) leaving.push_back(record(k));
  }
  if (recorded_) {
    take_up(recorded_.get(), count_recorded_);
    recorded_.reset();
  } else if (!world_.ranks.alone()) {
    leaving = world_.ranks.near(leaving);
  }
  take_up(leaving.data(), int64_t(leaving.size()));
}

// Received bridges that have an end on this rank and are new to it.
void BridgeList::take_up(const BridgeRecord *record, int64_t n) {
  for (const BridgeRecord *end = record + n; record < end; record++) {
    if (world_.engine.local(record->i) < 0 && (record->kind != SPHERE || world_.engine.local(record->j) < 0)) continue;
    if (find(record->kind, record->i, record->j) >= 0) continue;
    Bridge b = made(*record);
    locate(b);
    if (b.here) add(b, record->sums);
  }
}

// Counting sort by the first end, then by the second, since most bridges are in order already.
std::vector<int> BridgeList::in_order() const {
  std::vector<int> next(world_.engine.at.nall + 1, 0), order(bridges.size());
  for (const Bridge &b : bridges) next[b.a + 1]++;
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (size_t k = 0; k < bridges.size(); k++) order[next[bridges[k].a]++] = int(k);
  const auto before = [&](int p, int q) {
    const Bridge &a = bridges[p], &b = bridges[q];
    return a.b != b.b ? a.b < b.b : a.j < b.j;
  };
  for (size_t first = 0, last; first < order.size(); first = last) {
    last = first + 1;
    while (last < order.size() && bridges[order[last]].a == bridges[order[first]].a) last++;
    std::sort(order.begin() + first, order.begin() + last, before);
  }
  return order;
}

// Bridges that left this rank are dropped. The others are moved one cycle of the permutation after the other; most are in place.
void BridgeList::sort() {
  for (Bridge &b : bridges) place(b);
  for (size_t k = bridges.size(); k-- > 0;)
    if (!bridges[k].here) remove(k);
  std::vector<int> order = in_order();
  const int lines = world_.laws.lines;
  const auto put = [&](size_t to, const Bridge &b, const BridgeSums &since, const CacheLine *line) {
    bridges[to] = b;
    sums[to] = since;
    std::copy(line, line + lines, prepared_.begin() + to * lines);
    index(to);
    order[to] = int(to);
  };
  for (size_t first = 0; first < order.size(); first++) {
    if (order[first] == int(first)) continue;
    const Bridge b = bridges[first];
    const BridgeSums since = sums[first];
    const std::vector<CacheLine> line(prepared(first), prepared(first + 1));
    size_t to = first;
    for (size_t from; (from = order[to]) != first; to = from) put(to, bridges[from], sums[from], prepared(from));
    put(to, b, since, line.data());
  }
  if (index_.crowded(bridges.size())) {
    index_.begin(bridges.size());
    for (size_t k = 0; k < bridges.size(); k++) index(k);
  }
  std::vector<Site> sites_in_order;      // without the sites of ruptured bridges
  for (size_t k = 0; k < bridges.size(); k++) {
    Bridge &b = bridges[k];
    if (b.kind != SPHERE) {
      sites_in_order.push_back(std::move(sites[b.site]));
      b.site = int(sites_in_order.size()) - 1;
    }
    enter(k);
  }
  sites.swap(sites_in_order);
}

void BridgeList::index(size_t k) { index_.set(key_of(bridges[k].kind, bridges[k].i, bridges[k].j), int(k)); }

void BridgeList::enter(size_t k) {
  if (blocks.size() * BATCH <= k) blocks.resize(k / BATCH + 1);
  const Bridge &b = bridges[k];
  Block &block = blocks[k / BATCH];
  const int at = int(k % BATCH);
  block.row[VOLUME][at] = b.volume;
  block.row[RADIUS_I][at] = b.radius_i;
  block.row[RADIUS_J][at] = b.radius_j;
  block.row[ANGLE_I][at] = b.angle_i;
  block.row[ANGLE_J][at] = b.angle_j;
  block.spin_j[at] = b.kind == SPHERE ? b.radius_j : 0.0;
  block.deepest[at] = -world_.rules.largest_overlap * std::min(b.radius_i, b.radius_j);
  block.longest[at] = b.rupture_distance;
  block.a[at] = b.here ? b.a : -1;
  block.b[at] = b.kind != SPHERE ? -1 - b.site : b.here ? b.b : -1;
}

int BridgeList::find(int kind, int i, int j) const {
  return index_.find(key_of(kind, i, j));
}

Geometry BridgeList::geometry(const Bridge &b) {
  if (b.kind == SPHERE) return between_spheres(world_, b.a, b.b, b.radius_i, b.radius_j);
  return at_wall(world_, b.a, b.radius_i, b.j, world_.walls.closest(Vec(world_.engine.at.x[b.a]), sites[b.site]));
}

double BridgeList::share(const Bridge &b) const {
  const Spheres &spheres = world_.spheres;
  const double ri = spheres.radius(b.i);
  const double r = b.kind == SPHERE ? 2 * ri * spheres.radius(b.j) / (ri + spheres.radius(b.j)) : ri;
  const int other = b.kind == SPHERE ? spheres.type_of[b.j] : world_.walls.parts[b.j].group;
  return b.volume * world_.transfer.ratio(b.kind, spheres.type_of[b.i], other, b.volume / (r * r * r));
}

double BridgeList::checked(double distance, const char *law, const Bridge &b) const {
  if (distance > 0 && distance < INF) return distance;
  throw std::runtime_error(std::string("the ") + law + " law gives a rupture distance of " + number(distance) +
                           " m for the bridge of sphere " + std::to_string(b.i) +
                           (b.kind == SPHERE ? " and sphere " : " and wall part ") + std::to_string(b.j) + " at step " +
                           std::to_string(world_.clock.now) + "; expected a finite one above zero: fix the law");
}

double BridgeList::rupture_distance(const Bridge &b) const {
  return checked(world_.laws.rupture(b.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j), "rupture", b);
}

double BridgeList::rupture_limit(const Bridge &b, const Geometry &g) const {
  const Laws &laws = world_.laws;
  if (!laws.dynamic_rupture) return b.rupture_distance;
  const double factor = laws.dynamic_rupture(norm(g.vi - g.vj), laws.viscosity, laws.surface_tension);
  return checked(b.rupture_distance * factor, "dynamic_rupture", b);
}

}  // namespace pywet
