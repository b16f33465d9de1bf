// Forces and torques of the standing bridges, and which of them rupture.
#include "bridges.h"

#include <algorithm>
#include <cmath>

namespace pywet {

static const double PI = 3.14159265358979323846;

static double film_thickness(double volume, double r) {
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

// The next place of the batch, whose geometry is known.
void Bridges::enter(const Bridge &b, const Line *prepared) {
  Together &t = together_;
  const int k = t.n++;
  const Geometry &g = t.geometry[k];
  t.bridge[k] = &b;
  t.prepared[k] = reinterpret_cast<int64_t>(prepared);
  for (int line = 0; line < laws.lines; line++) __builtin_prefetch(prepared + line);
  t.row[SEPARATION][k] = g.separation;
  t.row[VOLUME][k] = b.volume;
  t.row[RADIUS_I][k] = g.radius_i;
  t.row[RADIUS_J][k] = g.radius_j;
  t.row[ANGLE_I][k] = b.angle_i;
  t.row[ANGLE_J][k] = b.angle_j;
  t.row[SPEED][k] = dot(g.vi - g.vj, g.n);
}

// A law that fails half way leaves what is no number.
void Bridges::evaluate(Together &t) const {
  auto call = [&](Batch law, double *out, int functions) {
    std::fill(out, out + functions * BATCH, law ? std::nan("") : 0.0);
    if (law) law(t.n, t.row[0], laws.surface_tension, laws.viscosity, t.prepared, out);
  };
  call(laws.capillary, t.pull, 1);
  call(laws.viscous_normal, t.normal, 1);
  call(laws.viscous_tangential, t.tangential[0], 2);
  if (!semi_implicit) return;
  std::fill(t.row[SPEED], t.row[SPEED] + t.n, 1.0);
  call(laws.viscous_normal, t.drag, 1);
}

void Bridges::act_together(bool log) {
  Together &batch = together_;
  evaluate(batch);
  for (int k = 0; k < batch.n; k++) {
    const Bridge &b = *batch.bridge[k];
    const Geometry &g = batch.geometry[k];
    Terms t;
    t.capillary = batch.pull[k];
    t.viscous = t.viscous_law = batch.normal[k];
    t.slide = batch.tangential[0][k];
    t.roll = batch.tangential[1][k];
    if (semi_implicit) {  // the viscous forces wait for all others
      t.drag = -batch.drag[k];
      waiting_.push_back(Waiting{&b, g, t});
      t.viscous = 0;
    } else {
      add_viscous(b, g, t);
    }
    act(b, g, t);
    if (log && !semi_implicit && owned(b.a)) write_contact(b, g, t);
  }
  batch.n = 0;
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

void Bridges::act(const Bridge &b, const Geometry &g, const Terms &t) {
  const Vec force = (t.viscous - t.capillary) * g.n + t.tangential;
  const Vec turn = cross(g.n, t.tangential);
  const Vec torque_i = (-g.radius_i) * turn, torque_j = b.kind == SPHERE ? (-g.radius_j) * turn : Vec();
  if (!std::isfinite(dot(force, force)))
    throw std::runtime_error("a force law gave a value that is not finite for the bridge of sphere " + std::to_string(b.i) +
                             (b.kind == SPHERE ? " and sphere " : " and wall part ") + std::to_string(b.j) + " at step " +
                             std::to_string(now_) + " (separation " + number(g.separation) + " m)");
  if (owned(b.a)) {
    accumulate(at_.f[b.a], force);
    accumulate(at_.torque[b.a], torque_i);
    if (energy) energy_.add(b.a, (-t.capillary) * g.n, t.viscous * g.n, t.tangential, torque_i);
  }
  if (owned(b.b)) {
    accumulate(at_.f[b.b], (-1.0) * force);
    accumulate(at_.torque[b.b], torque_j);
    if (energy) energy_.add(b.b, t.capillary * g.n, (-t.viscous) * g.n, (-1.0) * t.tangential, torque_j);
  }
  if (b.kind != SPHERE && energy) {
    const double along = dot(g.vj, g.n);
    energy_.wall_power[CAPILLARY] -= t.capillary * along;
    energy_.wall_power[VISCOUS_NORMAL] += t.viscous * along;
    energy_.wall_power[VISCOUS_TANGENTIAL] += dot(t.tangential, g.vj);
  }
}

void Bridges::stand_or_rupture(bool decide, bool log) {
  waiting_.clear();
  for (size_t k = 0; k < bridges_.size(); k++) {
    Bridge &b = bridges_[k];
    if (!b.here) continue;
    Geometry &g = together_.geometry[together_.n];
    geometry(b, g);
    check_overlap(g, b.kind, b.i, b.j);
    if (decide && g.separation >= b.rupture_distance && g.separation >= rupture_limit(b, g)) {
      if (!owned(b.a)) continue;
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
    enter(b, prepared_.data() + k * laws.lines);
    if (together_.n == BATCH) act_together(log);
  }
  act_together(log);
}

}  // namespace pywet
