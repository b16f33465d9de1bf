#include "faces.h"

#include <algorithm>

namespace pywet {

static const double ROUND_OFF = 1e-6;   // relative to the radius: a sphere is examined this much before it reaches a plane
static const double PLACE = 1e-9;       // relative to the mesh: possible error of the engine's accumulated displacement

// For each of the given spheres: whether it reaches the plane at `height` along n.
__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
static void find_near(size_t n, const int *__restrict sphere, const double *__restrict reach, const double *__restrict places,
                      double nx, double ny, double nz, double height, unsigned *__restrict near) {
  for (size_t k = 0; k < n; k++) {
    const double *x = places + 3 * sphere[k];
    near[k] = std::fabs(nx * x[0] + ny * x[1] + nz * x[2] - height) <= reach[k];
  }
}

void Faces::arrange() {
  if (!world_.rules.touches_faces) return;
  const Walls &walls = world_.walls;
  for (const Triangle &t : walls.triangles) {
    const Vec n = cross(t.b - t.a, t.c - t.a);
    const Vec normal = (1.0 / norm(n)) * n;
    planes_.push_back(Plane{normal, dot(normal, t.a)});
  }
  const std::vector<double> &radii = world_.spheres.type_radius;
  const double reach = *std::max_element(radii.begin(), radii.end()) + 1.5 * world_.engine.skin;
  for (size_t m = 0; m < walls.meshes.size(); m++)
    if (walls.meshes[m].whole())
      surfaces_.push_back(Surface{m, Cells(walls.triangles, walls.meshes[m].first, walls.meshes[m].count, reach)});
}

std::vector<Vec> Faces::corners(const Mesh &mesh) const {
  const Bounds &b = mesh.extent;
  if (!mesh.turns) return {mesh.to_world(b.low)};
  std::vector<Vec> all;
  for (double x : {b.low.x, b.high.x})
    for (double y : {b.low.y, b.high.y})
      for (double z : {b.low.z, b.high.z}) all.push_back(mesh.to_world(Vec(x, y, z)));
  return all;
}

// Between two checks of one neighbour list a sphere moves less than one skin and a mesh less than half of one.
bool Faces::moved() const {
  const double most = 0.5 * world_.engine.skin;
  for (const Surface &surface : surfaces_) {
    const std::vector<Vec> now = corners(world_.walls.meshes[surface.mesh]);
    for (size_t k = 0; k < now.size() && k < surface.corners_then.size(); k++)
      if (norm(now[k] - surface.corners_then[k]) > most) return true;
  }
  return false;
}

std::vector<WireSpring> Faces::springs() const {
  std::vector<WireSpring> here = saved_;
  for (const Candidate &c : candidates_)
    if (c.touches) here.push_back(WireSpring{c.id, -1 - c.triangle, {c.spring[0], c.spring[1], c.spring[2]}});
  return here;
}

void Faces::take_up(const std::vector<WireSpring> &springs) {
  for (const WireSpring &s : springs)
    if (s.wire < 0) saved_.push_back(s);
}

void Faces::find() {
  std::vector<WireSpring> known = springs();
  if (!world_.ranks.alone()) known = world_.ranks.near(known);
  std::sort(known.begin(), known.end());
  saved_.clear();
  candidates_.clear();
  sphere_.clear();
  reach_.clear();
  runs_.clear();
  for (Surface &surface : surfaces_) find_on(surface, known);
  near_.resize(candidates_.size());
}

void Faces::find_on(Surface &surface, const std::vector<WireSpring> &known) {
  const View &at = world_.engine.at;
  const Mesh &mesh = world_.walls.meshes[surface.mesh];
  const double off = PLACE * norm(mesh.extent.high - mesh.extent.low);
  surface.corners_then = corners(mesh);
  surface.first = runs_.size();
  const std::vector<int> local = world_.engine.places_of_triangles(surface.mesh);
  std::vector<std::vector<int> > spheres(local.size());  // spheres near each triangle
  for (int a = 0; a < at.nlocal; a++) {
    const Vec y = mesh.to_rest(Vec(at.x[a]));
    const double far = world_.spheres.radius(at.tag[a]) + 1.5 * world_.engine.skin;
    const auto [begin, end] = surface.cells.near(y);
    for (const int *k = begin; k < end; k++) {
      if (std::fabs(dot(planes_[*k].normal, y) - planes_[*k].height) > far) continue;
      if (norm(y - closest_point(y, world_.walls.triangles[*k])) < far) spheres[*k - mesh.first].push_back(a);
    }
  }
  std::vector<int> order;
  for (size_t k = 0; k < local.size(); k++)
    if (local[k] >= 0 && !spheres[k].empty()) order.push_back(int(k));
  std::sort(order.begin(), order.end(), [&](int p, int q) { return local[p] < local[q]; });
  const size_t first = candidates_.size();
  for (int k : order) {
    const int triangle = mesh.first + k;
    runs_.push_back(Run{triangle, local[k], candidates_.size(), candidates_.size() + spheres[k].size()});
    for (int a : spheres[k]) {
      const int id = at.tag[a];
      Candidate c{id, triangle, 0, false, 0, {0, 0, 0}};
      const WireSpring wanted{id, -1 - triangle, {}};
      const auto spring = std::lower_bound(known.begin(), known.end(), wanted);
      c.touches = spring != known.end() && !(wanted < *spring);
      if (c.touches) std::copy(spring->spring, spring->spring + 3, c.spring);
      candidates_.push_back(c);
      sphere_.push_back(a);
      reach_.push_back(world_.spheres.radius(id) * (1 + ROUND_OFF) + off);
    }
  }
  surface.last = runs_.size();
  join(first);
}

// The candidates of one sphere on a surface form a cyclic list starting at `first`.
void Faces::join(size_t first) {
  const size_t none = candidates_.size();
  std::vector<size_t> latest(world_.engine.at.nlocal, none), eldest(latest);
  for (size_t c = first; c < candidates_.size(); c++) {
    size_t &before = latest[sphere_[c]];
    if (before == none) eldest[sphere_[c]] = c;
    candidates_[c].next = before;
    before = c;
  }
  for (size_t a = 0; a < latest.size(); a++)
    if (latest[a] != none) candidates_[eldest[a]].next = latest[a];
}

void Faces::touch(bool fresh) {
  if (surfaces_.empty()) return;
  if (fresh || moved()) find();
  times_++;
  for (Surface &surface : surfaces_) touch_on(surface);
}

// The engine resets the velocity of walls before the plugin's part of a set-up, after it has computed its own walls.
Vec Faces::velocity(const Mesh &mesh, const MeshNow &now, const Meeting &met, const Vec &point) const {
  if (!world_.clock.again || !now.moves) return met.velocity;
  return mesh.turns ? mesh.velocity_at(point) : met.between(mesh.velocity, mesh.velocity, mesh.velocity);
}

void Faces::touch_on(Surface &surface) {
  const View &at = world_.engine.at;
  const Mesh &mesh = world_.walls.meshes[surface.mesh];
  if (surface.first == surface.last) return;
  const MeshNow now = world_.engine.mesh_now(surface.mesh);
  const bool log = world_.clock.logs_contacts();
  parted_.clear();
  for (size_t r = surface.first; r < surface.last; r++) {
    const Run &run = runs_[r];
    const Plane &plane = planes_[run.triangle];
    const Vec n = mesh.turns ? mesh.turn(plane.normal) : plane.normal;
    const size_t count = run.last - run.first;
    find_near(count, &sphere_[run.first], &reach_[run.first], at.x[0], n.x, n.y, n.z, plane.height + dot(n, mesh.shift),
              &near_[run.first]);
    for (size_t k = run.first; k < run.last; k++) {
      Candidate &c = candidates_[k];
      Meeting met;
      const int a = sphere_[k];
      if (!near_[k] || !world_.engine.meets(now, run.local, a, met)) {
        if (c.touches) parted_.push_back(k);
        continue;
      }
      if (!take(k, met.face, now)) continue;
      const Vec v = velocity(mesh, now, met, Vec(at.x[a]) - met.from_wall);
      energy_.wall_power[CONTACT] +=
          dot(world_.engine.press(a, world_.spheres.radius(c.id), met.from_wall, met.overlap, v, c.spring), v);
      if (log)
        logs_.write(WireContact{world_.clock.now, int32_t(surface.mesh), c.triangle - mesh.first, c.id, 0,
                                {c.spring[0], c.spring[1], c.spring[2]}});
    }
  }
  for (size_t k : parted_) candidates_[k].touches = false;
}

// Whether the contact counts, by the engine's rule: of touched triangles in one plane only the first counts, and a face takes over the
// spring of the adjacent one.
bool Faces::take(size_t c, bool face, const MeshNow &now) {
  Candidate &own = candidates_[c];
  if (own.touches) {
    own.last_touch = times_;
    return true;
  }
  const int first = world_.walls.meshes[now.mesh].first;
  auto adjacent = [&](const Candidate &other) {
    return other.touches && world_.engine.in_one_plane(now, other.triangle - first, own.triangle - first);
  };
  for (size_t k = own.next; face && k != c; k = candidates_[k].next)
    if (candidates_[k].last_touch == times_ && adjacent(candidates_[k])) return false;
  own.last_touch = times_;
  std::fill(own.spring, own.spring + 3, 0.0);
  for (size_t k = own.next; face && k != c; k = candidates_[k].next)
    if (adjacent(candidates_[k])) std::copy(candidates_[k].spring, candidates_[k].spring + 3, own.spring);
  return own.touches = true;
}

}  // namespace pywet
