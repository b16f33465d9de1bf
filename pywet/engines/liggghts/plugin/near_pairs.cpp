#include "near_pairs.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pywet {

static const double SMALLEST_BRIDGE = 1e-12;  // V* below which no bridge forms: numerical zero, a bridge of 1e-4 of the radius

static const double CLASS = 1.0 / 32;  // width of a class of gaps, relative to the skin

static const double ONE_PLACE = 1e-6;  // relative to the radius: points this close are identical, and lie on the face, as at a convex edge

static const double ROUND_OFF = 1e-9;  // relative to the radii: a pair is examined this much earlier

// Round-off can make an emptied film slightly negative; it has nothing to give.
static double held(double volume) { return std::max(volume, 0.0); }

void NearPairs::find() {
  const size_t bridges = standing_.bridges.size();
  travel_ = wall_travel_ = 0;
  shift_before_.clear();
  for (const Mesh &mesh : world_.walls.meshes) shift_before_.push_back(mesh.shift);
  of_sphere_.assign(world_.engine.at.nall + 1, bridges);
  for (size_t k = bridges; k-- > 0;)
    if (standing_.bridges[k].a >= 0) of_sphere_[standing_.bridges[k].a] = k;
  found_.clear();
  for (const auto &[a, b] : world_.engine.neighbours()) add(a, b);
  order();
  find_walls();
}

// Sorted by their first ends.
int NearPairs::bridge_of(int kind, int a, int j) const {
  const auto &bridges = standing_.bridges;
  for (size_t k = of_sphere_[a]; k < bridges.size() && bridges[k].a == a; k++)
    if (bridges[k].j == j && (bridges[k].kind == SPHERE) == (kind == SPHERE)) return int(k);
  return -1;
}

int NearPairs::class_of(const Pair &pair) const {
  return int(std::clamp(pair.gap / (CLASS * world_.engine.skin), 0.0, CLASSES - 1.0));
}

void NearPairs::order() {
  active_ = active_classes_ = 0;
  std::fill(first_, first_ + CLASSES + 1, 0);
  for (const Pair &pair : found_) first_[class_of(pair) + 1]++;
  std::partial_sum(first_, first_ + CLASSES + 1, first_);
  size_t next[CLASSES];
  std::copy(first_, first_ + CLASSES, next);
  pairs_.resize(found_.size());
  rest_.resize(found_.size());
  for (const Pair &pair : found_) {
    const size_t c = next[class_of(pair)]++;
    pairs_[c] = pair;
    rest_[c] = pair.bridge < 0 ? pair.gap : INF;
    if (pair.bridge >= 0) standing_.bridges[pair.bridge].candidate = int(c);
  }
}

void NearPairs::bridged(Bridge &b) {
  const auto pair = proposed_.find(key_of(b.kind, b.i, b.j));
  if (pair == proposed_.end()) return;
  b.candidate = pair->second;
  rest_of(b.kind, b.candidate) = INF;
}

void NearPairs::activate(const Bridge &b) {
  if (b.candidate >= 0) rest_of(b.kind, b.candidate) = 0;
}

// The owner of the lower id decides about a pair; `a`, `b` are local indices.
void NearPairs::add(int a, int b) {
  const View &at = world_.engine.at;
  if (at.tag[b] < at.tag[a]) std::swap(a, b);
  if (!at.owned(a)) return;
  const int i = at.tag[a], j = at.tag[b];
  if (at.images.any) b = world_.engine.local(j);  // of several ghosts, or a ghost and its own sphere, the one that is used
  const double radii = world_.spheres.radius(i) + world_.spheres.radius(j);
  const double reach = radii + films_.thickness(a) + films_.thickness(b);
  const double gap = norm(at.apart(a, b)) - reach - ROUND_OFF * radii;
  found_.push_back(Pair{i, j, a, b, bridge_of(SPHERE, a, j), radii, gap});
}

// Displacement of sphere and wall and growth of their films before they touch, from the state at the search; `distance`: of the
// centre from the part now, or a lower bound.
double NearPairs::rest(const WallPair &pair, double distance) const {
  if (world_.walls.mesh_of(pair.j).turns) return 0;
  const double reach =
      world_.spheres.radius(pair.i) * (1 + ROUND_OFF) + films_.thickness_then[pair.a] + films_.part_thickness_then[pair.j];
  return distance - reach + travel_ + wall_travel_;
}

void NearPairs::find_walls() {
  const View &at = world_.engine.at;
  const Walls &walls = world_.walls;
  std::vector<WallPair> before;          // closest points are reused across searches
  before.swap(wall_pairs_);
  std::unordered_map<int, size_t> known;  // sphere -> its first pair
  for (size_t c = 0; c < before.size(); c++) known.emplace(before[c].i, c);
  auto site_of = [&](int i, int part) {
    const auto first = known.find(i);
    for (size_t c = first == known.end() ? before.size() : first->second; c < before.size() && before[c].i == i; c++)
      if (before[c].j == part) return std::move(before[c].site);
    return walls.site_at(part);
  };
  wall_rest_.clear();
  // before the next rebuild a sphere may move by half the skin and a mesh by its limit; films may grow meanwhile: one skin more
  const double thickest = films_.thickest_part();
  std::vector<char> here(walls.meshes.size());
  for (int a = 0; a < at.nlocal; a++) {
    const int i = at.tag[a];
    const double far = films_.reach(a) + 1.5 * world_.engine.skin + world_.engine.mesh_way();
    for (size_t m = 0; m < walls.meshes.size(); m++) {
      here[m] = walls.outside(walls.meshes[m], walls.meshes[m].bounds, Vec(at.x[a])) < far + thickest;
    }
    for (size_t p = 0; p < walls.parts.size(); p++) {
      const size_t m = walls.parts[p].mesh;
      if (!here[m]) continue;
      double distance = walls.outside(walls.meshes[m], walls.parts[p].bounds, Vec(at.x[a]));
      if (distance >= far + films_.part_thickness(int(p))) continue;
      wall_pairs_.push_back(WallPair{i, int(p), a, site_of(i, int(p))});
      const Site &then = wall_pairs_.back().site;
      if (then.distance_then >= 0 && !walls.images.any)
        distance = std::max(distance, then.distance_then - norm(walls.meshes[m].to_rest(Vec(at.x[a])) - then.reference));
      const int bridge = bridge_of(LARGE_WALL, a, int(p));
      if (bridge >= 0) standing_.bridges[bridge].candidate = int(wall_rest_.size());
      wall_rest_.push_back(bridge < 0 ? rest(wall_pairs_.back(), distance) : INF);
    }
  }
}

// The sphere that moves furthest in a step relative to its radius; more than a tenth is too fast for a contact to be resolved.
void NearPairs::refuse_fast(int known) const {
  const View &at = world_.engine.at;
  double furthest = 0.1;
  int which = -1;
  for (int a = 0; a < known; a++) {
    const double way = at.dt * norm(Vec(at.v[a])) / world_.spheres.radius(at.tag[a]);
    if (way <= furthest) continue;
    furthest = way;
    which = a;
    if (std::isnan(way)) break;
  }
  if (which >= 0)
    throw std::runtime_error("sphere " + std::to_string(at.tag[which]) + " moves at " + number(norm(Vec(at.v[which]))) +
                             " m/s at step " + std::to_string(world_.clock.now) +
                             ", more than a tenth of its radius in one step; likely an unstable run: lower the time step");
}

void NearPairs::move_on(double moved) {
  const View &at = world_.engine.at;
  double fastest = 0;
  const int known = world_.ranks.alone() ? at.nlocal : at.nall;
  for (int a = 0; a < known; a++) {
    const double *v = at.v[a];
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (!(square <= fastest)) {
      fastest = square;
      if (std::isnan(square)) break;
    }
  }
  const std::vector<double> &radii = world_.spheres.type_radius;
  const double way = at.dt * std::sqrt(fastest);
  if (known > 0 && !(way <= 0.1 * *std::min_element(radii.begin(), radii.end()))) refuse_fast(known);
  travel_ += moved < INF ? moved : way;
  double furthest = 0;
  for (size_t m = 0; m < shift_before_.size(); m++) {
    furthest = std::max(furthest, norm(world_.walls.meshes[m].shift - shift_before_[m]));
    shift_before_[m] = world_.walls.meshes[m].shift;
  }
  wall_travel_ += furthest;
}

void NearPairs::form(std::vector<Event> &events, int kind, int i, int j, int pair, const Geometry &g, double drawn_i,
                     double drawn_j) {
  const double r = kind == SPHERE ? 2 * g.radius_i * g.radius_j / (g.radius_i + g.radius_j) : g.radius_i;
  if (!(drawn_i >= 0) || !(drawn_j >= 0))
    throw std::runtime_error("the formation law draws a share below zero from " +
                             std::string(drawn_i >= 0 ? "the partner of sphere " : "sphere ") + std::to_string(i) + " at step " +
                             std::to_string(world_.clock.now) + "; expected zero or more: fix the law");
  if (!(drawn_i + drawn_j > SMALLEST_BRIDGE * r * r * r)) return;
  Event e = {};
  e.step = world_.clock.now; e.time = world_.clock.time; e.kind = FORMATION; e.partner_kind = kind;
  e.i = i; e.j = j; e.triangle = g.triangle;
  e.share_i = drawn_i; e.share_j = drawn_j;
  e.separation = g.separation;
  e.speed = norm(g.vi - g.vj);
  proposed_[key_of(kind, i, j)] = pair;
  events.push_back(e);
}

void NearPairs::propose(std::vector<Event> &events) {
  proposed_.clear();
  propose_pairs(events);
  propose_walls(events);
}

void NearPairs::propose_pairs(std::vector<Event> &events) {
  const View &at = world_.engine.at;
  const Laws &laws = world_.laws;
  const double way = 2 * (travel_ + films_.thicker);
  while (active_classes_ < CLASSES && active_classes_ * CLASS * world_.engine.skin <= way) active_ = first_[++active_classes_];
  for (size_t c = 0; c < active_; c++) {
    if (rest_[c] > way) continue;
    const Pair &pair = pairs_[c];
    const double *x = at.x[pair.a], *y = at.x[pair.b];
    const Vec d = at.images.nearest(Vec(x[0] - y[0], x[1] - y[1], x[2] - y[2]));
    const double square = d.x * d.x + d.y * d.y + d.z * d.z;
    const double touch = pair.radii + films_.thickness(pair.a) + films_.thickness(pair.b);
    if (square >= touch * touch) {
      const double then = pair.radii * (1 + ROUND_OFF) + films_.thickness_then[pair.a] + films_.thickness_then[pair.b];
      rest_[c] = std::sqrt(square) - then + 2 * travel_;
      continue;
    }
    const Geometry g = between_spheres(world_, pair.a, pair.b, world_.spheres.radius(pair.i), world_.spheres.radius(pair.j));
    check_overlap(world_, g, SPHERE, pair.i, pair.j);
    form(events, SPHERE, pair.i, pair.j, int(c), g, laws.from_sphere(held(films_.volume(pair.a)), g.radius_i, g.radius_j),
         laws.from_sphere(held(films_.volume(pair.b)), g.radius_j, g.radius_i));
  }
}

// At a convex edge two faces of a mesh share a closest point and have one bridge. Tests whether another face already has it: the
// closest point of this face also lies on that one, which continues from there closer to the sphere; or the foot of the sphere's bridge
// with it, from before or from this step, is that point, or a point of this face from which this one continues closer. A rim, whose
// closest point is elsewhere, does not suppress a bridge.
bool NearPairs::given_to_neighbour(size_t c, const Closest &own) {
  const WallPair &mine = wall_pairs_[c];
  const Walls &walls = world_.walls;
  const double near = ONE_PLACE * world_.spheres.radius(mine.i);
  size_t first = c, last = c + 1;
  while (first > 0 && wall_pairs_[first - 1].i == mine.i) first--;
  while (last < wall_pairs_.size() && wall_pairs_[last].i == mine.i) last++;
  for (size_t k = first; k < last; k++) {
    WallPair &other = wall_pairs_[k];
    if (k == c || other.site.mesh != mine.site.mesh) continue;
    const bool bridged = wall_rest_[k] == INF || proposed_.count(key_of(LARGE_WALL, mine.i, other.j));  // for either kind of wall
    const Vec x(world_.engine.at.x[other.a]);
    if (walls.on_border(other.j, own.point, near) && walls.goes_on(other.j, own.point, x, near)) return true;
    if (!bridged) continue;
    const Vec foot = walls.closest(x, other.site).point;
    const bool same = norm(foot - own.point) <= near;  // also for coincident faces, as where wires cross
    if (same || (walls.on_border(mine.j, foot, near) && walls.goes_on(mine.j, foot, x, near))) return true;
  }
  return false;
}

void NearPairs::propose_walls(std::vector<Event> &events) {
  const View &at = world_.engine.at;
  const Walls &walls = world_.walls;
  const Laws &laws = world_.laws;
  const double way = travel_ + wall_travel_ + films_.thicker + films_.wall_thicker;
  for (size_t c = 0; c < wall_rest_.size(); c++) {
    if (wall_rest_[c] > way) continue;
    WallPair &pair = wall_pairs_[c];
    const Part &part = walls.parts[pair.j];
    const double far = walls.outside(walls.mesh_of(pair.j), part.bounds, Vec(at.x[pair.a]));
    if (far >= films_.reach(pair.a) + films_.part_thickness(pair.j) && far > 0) {
      wall_rest_[c] = rest(pair, far);
      continue;
    }
    const Closest near = walls.closest(Vec(at.x[pair.a]), pair.site);
    const double w = held(films_.at_wall(near.triangle)) / walls.film_area[walls.film_of[near.triangle]];
    if (near.distance >= films_.reach(pair.a) + w) {
      wall_rest_[c] = rest(pair, near.distance);
      continue;
    }
    if (given_to_neighbour(c, near)) {
      wall_rest_[c] = 0;
      continue;
    }
    const Geometry g = at_wall(world_, pair.a, world_.spheres.radius(pair.i), pair.j, near);
    check_overlap(world_, g, LARGE_WALL, pair.i, pair.j);
    const bool wire = part.half_width < g.radius_i;
    const double drawn = wire ? laws.from_sphere_at_wire(held(films_.volume(pair.a)), g.radius_i, part.half_width)
                              : laws.from_sphere(held(films_.volume(pair.a)), g.radius_i, INF);
    const double drawn_w = wire ? laws.from_wire(w, g.radius_i, part.half_width) : laws.from_wall(w, g.radius_i);
    form(events, wire ? SMALL_WALL : LARGE_WALL, pair.i, pair.j, int(c), g, drawn, drawn_w);
  }
}

}  // namespace pywet
