// Which pairs are near enough to form a bridge before the engine makes its lists anew, and which of them form one now.
#include "bridges.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pywet {

static const double SMALLEST_BRIDGE = 1e-12;  // V* below which nothing forms: numerical zero, 1e-4 of the radius in size

static const double LAYER = 0.1;  // of the skin: pairs are looked at in layers of their gap

// A film that was drawn dry may be below zero by the last digit; it has nothing to give.
static double held(double volume) { return std::max(volume, 0.0); }

void Bridges::find_candidates() {
  travel_ = thicker_ = 0;
  thickness_then_ = thickness_;
  pairs_.clear();
  find_pair_candidates();
  std::stable_sort(pairs_.begin(), pairs_.end(), [](const Candidate &a, const Candidate &b) { return a.layer < b.layer; });
  find_wall_candidates();
  sort_bridges();
  for (size_t c = 0; c < pairs_.size(); c++) {
    auto it = index_.find(key(SPHERE, pairs_[c].i, pairs_[c].j));
    pairs_[c].active = it == index_.end();
    if (!pairs_[c].active) bridges_[it->second].candidate = int(c);
  }
  for (size_t c = 0; c < wall_pairs_.size(); c++) {
    auto it = index_.find(key(LARGE_WALL, wall_pairs_[c].i, wall_pairs_[c].j));
    wall_pairs_[c].active = it == index_.end();
    if (!wall_pairs_[c].active) bridges_[it->second].candidate = int(c);
  }
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
  const double gap = norm(Vec(at_.x[a]) - Vec(at_.x[b])) - reach;
  pairs_.push_back(Candidate{i, j, a, b, true, radii, reach, int(std::max(gap, 0.0) / (LAYER * skin()))});
}

void Bridges::find_wall_candidates() {
  std::unordered_map<uint64_t, Site> known;  // closest points outlive the list
  for (WallCandidate &pair : wall_pairs_)
    if (pair.site.distance_then >= 0) known[key(LARGE_WALL, pair.i, pair.j)] = std::move(pair.site);
  wall_pairs_.clear();
  std::fill(part_thickness_.begin(), part_thickness_.end(), 0.0);
  for (size_t k = 0; k < walls.triangles.size(); k++)
    if (walls.film[k] > 0) {
      double &w = part_thickness_[walls.part_of[k]];
      w = std::max(w, walls.film[k] / walls.area[k]);
    }
  for (int a = 0; a < at_.nlocal; a++) {
    const int i = at_.tag[a];
    const Vec x(at_.x[a]);
    // sphere and mesh may each move half the skin before the next rebuild; films may grow meanwhile: one skin more
    for (size_t p = 0; p < walls.parts.size(); p++)
      if (walls.near_bounds(int(p), x, reach(i) + part_thickness_[p] + 2 * skin()))
        wall_pairs_.push_back(WallCandidate{i, int(p), a, true, std::move(known[key(LARGE_WALL, i, int(p))])});
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
  const double near = 2 * (travel_ + thicker_);
  for (size_t c = 0; c < pairs_.size() && pairs_[c].layer * LAYER * skin() <= near; c++) {
    const Candidate &pair = pairs_[c];
    if (!pair.active) continue;
    const double *x = at_.x[pair.a], *y = at_.x[pair.b];
    const double dx = x[0] - y[0], dy = x[1] - y[1], dz = x[2] - y[2];
    const double square = dx * dx + dy * dy + dz * dz, most = pair.reach + 2 * thicker_;
    if (square >= most * most) continue;
    const double touch = pair.radii + thickness_[pair.i] + thickness_[pair.j];
    if (square >= touch * touch) continue;
    Geometry g;
    pair_geometry(pair.a, pair.b, radius(pair.i), radius(pair.j), g);
    check_overlap(g, SPHERE, pair.i, pair.j);
    propose(SPHERE, pair.i, pair.j, int(c), g, laws.from_sphere(held(film[pair.i]), g.radius_i, g.radius_j),
            laws.from_sphere(held(film[pair.j]), g.radius_j, g.radius_i));
  }
}

void Bridges::propose_walls() {
  for (size_t c = 0; c < wall_pairs_.size(); c++) {
    WallCandidate &pair = wall_pairs_[c];
    if (!pair.active) continue;
    const Part &part = walls.parts[pair.j];
    const Vec x(at_.x[pair.a]);
    const double widest = reach(pair.i) + part_thickness_[pair.j];
    if (pair.site.distance_then >= 0) {
      const double slack = pair.site.distance_then - widest;
      const Vec moved = walls.meshes[part.mesh].to_rest(x) - pair.site.reference;
      if (slack > 0 && dot(moved, moved) < slack * slack) continue;
    }
    const Closest near = walls.closest(pair.j, x, pair.site, margin_);
    const double w = held(walls.film[near.triangle]) / walls.area[near.triangle];
    if (near.distance >= reach(pair.i) + w) continue;
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
