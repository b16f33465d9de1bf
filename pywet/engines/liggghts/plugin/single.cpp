#include "single.h"

#include <cmath>

namespace pywet {

Terms Single::laws(size_t bridge, const Geometry &g) const {
  const Laws &laws = world_.laws;
  const Bridge &b = standing_.bridges[bridge];
  const double same[ROWS] = {g.separation, b.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j, dot(g.vi - g.vj, g.n)};
  const int64_t prepared = reinterpret_cast<int64_t>(standing_.prepared(bridge));
  double row[ROWS][BATCH];
  for (int k = 0; k < ROWS; k++) row[k][0] = same[k];
  LawValues values;
  laws.evaluate(1, row[0], &prepared, values);
  Terms t;
  t.capillary = values.pull[0];
  t.viscous = t.viscous_law = values.viscous[0];
  t.slide = values.tangential[0][0];
  t.roll = values.tangential[1][0];
  if (!world_.rules.semi_implicit) return t;
  row[SPEED][0] = 1;
  laws.evaluate(1, row[0], &prepared, values, VISCOUS);
  t.drag = -values.viscous[0];
  return t;
}

void Single::add_viscous(const Bridge &b, const Geometry &g, Terms &t) const {
  const Vec v = g.vi - g.vj, pushed = v + t.push;
  if (world_.rules.semi_implicit) {
    t.factor_normal = 1 / (1 + t.drag * t.kick);
    t.viscous = -t.drag * t.factor_normal * dot(pushed, g.n);
  }
  const double rj = b.kind == SPHERE ? g.radius_j : 0.0;  // a wall has no rotation about a centre
  const Vec spin = cross(g.n, g.radius_i * g.wi + rj * g.wj + t.spin_push);
  t.factor_tangential = 1 / (1 + (t.slide + 2.5 * t.roll) * t.kick);  // r^2/I = 2.5/m
  t.tangential = (-t.slide * t.factor_tangential) * (pushed - dot(pushed, g.n) * g.n) + (-t.roll * t.factor_tangential) * spin;
}

void Single::act(const Bridge &b, const Geometry &g, const Terms &t) {
  const View &at = world_.engine.at;
  const Vec force = (t.viscous - t.capillary) * g.n + t.tangential;
  const Vec turn = cross(g.n, t.tangential);
  if (!std::isfinite(dot(force, force))) not_finite(b, g.separation);
  if (at.owned(b.a)) {
    accumulate(at.f[b.a], force);
    accumulate(at.torque[b.a], (-g.radius_i) * turn);
  }
  if (at.owned(b.b)) {
    accumulate(at.f[b.b], (-1.0) * force);
    accumulate(at.torque[b.b], (-g.radius_j) * turn);
  }
  sums_.add(b.a, b.b, force);
  sums_.add(standing_.since(b), g.separation, t.capillary, t.viscous);
  if (world_.rules.energy) energy_.add(b, g, t);
}

void Single::not_finite(const Bridge &b, double separation) const {
  throw std::runtime_error("a force law gave a value that is not finite for the bridge of sphere " + std::to_string(b.i) +
                           (b.kind == SPHERE ? " and sphere " : " and wall part ") + std::to_string(b.j) + " at step " +
                           std::to_string(world_.clock.now) + " (separation " + number(separation) + " m)");
}

}  // namespace pywet
