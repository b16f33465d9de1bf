// Shedding: liquid that a sphere's film cannot hold under its acceleration detaches as a drop and falls straight down.
//
// Every `drop_every` steps all ranks gather positions and velocities of all spheres. The change of velocity since then, less gravity, is
// exactly the mean specific force on a sphere (zero in free fall, g upwards at rest); the film responds to it with a relaxation time (the second
// function of the law). All ranks then decide identically. Drops of a step are applied after its formations and ruptures: each sphere
// sheds at most one, from its film before any drop has arrived. A drop lands in the same step, on the first surface below the sphere's centre along
// gravity (its fall takes no time): a sphere, a wall triangle, or none, in which case it has left. A sphere whose film would exceed
// the range of the neighbour list is skipped.
#include "shedding.h"

#include <algorithm>
#include <cmath>

namespace pywet {

static const double FULL = 0.8;  // relative to the thickest film that the neighbour list covers
static const int SAMPLES = 8;
static const int STATE = 8;      // here (0: not on any rank), position, velocity, film
static const double THERE = 1, WAITS = 2;

// Position, velocity and film of every sphere, by id. One that waits to enter has no film yet.
std::vector<double> Shedding::everywhere() const {
  const View &at = world_.engine.at;
  std::vector<double> mine(STATE * world_.spheres.ids(), 0.0), all;
  for (int a = 0; a < at.nlocal; a++) {
    double *p = &mine[STATE * at.tag[a]];
    const bool waits = world_.feed.waits(at, a, world_.clock.now);
    p[0] = waits ? WAITS : THERE;
    std::copy(at.x[a], at.x[a] + 3, p + 1);
    std::copy(at.v[a], at.v[a] + 3, p + 4);
    p[7] = waits ? 0 : films_.volume(a);
  }
  if (world_.ranks.alone()) return mine;
  all.resize(mine.size());
  MPI_Allreduce(mine.data(), all.data(), int(mine.size()), MPI_DOUBLE, MPI_SUM, world_.ranks.all);
  return all;
}

// Mean specific force on every sphere, low-pass filtered as its film responds.
void Shedding::feel(const std::vector<double> &now) {
  const Laws &laws = world_.laws;
  const size_t ids = world_.spheres.ids();
  if (speed_then_.empty()) {
    felt_.assign(3 * ids, 0.0);
    speed_then_.resize(felt_.size());
  } else {
    const Vec &gravity = world_.rules.gravity;
    const double span = world_.clock.drop_every * world_.engine.at.dt, g[3] = {gravity.x, gravity.y, gravity.z};
    for (size_t id = 1; id < ids; id++) {
      const double film = now[STATE * id + 7];
      if (!(film > 0)) continue;
      const double part = -std::expm1(-span / laws.shed_time(film, world_.rules.density, laws.surface_tension));
      for (int k = 0; k < 3; k++) {
        const double mean = (now[STATE * id + 4 + k] - speed_then_[3 * id + k]) / span - g[k];
        felt_[3 * id + k] += part * (mean - felt_[3 * id + k]);
      }
    }
  }
  for (size_t id = 1; id < ids; id++)
    for (int k = 0; k < 3; k++) speed_then_[3 * id + k] = now[STATE * id + 4 + k];
}

// Writes the filtered force of some spheres for the replay: SAMPLES on average, scattered over the ids; all if there are fewer.
void Shedding::record(const std::vector<double> &now) const {
  const uint64_t most = (uint64_t(SAMPLES) << 32) / uint64_t(std::max<int64_t>(world_.spheres.count, SAMPLES));
  for (size_t id = 1; id < world_.spheres.ids(); id++) {
    if (!(now[STATE * id] > 0) || uint32_t(id * 2654435761u) >= most) continue;
    Felt f = {world_.clock.now, int32_t(id), 0, now[STATE * id + 7], {}, {}};
    std::copy(&now[STATE * id + 4], &now[STATE * id + 7], f.v);
    std::copy(&felt_[3 * id], &felt_[3 * id + 3], f.felt);
    logs_.write(f);
  }
}

// Distance along `down` at which a ray from y hits a triangle; infinity if it does not (Moeller and Trumbore 1997).
static double meets(const Vec &y, const Vec &down, const Triangle &t) {
  const Vec e = t.b - t.a, f = t.c - t.a, p = cross(down, f);
  const double det = dot(e, p);
  if (det == 0) return INF;
  const Vec s = y - t.a, q = cross(s, e);
  const double u = dot(s, p) / det, v = dot(down, q) / det, way = dot(f, q) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && way > 0 ? way : INF;
}

// Finds where the drop of sphere d.i lands; `coming`: what other drops of the step bring to each sphere.
void Shedding::land(const std::vector<double> &now, const std::vector<double> &coming, Drop &d) const {
  const Vec &gravity = world_.rules.gravity;
  const Walls &walls = world_.walls;
  const Vec x(&now[STATE * d.i + 1]), down = (1 / norm(gravity)) * gravity;
  d.partner_kind = LEFT;
  d.j = -1;
  d.fallen = INF;
  for (size_t id = 1; id < world_.spheres.ids(); id++) {
    if (int(id) == d.i || now[STATE * id] != THERE) continue;
    const Vec r = Vec(&now[STATE * id + 1]) - x;
    const double along = dot(r, down), own = world_.spheres.radius(int(id)), offset2 = dot(r, r) - along * along;
    if (along <= 0 || offset2 >= own * own) continue;
    const double way = along - std::sqrt(own * own - offset2);
    const double film = now[STATE * id + 7] + coming[id] + d.volume;
    if (way >= d.fallen || film_thickness(film, own) > FULL * world_.engine.thickest_film * own) continue;
    d.fallen = way;
    d.partner_kind = SPHERE;
    d.j = int(id);
  }
  for (const Part &part : walls.parts) {
    const Mesh &mesh = walls.meshes[part.mesh];
    const Vec y = mesh.to_rest(x), turned = mesh.turns ? mesh.turn.back(down) : down;
    for (int k : part.triangles) {
      const double way = meets(y, turned, walls.triangles[k]);
      if (way >= d.fallen) continue;
      d.fallen = way;
      d.partner_kind = part.half_width < world_.spheres.radius(d.i) ? SMALL_WALL : LARGE_WALL;
      d.j = k;
    }
  }
  if (d.j < 0) d.fallen = 0;
}

void Shedding::fall(std::vector<double> &now, Drop &d) {
  double &film_i = now[STATE * d.i + 7];
  d.film_i_before = film_i;
  if (d.partner_kind == SPHERE) {
    double &film_j = now[STATE * d.j + 7];
    d.film_j_before = film_j;
    film_j += d.volume;
    films_.add(d.j, d.volume);
  } else if (d.partner_kind == LEFT) {
    d.film_j_before = films_.left;
    films_.left += d.volume;
  } else {
    d.film_j_before = films_.at_wall(d.j);
    films_.add_to_wall(d.j, d.volume);
  }
  film_i -= d.volume;
  films_.add(d.i, -d.volume);
  weight_.carry(d);
  logs_.write(d);
}

void Shedding::shed() {
  const Laws &laws = world_.laws;
  if (!laws.shed_drop || !world_.clock.drops_fall()) return;
  std::vector<double> now = everywhere();
  feel(now);
  record(now);
  std::vector<Drop> drops;
  std::vector<double> coming(world_.spheres.ids(), 0.0);
  for (size_t id = 1; id < world_.spheres.ids(); id++) {
    const double film = now[STATE * id + 7];
    if (!(film > 0)) continue;
    Drop d = {};
    const Vec felt(&felt_[3 * id]);
    d.volume = laws.shed_drop(film, world_.spheres.radius(int(id)), norm(felt), world_.rules.density, laws.surface_tension);
    if (!std::isfinite(norm(felt) + d.volume))
      throw std::runtime_error("the shedding law gives a value that is not finite for sphere " + std::to_string(id) + " at step " +
                               std::to_string(world_.clock.now) + "; expected a volume and a response time: fix the law");
    if (!(d.volume > 0)) continue;
    d.step = world_.clock.now; d.time = world_.clock.time; d.i = int(id);
    store(felt, d.felt);
    store(Vec(&now[STATE * id + 1]), d.x);
    land(now, coming, d);
    if (d.partner_kind == SPHERE) coming[d.j] += d.volume;
    drops.push_back(d);
  }
  for (Drop &d : drops) fall(now, d);
}

}  // namespace pywet
