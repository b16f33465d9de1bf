// Forces and torques of the standing bridges, and which of them rupture.
#include "bridges.h"

#include <algorithm>
#include <cmath>

namespace pywet {

static const double PI = 3.14159265358979323846;

double film_thickness(double volume, double r) {
  const double q = 3.0 * volume / (4.0 * PI * r * r * r);
  return r * std::expm1(std::log1p(q) / 3.0);  // (3L/4pi + r^3)^(1/3) - r without cancellation
}

void Bridges::set_film(int id, double volume) {
  if (volume < -1e-12 * initial_ || !std::isfinite(volume))
    throw Stop("the film on sphere " + std::to_string(id) + " would be " + number(1e9 * volume) + " mm3 after step " +
               std::to_string(now_) + ", expected zero or more; the formation law draws more than it says");
  film[id] = volume;
  thickness_[id] = film_thickness(std::max(volume, 0.0), radius(id));
  thicker_ = std::max(thicker_, thickness_[id] - thickness_then_[id]);
  if (thickness_[id] > allowed_thickness(id) && volume > 0)
    throw Stop("the film on sphere " + std::to_string(id) + " has grown to " + number(1e3 * thickness_[id]) +
               " mm, the neighbour list sees films up to " + number(1e3 * allowed_thickness(id)) +
               " mm; raise FILM_GROWTH in pywet/engines/liggghts/deck.py");
}

// ---- geometry -------------------------------------------------------------------------------------------------------------

void Bridges::pair_geometry(int a, int b, double radius_i, double radius_j, Geometry &g) const {
  g.xi = Vec(at_.x[a]); g.vi = Vec(at_.v[a]); g.wi = Vec(at_.omega[a]);
  g.xj = Vec(at_.x[b]); g.vj = Vec(at_.v[b]); g.wj = Vec(at_.omega[b]);
  g.radius_i = radius_i;
  g.radius_j = radius_j;
  const Vec d = g.xi - g.xj;
  const double distance = norm(d);
  g.separation = distance - radius_i - radius_j;
  g.n = (1.0 / distance) * d;
  g.triangle = -1;
}

void Bridges::wall_geometry(int a, double radius_i, int part, const Closest &c, Geometry &g) const {
  g.xi = Vec(at_.x[a]); g.vi = Vec(at_.v[a]); g.wi = Vec(at_.omega[a]);
  g.xj = c.point; g.vj = walls.meshes[walls.parts[part].mesh].velocity_at(c.point); g.wj = Vec();
  g.radius_i = radius_i;
  g.radius_j = INF;
  const Vec d = g.xi - g.xj;
  const double distance = norm(d);
  g.separation = distance - radius_i;
  g.n = (1.0 / distance) * d;
  g.triangle = c.triangle;
}

void Bridges::geometry(Bridge &b, Geometry &g) {
  if (b.kind == SPHERE) {
    pair_geometry(b.a, b.b, b.radius_i, b.radius_j, g);
    return;
  }
  const Closest c = walls.closest(b.j, Vec(at_.x[b.a]), *b.site, margin_);
  b.triangle = c.triangle;
  wall_geometry(b.a, b.radius_i, b.j, c, g);
}

void Bridges::check_overlap(const Geometry &g, int kind, int i, int j) const {
  const double smaller = std::min(g.radius_i, g.radius_j);
  if (g.separation >= -largest_overlap * smaller) return;
  throw std::runtime_error("sphere " + std::to_string(i) + " overlaps " + (kind == SPHERE ? "sphere " : "wall part ") +
                           std::to_string(j) + " by " + number(-g.separation / smaller) + " of its radius at step " +
                           std::to_string(now_) + ", allowed is " + number(largest_overlap) +
                           "; likely too large a time step or too soft a contact");
}

// ---- what a bridge is ------------------------------------------------------------------------------------------------------

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

// ---- forces ---------------------------------------------------------------------------------------------------------------

Geometry Bridges::geometry_of(const Together &t, int k) const {
  const Bridge &b = bridges_[t.first + k];
  Geometry g;
  if (b.kind == SPHERE) pair_geometry(b.a, b.b, b.radius_i, b.radius_j, g);
  else wall_geometry(b.a, b.radius_i, b.j, t.near[k], g);
  return g;
}

// The engine keeps its vectors one after the other.
static Vec vector_of(double **all, int a) { return Vec(all[0] + 3 * a); }

// Where the ends of the bridges are and how they move.
void Bridges::gather(Together &t) {
  const Block &block = blocks_[t.first / BATCH];
  auto set = [&t](double (*out)[BATCH], int k, const Vec &a) {
    out[0][k] = a.x; out[1][k] = a.y; out[2][k] = a.z;
  };
  int before = -1;
  Vec x, v, w;
  for (int k = 0; k < t.n; k++) {
    const int a = block.a[k], b = block.b[k];
    t.acts[k] = a >= 0;
    if (a < 0) {  // nobody asks
      set(t.d, k, Vec(1, 0, 0)); set(t.v, k, Vec()); set(t.spin, k, Vec());
      continue;
    }
    if (a != before) {
      x = vector_of(at_.x, a); v = vector_of(at_.v, a); w = block.row[RADIUS_I][k] * vector_of(at_.omega, a);
      before = a;
    }
    if (b >= 0) {
      set(t.d, k, x - vector_of(at_.x, b)); set(t.v, k, v - vector_of(at_.v, b));
      set(t.spin, k, w + block.spin_j[k] * vector_of(at_.omega, b));
      continue;
    }
    Bridge &bridge = bridges_[t.first + k];
    const Closest &c = t.near[k] = walls.closest(bridge.j, x, *bridge.site, margin_);
    bridge.triangle = c.triangle;
    set(t.d, k, x - c.point); set(t.v, k, v - walls.meshes[walls.parts[bridge.j].mesh].velocity_at(c.point)); set(t.spin, k, w);
  }
}

// Bridges that are too deep stop the run, those that are too long rupture.
void Bridges::rupture(Together &t, bool decide) {
  const Block &block = blocks_[t.first / BATCH];
  for (int k = 0; k < t.n; k++) {
    if (!t.acts[k]) continue;
    const double gap = block.row[SEPARATION][k];
    if (gap >= block.deepest[k] && gap < block.longest[k]) continue;
    const Bridge &b = bridges_[t.first + k];
    const Geometry g = geometry_of(t, k);
    check_overlap(g, b.kind, b.i, b.j);
    if (!(decide && g.separation >= b.rupture_distance && g.separation >= rupture_limit(b, g))) continue;
    t.acts[k] = false;
    if (!owned(b.a)) continue;
    Event e = {};
    e.step = now_; e.time = time_; e.kind = RUPTURE; e.partner_kind = b.kind;
    e.i = b.i; e.j = b.j; e.triangle = g.triangle;
    e.volume = b.volume;
    e.share_i = share(b);
    e.share_j = b.volume - e.share_i;
    e.separation = g.separation; e.rupture_distance = b.rupture_distance; e.speed = norm(g.vi - g.vj);
    events_.push_back(e);
  }
}

// A law that fails half way leaves what is no number. It is asked for bridges that stand; others are at touch for it.
void Bridges::evaluate(Together &t) {
  Block &block = blocks_[t.first / BATCH];
  for (int k = 0; k < t.n; k++)
    if (!t.acts[k]) block.row[SEPARATION][k] = block.row[SPEED][k] = 0;
  const Line *lines = prepared_.data() + t.first * laws.lines;
  for (int k = 0; k < t.n; k++) t.prepared[k] = reinterpret_cast<int64_t>(lines + k * laws.lines);
  auto call = [&](Batch law, double *out, int functions) {
    std::fill(out, out + functions * BATCH, law ? std::nan("") : 0.0);
    if (law) law(t.n, block.row[0], laws.surface_tension, laws.viscosity, t.prepared, out);
  };
  call(laws.capillary, t.pull, 1);
  call(laws.viscous_normal, t.viscous, 1);
  call(laws.viscous_tangential, t.tangential[0], 2);
  if (!semi_implicit) return;
  std::fill(block.row[SPEED], block.row[SPEED] + t.n, 1.0);
  call(laws.viscous_normal, t.drag, 1);
}

// Viscous forces that wait for all others.
void Bridges::defer(Together &t) {
  for (int k = 0; k < t.n; k++) {
    Terms terms;
    terms.capillary = t.pull[k];
    terms.viscous_law = t.viscous[k];
    terms.slide = t.tangential[0][k];
    terms.roll = t.tangential[1][k];
    terms.drag = -t.drag[k];
    if (t.acts[k]) waiting_.push_back(Waiting{&bridges_[t.first + k], geometry_of(t, k), terms});
    t.viscous[k] = t.tangential[0][k] = t.tangential[1][k] = 0;
  }
}

// The force of a bridge, in the contact log and in the account of works.
void Bridges::record(const Together &t, int k, bool log) {
  const Bridge &b = bridges_[t.first + k];
  const Geometry g = geometry_of(t, k);
  Terms terms;
  terms.capillary = t.pull[k];
  terms.viscous = terms.viscous_law = t.viscous[k];
  terms.slide = t.tangential[0][k];
  terms.roll = t.tangential[1][k];
  terms.tangential = Vec(t.side[0][k], t.side[1][k], t.side[2][k]);
  if (energy) add_work(b, g, terms);
  if (log && !semi_implicit && owned(b.a)) write_contact(b, g, terms);
}

void Bridges::act_together(Together &t, bool log) {
  const Block &block = blocks_[t.first / BATCH];
  evaluate(t);
  if (semi_implicit) defer(t);
  find_forces(block, t);
  auto at = [](const double (*from)[BATCH], int k) { return Vec(from[0][k], from[1][k], from[2][k]); };
  int before = -1;  // bridges of one sphere follow each other: its sums stay at hand
  Vec f, q;
  auto put = [&] {
    if (!owned(before)) return;
    store(f, at_.f[before]);
    store(q, at_.torque[before]);
  };
  for (int k = 0; k < t.n; k++) {
    if (!t.acts[k]) continue;
    const int a = block.a[k], b = block.b[k];
    if (!(t.square[k] < INF)) not_finite(bridges_[t.first + k], block.row[SEPARATION][k]);
    if (a != before) {
      put();
      f = vector_of(at_.f, a); q = vector_of(at_.torque, a);
      before = a;
    }
    f = f + at(t.force, k);
    q = q + at(t.torque_i, k);
    if (owned(b)) {
      accumulate(at_.f[0] + 3 * b, (-1.0) * at(t.force, k));
      accumulate(at_.torque[0] + 3 * b, at(t.torque_j, k));
    }
    if (log || energy) record(t, k, log);
  }
  put();
}

// With t.kick = 0 at the present speeds; else at those of the end of the step, see implicit.cpp.
void Bridges::add_viscous(const Bridge &b, const Geometry &g, Terms &t) const {
  const Vec v = g.vi - g.vj, pushed = v + t.push;
  if (semi_implicit) {
    t.factor_normal = 1 / (1 + t.drag * t.kick);
    t.viscous = -t.drag * t.factor_normal * dot(pushed, g.n);
  }
  const double rj = b.kind == SPHERE ? g.radius_j : 0.0;  // a wall has no spin of its own about a centre
  const Vec spin = cross(g.n, g.radius_i * g.wi + rj * g.wj + t.spin_push);
  t.factor_tangential = 1 / (1 + (t.slide + 2.5 * t.roll) * t.kick);  // r^2/I = 2.5/m
  t.tangential = (-t.slide * t.factor_tangential) * (pushed - dot(pushed, g.n) * g.n) + (-t.roll * t.factor_tangential) * spin;
}

void Bridges::not_finite(const Bridge &b, double separation) const {
  throw std::runtime_error("a force law gave a value that is not finite for the bridge of sphere " + std::to_string(b.i) +
                           (b.kind == SPHERE ? " and sphere " : " and wall part ") + std::to_string(b.j) + " at step " +
                           std::to_string(now_) + " (separation " + number(separation) + " m)");
}

void Bridges::act(const Bridge &b, const Geometry &g, const Terms &t) {
  const Vec force = (t.viscous - t.capillary) * g.n + t.tangential;
  const Vec turn = cross(g.n, t.tangential);
  if (!std::isfinite(dot(force, force))) not_finite(b, g.separation);
  if (owned(b.a)) {
    accumulate(at_.f[b.a], force);
    accumulate(at_.torque[b.a], (-g.radius_i) * turn);
  }
  if (owned(b.b)) {
    accumulate(at_.f[b.b], (-1.0) * force);
    accumulate(at_.torque[b.b], (-g.radius_j) * turn);
  }
  if (energy) add_work(b, g, t);
}

void Bridges::add_work(const Bridge &b, const Geometry &g, const Terms &t) {
  const Vec turn = cross(g.n, t.tangential);
  if (owned(b.a)) energy_.add(b.a, (-t.capillary) * g.n, t.viscous * g.n, t.tangential, (-g.radius_i) * turn);
  if (owned(b.b)) energy_.add(b.b, t.capillary * g.n, (-t.viscous) * g.n, (-1.0) * t.tangential, (-g.radius_j) * turn);
  if (b.kind == SPHERE) return;
  const double along = dot(g.vj, g.n);
  energy_.wall_power[CAPILLARY] -= t.capillary * along;
  energy_.wall_power[VISCOUS_NORMAL] += t.viscous * along;
  energy_.wall_power[VISCOUS_TANGENTIAL] += dot(t.tangential, g.vj);
}

void Bridges::stand_or_rupture(bool decide, bool log) {
  waiting_.clear();
  Together &t = together_;
  for (t.first = 0; t.first < bridges_.size(); t.first += BATCH) {
    t.n = int(std::min<size_t>(BATCH, bridges_.size() - t.first));
    gather(t);
    if (find_gaps(blocks_[t.first / BATCH], t)) rupture(t, decide);
    act_together(t, log);
  }
}

}  // namespace pywet
