// Physics and bookkeeping of the bridges; the engine is only asked for positions, velocities and neighbour lists.
#include "bridges.h"

#include <algorithm>
#include <cmath>

// engine headers, in the order in which they compile outside the engine's own tree
#include "mpi.h"
#include "fix_insert_stream.h"
#include "global_properties.h"
#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix_mesh_surface.h"
#include "force.h"
#include "lammps.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair.h"
#include "tri_mesh.h"
#include "update.h"

namespace pywet {

static const double PI = 3.14159265358979323846;
static const double INF = std::numeric_limits<double>::infinity();
static const double SMALLEST_BRIDGE = 1e-12;  // V* below which nothing forms: numerical zero, 1e-4 of the radius in size

static double film_thickness(double volume, double r) {
  const double q = 3.0 * volume / (4.0 * PI * r * r * r);
  return r * std::expm1(std::log1p(q) / 3.0);  // (3L/4pi + r^3)^(1/3) - r without cancellation
}

void Bridges::set_film(int id, double volume) {
  film[id] = volume;
  thickness_[id] = film_thickness(std::max(volume, 0.0), radius(id));
  const double allowed = (lmp_->neighbor->contactDistanceFactor - 1.0) * radius(id);
  if (thickness_[id] > allowed && volume > 0)
    throw std::runtime_error("the film on sphere " + std::to_string(id) + " has grown to " + std::to_string(1e3 * thickness_[id]) +
                             " mm, the neighbour list sees films up to " + std::to_string(1e3 * allowed) +
                             " mm; raise FILM_GROWTH in pywet/engines/liggghts/deck.py");
}

int Bridges::local(int id) const { return lmp_->atom->map(id); }

bool Bridges::owned(int id) const {
  const int k = local(id);
  return k >= 0 && k < lmp_->atom->nlocal;
}

void Bridges::attach(LAMMPS_NS::LAMMPS *lmp, const std::string &directory) {
  lmp_ = lmp;
  world_ = lmp->world;
  MPI_Comm_rank(world_, &rank_);
  MPI_Comm_size(world_, &ranks_);
  thickness_.assign(film.size(), 0.0);
  long double sum = 0;
  for (size_t id = 1; id < film.size(); id++)
    if (type_of[id] > 0) {
      set_film(int(id), film[id]);
      sum += film[id];
    }
  initial_ = double(sum);
  walls.finish();
  part_thickness_.assign(walls.parts.size(), 0.0);
  margin_ = 0.1 * *std::min_element(type_radius.begin(), type_radius.end());
  const std::string end = "." + std::to_string(rank_) + ".bin";
  contact_log_.open(directory + "/contacts" + end);
  if (rank_ == 0) {
    event_log_.open(directory + "/events" + end);
    ledger_log_.open(directory + "/ledger" + end);
    film_log_.open(directory + "/films" + end);
    wall_film_log_.open(directory + "/wall_films" + end);
  }
  bridge_log_.open(directory + "/bridges" + end);
}

// ---- what the engine knows ------------------------------------------------------------------------------------------------

void Bridges::read_mesh_motion() {
  const size_t n = walls.meshes.size();
  std::vector<double> mine(6 * n, -INF), all(6 * n);
  for (size_t m = 0; m < n; m++) {
    Mesh &mesh = walls.meshes[m];
    LAMMPS_NS::Fix *fix = lmp_->modify->find_fix_id(mesh.name.c_str());
    LAMMPS_NS::FixMeshSurface *surface = dynamic_cast<LAMMPS_NS::FixMeshSurface *>(fix);
    if (!surface) throw std::runtime_error("the deck has no fix mesh/surface named " + mesh.name);
    LAMMPS_NS::TriMesh *tri = surface->triMesh();
    if (tri->sizeGlobal() != mesh.count)
      throw std::runtime_error("mesh " + mesh.name + " has " + std::to_string(tri->sizeGlobal()) +
                               " triangles in the engine, expected " + std::to_string(mesh.count));
    if (tri->isRotating()) throw std::runtime_error("mesh " + mesh.name + " rotates; liquid films need walls that only translate");
    if (tri->sizeLocal() == 0) continue;
    double node[3];
    tri->node(0, 0, node);
    const Vec shift = Vec(node) - walls.triangles[mesh.first + tri->id(0)].a;
    store(shift, &mine[6 * m]);
    LAMMPS_NS::MultiVectorContainer<double, 3, 3> *v =
        tri->prop().getElementProperty<LAMMPS_NS::MultiVectorContainer<double, 3, 3> >("v");
    for (int k = 0; k < 3; k++) mine[6 * m + 3 + k] = v ? (*v)(0)[0][k] : 0.0;
  }
  if (ranks_ > 1 && n > 0)
    MPI_Allreduce(mine.data(), all.data(), int(6 * n), MPI_DOUBLE, MPI_MAX, world_);
  else
    all = mine;
  for (size_t m = 0; m < n; m++) {
    walls.meshes[m].shift = Vec(&all[6 * m]);
    walls.meshes[m].velocity = Vec(&all[6 * m + 3]);
  }
}

bool Bridges::pair_geometry(int i, int j, Geometry &g) const {
  const int a = local(i), b = local(j);
  if (a < 0 || b < 0)
    throw std::runtime_error("the bridge between spheres " + std::to_string(i) + " and " + std::to_string(j) +
                             " reaches beyond the ghost cut-off of this rank; enlarge ghost_cutoff in the deck");
  const LAMMPS_NS::Atom *atom = lmp_->atom;
  g.xi = Vec(atom->x[a]); g.vi = Vec(atom->v[a]); g.wi = Vec(atom->omega[a]);
  g.xj = Vec(atom->x[b]); g.vj = Vec(atom->v[b]); g.wj = Vec(atom->omega[b]);
  g.radius_i = radius(i);
  g.radius_j = radius(j);
  const Vec d = g.xi - g.xj;
  const double distance = norm(d);
  g.separation = distance - g.radius_i - g.radius_j;
  g.n = (1.0 / distance) * d;
  g.triangle = -1;
  return true;
}

void Bridges::wall_geometry(int i, int part, const Closest &c, Geometry &g) const {
  const int a = local(i);
  const LAMMPS_NS::Atom *atom = lmp_->atom;
  g.xi = Vec(atom->x[a]); g.vi = Vec(atom->v[a]); g.wi = Vec(atom->omega[a]);
  g.xj = c.point; g.vj = walls.meshes[walls.parts[part].mesh].velocity; g.wj = Vec();
  g.radius_i = radius(i);
  g.radius_j = INF;
  const Vec d = g.xi - g.xj;
  const double distance = norm(d);
  g.separation = distance - g.radius_i;
  g.n = (1.0 / distance) * d;
  g.triangle = c.triangle;
}

// Geometry of a standing bridge, false where this rank owns neither end.
bool Bridges::geometry(Bridge &b, Geometry &g) {
  if (b.kind != SPHERE) {
    if (!owned(b.i)) return false;
    const Vec x(lmp_->atom->x[local(b.i)]);
    const Closest c = walls.closest(b.j, x, b.site, margin_);
    b.triangle = c.triangle;
    wall_geometry(b.i, b.j, c, g);
    return true;
  }
  return (owned(b.i) || owned(b.j)) && pair_geometry(b.i, b.j, g);
}

// ---- candidates: pairs near enough to form a bridge before the next rebuild of the neighbour list --------------------------

void Bridges::find_candidates() {
  for (Bridge &b : bridges_) b.candidate = -1;
  find_pair_candidates();
  find_wall_candidates();
}

void Bridges::find_pair_candidates() {
  pairs_.clear();
  const LAMMPS_NS::NeighList *list = lmp_->force->pair->list;
  const LAMMPS_NS::Atom *atom = lmp_->atom;
  for (int q = 0; q < list->inum; q++) {
    const int a = list->ilist[q];
    for (int k = 0; k < list->numneigh[a]; k++) {
      const int b = list->firstneigh[a][k] & NEIGHMASK;
      int i = atom->tag[a], j = atom->tag[b];
      if (j < i) std::swap(i, j);
      if (!owned(i)) continue;  // the owner of the lower id decides
      auto it = index_.find(key(SPHERE, i, j));
      if (it != index_.end()) bridges_[it->second].candidate = int(pairs_.size());
      pairs_.push_back(Candidate{i, j, it == index_.end(), Site()});
    }
  }
}

void Bridges::find_wall_candidates() {
  wall_pairs_.clear();
  std::fill(part_thickness_.begin(), part_thickness_.end(), 0.0);
  for (size_t k = 0; k < walls.triangles.size(); k++)
    if (walls.film[k] > 0) {
      double &w = part_thickness_[walls.part_of[k]];
      w = std::max(w, walls.film[k] / walls.area[k]);
    }
  const LAMMPS_NS::Atom *atom = lmp_->atom;
  for (int a = 0; a < atom->nlocal; a++) {
    const int i = atom->tag[a];
    const Vec x(atom->x[a]);
    for (size_t p = 0; p < walls.parts.size(); p++) {
      // sphere and mesh may each move half the skin before the next rebuild; films may grow meanwhile: one skin more
      if (!walls.near_bounds(int(p), x, reach(i) + part_thickness_[p] + 2 * lmp_->neighbor->skin)) continue;
      auto it = index_.find(key(LARGE_WALL, i, int(p)));
      if (it != index_.end()) bridges_[it->second].candidate = int(wall_pairs_.size());
      wall_pairs_.push_back(Candidate{i, int(p), it == index_.end(), Site()});
    }
  }
}

// ---- formation ------------------------------------------------------------------------------------------------------------

void Bridges::propose(int kind, int i, int j, int candidate, const Geometry &g, double drawn_i, double drawn_j) {
  const double r = kind == SPHERE ? 2 * g.radius_i * g.radius_j / (g.radius_i + g.radius_j) : g.radius_i;
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
  const LAMMPS_NS::Atom *atom = lmp_->atom;
  for (size_t c = 0; c < pairs_.size(); c++) {
    const Candidate &pair = pairs_[c];
    if (!pair.active) continue;
    const int a = local(pair.i), b = local(pair.j);
    if (a < 0 || b < 0) continue;
    const double *x = atom->x[a], *y = atom->x[b];
    const double dx = x[0] - y[0], dy = x[1] - y[1], dz = x[2] - y[2];
    const double touch = reach(pair.i) + reach(pair.j);
    if (dx * dx + dy * dy + dz * dz >= touch * touch) continue;
    Geometry g;
    pair_geometry(pair.i, pair.j, g);
    propose(SPHERE, pair.i, pair.j, int(c), g, laws.from_sphere(film[pair.i], g.radius_i, g.radius_j),
            laws.from_sphere(film[pair.j], g.radius_j, g.radius_i));
  }
}

void Bridges::propose_walls() {
  for (size_t c = 0; c < wall_pairs_.size(); c++) {
    Candidate &pair = wall_pairs_[c];
    if (!pair.active) continue;
    const Part &part = walls.parts[pair.j];
    const Vec x(lmp_->atom->x[local(pair.i)]);
    const double widest = reach(pair.i) + part_thickness_[pair.j];
    if (pair.site.distance_then >= 0) {
      const double slack = pair.site.distance_then - widest;
      const Vec moved = x - walls.meshes[part.mesh].shift - pair.site.reference;
      if (slack > 0 && dot(moved, moved) < slack * slack) continue;
    }
    const Closest near = walls.closest(pair.j, x, pair.site, margin_);
    const double w = walls.film[near.triangle] / walls.area[near.triangle];
    if (near.distance >= reach(pair.i) + w) continue;
    Geometry g;
    wall_geometry(pair.i, pair.j, near, g);
    const bool wire = part.half_width < g.radius_i;
    const double drawn = wire ? laws.from_sphere_at_wire(film[pair.i], g.radius_i, part.half_width)
                              : laws.from_sphere(film[pair.i], g.radius_i, INF);
    const double drawn_w = wire ? laws.from_wire(w, g.radius_i, part.half_width) : laws.from_wall(w, g.radius_i);
    propose(wire ? SMALL_WALL : LARGE_WALL, pair.i, pair.j, int(c), g, drawn, drawn_w);
  }
}

// ---- forces and rupture ---------------------------------------------------------------------------------------------------

double Bridges::reduced_volume(const Bridge &b) const {
  const double ri = radius(b.i);
  const double r = b.kind == SPHERE ? 2 * ri * radius(b.j) / (ri + radius(b.j)) : ri;
  return b.volume / (r * r * r);
}

double Bridges::share(const Bridge &b) const {
  const int other = b.kind == SPHERE ? type_of[b.j] : walls.parts[b.j].group;
  return b.volume * transfer.ratio(b.kind, type_of[b.i], other, reduced_volume(b));
}

double Bridges::rupture_limit(const Bridge &b, const Geometry &g) const {
  if (!laws.dynamic_rupture) return b.rupture_distance;
  return b.rupture_distance * laws.dynamic_rupture(norm(g.vi - g.vj), laws.viscosity, laws.surface_tension);
}

void Bridges::act(const Bridge &b, const Geometry &g, bool log) {
  const double tj = angle_j(b.kind, b.j), eta = laws.viscosity;
  const Vec v = g.vi - g.vj;
  const double vn = dot(v, g.n);
  double capillary = 0, viscous = 0;
  Vec tangential;
  if (laws.capillary)
    capillary = laws.capillary(g.separation, b.volume, g.radius_i, g.radius_j, angle(b.i), tj, laws.surface_tension);
  if (laws.viscous_normal) viscous = laws.viscous_normal(g.separation, b.volume, g.radius_i, g.radius_j, vn, eta);
  if (laws.translation) {
    const double rj = b.kind == SPHERE ? g.radius_j : 0.0;  // a wall does not spin
    const Vec spin = cross(g.n, g.radius_i * g.wi + rj * g.wj);
    tangential = (-laws.translation(g.separation, g.radius_i, g.radius_j, eta)) * (v - vn * g.n) +
                 (-laws.rotation(g.separation, g.radius_i, g.radius_j, eta)) * spin;
  }
  const Vec force = (viscous - capillary) * g.n + tangential;
  const Vec turn = cross(g.n, tangential);
  const Vec torque_i = (-g.radius_i) * turn, torque_j = b.kind == SPHERE ? (-g.radius_j) * turn : Vec();
  if (!std::isfinite(dot(force, force)))
    throw std::runtime_error("a force law gave a value that is not finite for the bridge of sphere " + std::to_string(b.i) +
                             (b.kind == SPHERE ? " and sphere " : " and wall part ") + std::to_string(b.j) + " at step " +
                             std::to_string(now_) + " (separation " + std::to_string(g.separation) + " m)");
  LAMMPS_NS::Atom *atom = lmp_->atom;
  if (owned(b.i)) {
    accumulate(atom->f[local(b.i)], force);
    accumulate(atom->torque[local(b.i)], torque_i);
  }
  if (b.kind == SPHERE && owned(b.j)) {
    accumulate(atom->f[local(b.j)], (-1.0) * force);
    accumulate(atom->torque[local(b.j)], torque_j);
  }
  if (!log || !owned(b.i)) return;
  Contact c = {};
  c.step = now_; c.time = time_; c.partner_kind = b.kind; c.i = b.i; c.j = b.j; c.triangle = g.triangle;
  store(g.xi, c.xi); store(g.vi, c.vi); store(g.wi, c.wi);
  store(g.xj, c.xj); store(g.vj, c.vj); store(g.wj, c.wj);
  c.volume = b.volume; c.separation = g.separation; c.rupture_distance = rupture_limit(b, g);
  c.capillary = capillary; c.viscous_normal = viscous;
  store(tangential, c.viscous_tangential); store(force, c.force_i);
  store(torque_i, c.torque_i); store(torque_j, c.torque_j);
  contact_log_.write(c);
}

void Bridges::stand_or_rupture(bool decide, bool log) {
  for (Bridge &b : bridges_) {
    Geometry g;
    if (!geometry(b, g)) continue;
    if (decide && g.separation >= b.rupture_distance && g.separation >= rupture_limit(b, g)) {
      if (!owned(b.i)) continue;
      Event e = {};
      e.step = now_; e.time = time_; e.kind = RUPTURE; e.partner_kind = b.kind;
      e.i = b.i; e.j = b.j; e.triangle = g.triangle;
      e.volume = b.volume;
      e.share_i = share(b);
      e.share_j = b.volume - e.share_i;
      e.separation = g.separation; e.rupture_distance = b.rupture_distance; e.speed = norm(g.vi - g.vj);
      events_.push_back(e);
      continue;
    }
    act(b, g, log);
  }
}

// ---- booking: every rank books the same events in the same order ----------------------------------------------------------

void Bridges::gather_events() {
  if (ranks_ > 1) {
    int mine = int(events_.size()), all = 0;
    MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_SUM, world_);
    if (all > 0) {
      std::vector<int> bytes(ranks_), offset(ranks_, 0);
      int size = mine * int(sizeof(Event));
      MPI_Allgather(&size, 1, MPI_INT, bytes.data(), 1, MPI_INT, world_);
      for (int k = 1; k < ranks_; k++) offset[k] = offset[k - 1] + bytes[k - 1];
      std::vector<Event> gathered(all);
      MPI_Allgatherv(events_.data(), size, MPI_BYTE, gathered.data(), bytes.data(), offset.data(), MPI_BYTE, world_);
      events_.swap(gathered);
    }
  }
  std::sort(events_.begin(), events_.end(), [](const Event &a, const Event &b) {
    if (a.kind != b.kind) return a.kind < b.kind;
    if (a.partner_kind != b.partner_kind) return a.partner_kind < b.partner_kind;
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
}

void Bridges::book_formations() {
  std::unordered_map<int, double> asked, asked_wall;
  for (const Event &e : events_)
    if (e.kind == FORMATION) {
      asked[e.i] += e.share_i;
      if (e.partner_kind == SPHERE) asked[e.j] += e.share_j;
      else asked_wall[e.triangle] += e.share_j;
    }
  auto part_of = [](double held, double ask) { return ask > held ? held / ask : 1.0; };
  std::unordered_map<int, double> grant, grant_wall;  // from the films at the start of the step
  for (auto &a : asked) grant[a.first] = part_of(film[a.first], a.second);
  for (auto &a : asked_wall) grant_wall[a.first] = part_of(walls.film[a.first], a.second);
  for (Event &e : events_)
    if (e.kind == FORMATION) {
      e.share_i *= grant[e.i];
      e.share_j *= e.partner_kind == SPHERE ? grant[e.j] : grant_wall[e.triangle];
      e.volume = e.share_i + e.share_j;
      Bridge b{e.partner_kind, e.i, e.j, e.volume, 0.0};
      const double rj = e.partner_kind == SPHERE ? radius(e.j) : INF;
      b.rupture_distance = laws.rupture(e.volume, radius(e.i), rj, angle(e.i), angle_j(e.partner_kind, e.j));
      e.rupture_distance = b.rupture_distance;
      b.triangle = e.triangle;
      auto it = proposed_.find(key(e.partner_kind, e.i, e.j));
      if (it != proposed_.end()) {
        b.candidate = it->second;
        (e.partner_kind == SPHERE ? pairs_ : wall_pairs_)[it->second].active = false;
      }
      index_[key(e.partner_kind, e.i, e.j)] = int(bridges_.size());
      bridges_.push_back(b);
      formations_++;
    }
}

void Bridges::book_ruptures() {
  for (const Event &e : events_)
    if (e.kind == RUPTURE) {
      const uint64_t k = key(e.partner_kind, e.i, e.j);
      const int at = index_.at(k);
      const int c = bridges_[at].candidate;
      if (c >= 0) (e.partner_kind == SPHERE ? pairs_ : wall_pairs_)[c].active = true;
      index_.erase(k);
      if (at != int(bridges_.size()) - 1) {
        bridges_[at] = std::move(bridges_.back());
        index_[key(bridges_[at].kind, bridges_[at].i, bridges_[at].j)] = at;
      }
      bridges_.pop_back();
      ruptures_++;
    }
}

void Bridges::book() {
  for (Event &e : events_) {
    e.film_i_before = film[e.i];
    e.film_j_before = e.partner_kind == SPHERE ? film[e.j] : walls.film[e.triangle];
  }
  book_formations();
  book_ruptures();
  for (const Event &e : events_) {
    const double sign = e.kind == FORMATION ? -1.0 : 1.0;
    set_film(e.i, film[e.i] + sign * e.share_i);
    if (e.partner_kind == SPHERE) {
      set_film(e.j, film[e.j] + sign * e.share_j);
    } else {
      double &w = walls.film[e.triangle];
      w += sign * e.share_j;
      double &widest = part_thickness_[walls.part_of[e.triangle]];
      widest = std::max(widest, w / walls.area[e.triangle]);
    }
  }
  for (Event &e : events_) {
    e.film_i_after = film[e.i];
    e.film_j_after = e.partner_kind == SPHERE ? film[e.j] : walls.film[e.triangle];
    if (rank_ == 0) event_log_.write(e);
  }
}

// ---- output ---------------------------------------------------------------------------------------------------------------

bool Bridges::logging() const {
  for (size_t k = 0; k < window_first.size(); k++)
    if (now_ >= window_first[k] && now_ < window_last[k]) return true;
  return false;
}

void Bridges::write_ledger() {
  Ledger l = {};
  l.step = now_; l.time = time_; l.initial = initial_;
  long double films = 0, standing = 0, wall = 0;
  for (size_t id = 1; id < film.size(); id++)
    if (type_of[id] > 0) {
      films += film[id];
      l.spheres++;
    }
  for (const Bridge &b : bridges_) standing += b.volume;
  for (double w : walls.film) wall += w;
  l.films = double(films); l.bridges = double(standing); l.walls = double(wall);
  l.spheres = lmp_->atom->natoms;
  l.bridge_count = int64_t(bridges_.size());
  l.formations = formations_; l.ruptures = ruptures_;
  ledger_log_.write(l);
}

void Bridges::snapshot() {
  for (Bridge &b : bridges_) {
    Geometry g;
    if (!owned(b.i) || !geometry(b, g)) continue;
    BridgeSnapshot s = {};
    s.step = now_; s.partner_kind = b.kind; s.i = b.i; s.j = b.j; s.triangle = g.triangle;
    s.volume = b.volume; s.share_i = share(b); s.separation = g.separation;
    store(g.xi, s.xi); store(g.xj, s.xj);
    bridge_log_.write(s);
  }
  if (rank_ == 0) {
    write_ledger();
    for (size_t id = 1; id < film.size(); id++)
      if (type_of[id] > 0) film_log_.write(Film{now_, int32_t(id), 0, film[id]});
    for (size_t k = 0; k < walls.film.size(); k++)
      if (walls.film[k] > 0) wall_film_log_.write(Film{now_, int32_t(k), 0, walls.film[k]});
  }
  flush();
}

void Bridges::flush() {
  for (RecordFile *log : {&event_log_, &contact_log_, &ledger_log_, &bridge_log_, &film_log_, &wall_film_log_}) log->flush();
}

void Bridges::step(int64_t n) {
  const bool again = n == now_;  // the set-up of a further run repeats the last step: forces only, nothing is booked twice
  now_ = n;
  time_ = n * lmp_->update->dt;
  read_mesh_motion();
  if (again || lmp_->neighbor->ago == 0 || lmp_->neighbor->lastcall == n) find_candidates();
  events_.clear();
  proposed_.clear();
  stand_or_rupture(!again, !again && logging());
  if (again) return;
  propose_pairs();
  propose_walls();
  gather_events();
  if (!events_.empty()) book();
  if (std::binary_search(output_steps.begin(), output_steps.end(), n)) snapshot();
}

}  // namespace pywet
