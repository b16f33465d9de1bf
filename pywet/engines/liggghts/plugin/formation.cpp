// Which pairs are near enough to form a bridge before the engine makes its lists anew, and which of them form one now.
#include "bridges.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pywet {

static const double SMALLEST_BRIDGE = 1e-12;  // V* below which nothing forms: numerical zero, 1e-4 of the radius in size

static const double ROUND_OFF = 1e-9;  // of the radii: so much sooner is a pair looked at

// A film that was drawn dry may be below zero by the last digit; it has nothing to give.
static double held(double volume) { return std::max(volume, 0.0); }

void Bridges::find_candidates() {
  travel_ = wall_travel_ = thicker_ = wall_thicker_ = 0;
  awake_ = 0;
  thickness_then_ = thickness_;
  shift_before_.clear();
  for (const Mesh &mesh : walls.meshes) shift_before_.push_back(mesh.shift);
  pairs_.clear();
  find_pair_candidates();
  std::stable_sort(pairs_.begin(), pairs_.end(), [](const Candidate &a, const Candidate &b) { return a.gap < b.gap; });
  pair_rest_.clear();
  for (const Candidate &pair : pairs_) pair_rest_.push_back(pair.gap);
  find_wall_candidates();
  sort_bridges();
  auto bridged = [&](int kind, int i, int j, int candidate, double &rest) {
    const auto it = index_.find(key(kind, i, j));
    if (it == index_.end()) return;
    rest = INF;
    bridges_[it->second].candidate = candidate;
  };
  for (size_t c = 0; c < pairs_.size(); c++) bridged(SPHERE, pairs_[c].i, pairs_[c].j, int(c), pair_rest_[c]);
  for (size_t c = 0; c < wall_pairs_.size(); c++)
    bridged(LARGE_WALL, wall_pairs_[c].i, wall_pairs_[c].j, int(c), wall_rest_[c]);
}

// Bridges in the order of their ends in memory, those of this rank first, with the prepared numbers beside them.
void Bridges::sort_bridges() {
  for (Bridge &b : bridges_) place(b);
  std::vector<int> order(bridges_.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int p, int q) {
    const Bridge &a = bridges_[p], &b = bridges_[q];
    if (a.here != b.here) return a.here;
    if (a.a != b.a) return a.a < b.a;
    if (a.b != b.b) return a.b < b.b;
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
  std::vector<Bridge> bridges;
  std::vector<Line> prepared;
  bridges.reserve(order.size());
  prepared.reserve(laws.lines * order.size());
  index_.clear();
  for (int k : order) {
    const Line *lines = prepared_.data() + k * laws.lines;
    prepared.insert(prepared.end(), lines, lines + laws.lines);
    index_[key(bridges_[k].kind, bridges_[k].i, bridges_[k].j)] = int(bridges.size());
    bridges.push_back(std::move(bridges_[k]));
  }
  bridges_.swap(bridges);
  prepared_.swap(prepared);
  for (size_t k = 0; k < bridges_.size(); k++) enter(k);
}

// What the loops of a step know of a bridge.
void Bridges::enter(size_t k) {
  if (blocks_.size() * BATCH <= k) blocks_.resize(k / BATCH + 1);
  const Bridge &b = bridges_[k];
  Block &block = blocks_[k / BATCH];
  const int at = int(k % BATCH);
  block.row[VOLUME][at] = b.volume;
  block.row[RADIUS_I][at] = b.radius_i;
  block.row[RADIUS_J][at] = b.radius_j;
  block.row[ANGLE_I][at] = b.angle_i;
  block.row[ANGLE_J][at] = b.angle_j;
  block.spin_j[at] = b.kind == SPHERE ? b.radius_j : 0.0;
  block.deepest[at] = -largest_overlap * std::min(b.radius_i, b.radius_j);
  block.longest[at] = b.rupture_distance;
  block.a[at] = b.here ? b.a : -1;
  block.b[at] = b.here ? b.b : -1;
}

// What stays the same for the life of a bridge.
Bridge Bridges::made(int kind, int i, int j, double volume) const {
  Bridge b{kind, i, j, volume, 0.0};
  b.radius_i = radius(i);
  b.angle_i = angle(i);
  b.radius_j = kind == SPHERE ? radius(j) : INF;
  b.angle_j = angle_j(kind, j);
  if (kind != SPHERE) b.site.reset(new Site());
  return b;
}

void Bridges::add(Bridge b) {
  index_[key(b.kind, b.i, b.j)] = int(bridges_.size());
  standing_[b.i]++;
  if (b.kind == SPHERE) standing_[b.j]++;
  prepared_.resize(prepared_.size() + laws.lines);
  if (laws.lines > 0)
    laws.prepare(b.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j, prepared_[prepared_.size() - laws.lines].number);
  bridges_.push_back(std::move(b));
  enter(bridges_.size() - 1);
}

// Where a bridge's ends are on this rank.
void Bridges::place(Bridge &b) {
  b.candidate = -1;
  b.a = local(b.i);
  b.b = b.kind == SPHERE ? local(b.j) : -1;
  b.here = owned(b.a) || owned(b.b);
  if (b.here && b.kind == SPHERE && (b.a < 0 || b.b < 0))
    throw std::runtime_error("the bridge between spheres " + std::to_string(b.i) + " and " + std::to_string(b.j) + " at step " +
                             std::to_string(now_) + " reaches beyond the ghost cut-off of this rank; enlarge ghost_cutoff in the deck");
}

// The owner of the lower id decides about a pair; `a`, `b` are local indices.
void Bridges::add_pair(int a, int b) {
  if (at_.tag[b] < at_.tag[a]) std::swap(a, b);
  if (!owned(a)) return;
  const int i = at_.tag[a], j = at_.tag[b];
  const double radii = radius(i) + radius(j);
  const double reach = radii + thickness_[i] + thickness_[j];
  pairs_.push_back(Candidate{i, j, a, b, radii, norm(Vec(at_.x[a]) - Vec(at_.x[b])) - reach - ROUND_OFF * radii});
}

// What sphere and wall may move and their films grow before they touch, seen from when the candidates were found; `distance` of
// the centre from the part now, or less.
double Bridges::rest(const WallCandidate &pair, double distance) const {
  if (walls.meshes[walls.parts[pair.j].mesh].turns) return 0;
  const double reach = radius(pair.i) * (1 + ROUND_OFF) + thickness_then_[pair.i] + part_thickness_then_[pair.j];
  return distance - reach + travel_ + wall_travel_;
}

void Bridges::find_wall_candidates() {
  std::unordered_map<uint64_t, Site> known;  // closest points outlive the list
  for (WallCandidate &pair : wall_pairs_)
    if (pair.site.distance_then >= 0) known[key(LARGE_WALL, pair.i, pair.j)] = std::move(pair.site);
  wall_pairs_.clear();
  wall_rest_.clear();
  std::fill(part_thickness_.begin(), part_thickness_.end(), 0.0);
  for (size_t k = 0; k < walls.triangles.size(); k++)
    if (walls.film[k] > 0) {
      double &w = part_thickness_[walls.part_of[k]];
      w = std::max(w, walls.film[k] / walls.area[k]);
    }
  part_thickness_then_ = part_thickness_;
  // sphere and mesh may each move half the skin before the next rebuild; films may grow meanwhile: one skin more
  const double thickest = part_thickness_.empty() ? 0 : *std::max_element(part_thickness_.begin(), part_thickness_.end());
  std::vector<Vec> y(walls.meshes.size());
  std::vector<char> here(walls.meshes.size());
  for (int a = 0; a < at_.nlocal; a++) {
    const int i = at_.tag[a];
    const double far = reach(i) + 2 * skin();
    for (size_t m = 0; m < walls.meshes.size(); m++) {
      y[m] = walls.meshes[m].to_rest(Vec(at_.x[a]));
      here[m] = Walls::outside(walls.meshes[m].bounds, y[m]) < far + thickest;
    }
    for (size_t p = 0; p < walls.parts.size(); p++) {
      const size_t m = walls.parts[p].mesh;
      if (!here[m]) continue;
      double distance = Walls::outside(walls.parts[p].bounds, y[m]);
      if (distance >= far + part_thickness_[p]) continue;
      const auto site = known.find(key(LARGE_WALL, i, int(p)));
      wall_pairs_.push_back(WallCandidate{i, int(p), a, site == known.end() ? Site() : std::move(site->second)});
      const Site &then = wall_pairs_.back().site;
      if (then.distance_then >= 0) distance = std::max(distance, then.distance_then - norm(y[m] - then.reference));
      wall_rest_.push_back(rest(wall_pairs_.back(), distance));
    }
  }
}

// No sphere has moved further than travel_ since the candidates were found. A way of a tenth of the radius in one step is no
// motion that a contact could follow.
void Bridges::move_bounds() {
  double fastest = 0;
  int which = -1;
  for (int a = 0; a < at_.nall; a++) {
    const double *v = at_.v[a];
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (!(square <= fastest)) {
      fastest = square;
      which = a;
      if (std::isnan(square)) break;
    }
  }
  const double way = at_.dt * std::sqrt(fastest);
  if (which >= 0 && !(way <= 0.1 * radius(at_.tag[which])))
    throw std::runtime_error("sphere " + std::to_string(at_.tag[which]) + " moves at " + number(std::sqrt(fastest)) +
                             " m/s at step " + std::to_string(now_) +
                             ", more than a tenth of its radius in one step; likely an unstable run: lower the time step");
  travel_ += way;
  double furthest = 0;
  for (size_t m = 0; m < shift_before_.size(); m++) {
    furthest = std::max(furthest, norm(walls.meshes[m].shift - shift_before_[m]));
    shift_before_[m] = walls.meshes[m].shift;
  }
  wall_travel_ += furthest;
}

void Bridges::propose(int kind, int i, int j, int candidate, const Geometry &g, double drawn_i, double drawn_j) {
  const double r = kind == SPHERE ? 2 * g.radius_i * g.radius_j / (g.radius_i + g.radius_j) : g.radius_i;
  if (!(drawn_i >= 0) || !(drawn_j >= 0))
    throw std::runtime_error("the formation law draws a share below zero from " +
                             std::string(drawn_i >= 0 ? "the partner of sphere " : "sphere ") + std::to_string(i) + " at step " +
                             std::to_string(now_) + "; expected zero or more: mend the law");
  if (!(drawn_i + drawn_j > SMALLEST_BRIDGE * r * r * r)) return;
  Event e = {};
  e.step = now_; e.time = time_; e.kind = FORMATION; e.partner_kind = kind;
  e.i = i; e.j = j; e.triangle = g.triangle;
  e.share_i = drawn_i; e.share_j = drawn_j;
  e.separation = g.separation;
  e.speed = norm(g.vi - g.vj);
  proposed_[key(kind, i, j)] = candidate;
  events_.push_back(e);
}

void Bridges::propose_pairs() {
  const double way = 2 * (travel_ + thicker_);
  while (awake_ < pairs_.size() && pairs_[awake_].gap <= way) awake_++;
  for (size_t c = 0; c < awake_; c++) {
    if (pair_rest_[c] > way) continue;
    const Candidate &pair = pairs_[c];
    const double *x = at_.x[pair.a], *y = at_.x[pair.b];
    const double dx = x[0] - y[0], dy = x[1] - y[1], dz = x[2] - y[2];
    const double square = dx * dx + dy * dy + dz * dz;
    const double touch = pair.radii + thickness_[pair.i] + thickness_[pair.j];
    if (square >= touch * touch) {
      const double then = pair.radii * (1 + ROUND_OFF) + thickness_then_[pair.i] + thickness_then_[pair.j];
      pair_rest_[c] = std::sqrt(square) - then + 2 * travel_;
      continue;
    }
    Geometry g;
    pair_geometry(pair.a, pair.b, radius(pair.i), radius(pair.j), g);
    check_overlap(g, SPHERE, pair.i, pair.j);
    propose(SPHERE, pair.i, pair.j, int(c), g, laws.from_sphere(held(film[pair.i]), g.radius_i, g.radius_j),
            laws.from_sphere(held(film[pair.j]), g.radius_j, g.radius_i));
  }
}

void Bridges::propose_walls() {
  const double way = travel_ + wall_travel_ + thicker_ + wall_thicker_;
  for (size_t c = 0; c < wall_rest_.size(); c++) {
    if (wall_rest_[c] > way) continue;
    WallCandidate &pair = wall_pairs_[c];
    const Part &part = walls.parts[pair.j];
    const double far = Walls::outside(part.bounds, walls.meshes[part.mesh].to_rest(Vec(at_.x[pair.a])));
    if (far >= reach(pair.i) + part_thickness_[pair.j] && far > 0) {
      wall_rest_[c] = rest(pair, far);
      continue;
    }
    const Closest near = walls.closest(pair.j, Vec(at_.x[pair.a]), pair.site, margin_);
    const double w = held(walls.film[near.triangle]) / walls.area[near.triangle];
    if (near.distance >= reach(pair.i) + w) {
      wall_rest_[c] = rest(pair, near.distance);
      continue;
    }
    Geometry g;
    wall_geometry(pair.a, radius(pair.i), pair.j, near, g);
    check_overlap(g, LARGE_WALL, pair.i, pair.j);
    const bool wire = part.half_width < g.radius_i;
    const double drawn = wire ? laws.from_sphere_at_wire(held(film[pair.i]), g.radius_i, part.half_width)
                              : laws.from_sphere(held(film[pair.i]), g.radius_i, INF);
    const double drawn_w = wire ? laws.from_wire(w, g.radius_i, part.half_width) : laws.from_wall(w, g.radius_i);
    propose(wire ? SMALL_WALL : LARGE_WALL, pair.i, pair.j, int(c), g, drawn, drawn_w);
  }
}

}  // namespace pywet
