// Energy and work. The engine kicks a sphere by half a step before and half a step after the forces of step n are known, so
// that a full kick changes its kinetic energy by exactly dt F_n v_n, with v_n the velocity in the middle of the kick. Summed over
// all spheres and each effect, with half a kick at the first and the last step, this gives
//
//     kinetic(N) - kinetic(0) = sum of the works + half_kick,   half_kick = (dt^2/8) [sum F^2/m at 0 - the same at N],
//
// to round-off: the sum of the work terms closes the budget to second order in dt, and the remainder is known.
#include "energy.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pywet {

void EnergyBudget::begin(double power_of_walls) {
  wall_power[CONTACT] = power_of_walls;
  if (!world_.rules.energy) return;
  acting.assign(world_.engine.at.nlocal, Acting{});
  for (int e : {CAPILLARY, VISCOUS_NORMAL, VISCOUS_TANGENTIAL}) wall_power[e] = 0;
}

void EnergyBudget::add(int a, const Vec &capillary, const Vec &normal, const Vec &tangential, const Vec &torque) {
  Acting &on = acting[a];
  accumulate(on.capillary, capillary);
  accumulate(on.normal, normal);
  accumulate(on.tangential, tangential);
  accumulate(on.torque, torque);
}

void EnergyBudget::add(const Bridge &b, const Geometry &g, const Terms &t) {
  const View &at = world_.engine.at;
  const Vec turn = cross(g.n, t.tangential);
  if (at.owned(b.a)) add(b.a, (-t.capillary) * g.n, t.viscous * g.n, t.tangential, (-g.radius_i) * turn);
  if (at.owned(b.b)) add(b.b, t.capillary * g.n, (-t.viscous) * g.n, (-1.0) * t.tangential, (-g.radius_j) * turn);
  if (b.kind == SPHERE) return;
  const double along = dot(g.vj, g.n);
  wall_power[CAPILLARY] -= t.capillary * along;
  wall_power[VISCOUS_NORMAL] += t.viscous * along;
  wall_power[VISCOUS_TANGENTIAL] += dot(t.tangential, g.vj);
}

static double power_of(const double *f, const Vec &v) { return f[0] * v.x + f[1] * v.y + f[2] * v.z; }

void EnergyBudget::add_up() {
  if (!world_.rules.energy) return;
  const View &at = world_.engine.at;
  const bool resting = world_.clock.first || world_.clock.again;  // the velocities are those of the step, not of half a step earlier
  double power[EFFECTS] = {}, kick = 0;
  kinetic = spin = 0;
  for (int a = 0; a < at.nlocal; a++) {
    const double m = at.mass[a], r = world_.spheres.radius(at.tag[a]), inertia = 0.4 * m * r * r;
    const bool free = at.free(a);
    const double half = free && !resting ? 0.5 * at.dt : 0.0;
    const Vec f(at.f[a]), t(at.torque[a]);
    const Vec v = Vec(at.v[a]) + (half / m) * f, w = Vec(at.omega[a]) + (half / inertia) * t;
    const Acting &on = acting[a];
    const double weight = world_.feed.waits(at, a, world_.clock.now) ? 0 : m * dot(world_.rules.gravity, v), all = dot(f, v) + dot(t, w);
    const double c = power_of(on.capillary, v), n = power_of(on.normal, v);
    const double side = power_of(on.tangential, v) + power_of(on.torque, w);
    power[GRAVITY] += weight;
    power[CAPILLARY] += c;
    power[VISCOUS_NORMAL] += n;
    power[VISCOUS_TANGENTIAL] += side;
    power[CONTACT] += all - weight - c - n - side;
    if (!free) {
      power[DRIVE] -= all;
      continue;
    }
    kick += 0.125 * at.dt * at.dt * (dot(f, f) / m + dot(t, t) / inertia);
    kinetic += 0.5 * m * dot(v, v);
    spin += 0.5 * inertia * dot(w, w);
  }
  for (int e : {CONTACT, CAPILLARY, VISCOUS_NORMAL, VISCOUS_TANGENTIAL}) {
    power[e] -= wall_power[e];
    power[WALL] += wall_power[e];
  }
  if (!resting) {
    for (int e = 0; e < EFFECTS; e++) sums.work[e] += 0.5 * at.dt * (sums.power[e] + power[e]);
    sums.half_kick += sums.pending_kick - kick;
  }
  std::copy(power, power + EFFECTS, sums.power);
  sums.pending_kick = kick;
}

// Nodes and weights of the Gauss-Legendre rule on [0, 1].
static std::vector<std::pair<double, double> > gauss(int n) {
  std::vector<std::pair<double, double> > rule;
  for (int k = 0; k < n; k++) {
    double x = std::cos(3.14159265358979323846 * (k + 0.75) / (n + 0.5)), slope = 1;
    for (int turn = 0; turn < 50; turn++) {
      double p = 1, before = 0;
      for (int j = 1; j <= n; j++) {
        const double next = ((2 * j - 1) * x * p - (j - 1) * before) / j;
        before = p;
        p = next;
      }
      slope = n * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    rule.push_back({0.5 * (1 + x), 1 / ((1 - x * x) * slope * slope)});
  }
  return rule;
}

// Capillary energy of a bridge: minus the integral of the force from S to the static rupture distance, where it is zero. The substitution
// s = u^2 removes the square-root singularity of some laws at touch.
double EnergyBudget::stored(size_t bridge, double separation) const {
  static const std::vector<std::pair<double, double> > rule = gauss(24);
  const Laws &laws = world_.laws;
  if (!laws.attract() || !(world_.rules.energy || world_.rules.scripted)) return 0;
  const Bridge &b = standing_.bridges[bridge];
  const double low = std::sqrt(std::max(separation, 0.0)), high = std::sqrt(b.rupture_distance);
  const double same[ROWS] = {0, b.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j, 0};
  const int n = int(rule.size()) + 1;  // the last node is at touch
  double rows[ROWS][BATCH];
  LawValues values;
  const double *force = values.pull;
  int64_t at[BATCH];
  for (int k = 0; k < n; k++) {
    for (int row = 0; row < ROWS; row++) rows[row][k] = same[row];
    const double u = k + 1 < n ? low + (high - low) * rule[k].first : 0;
    rows[SEPARATION][k] = u * u;
    at[k] = reinterpret_cast<int64_t>(standing_.prepared(bridge));
  }
  laws.evaluate(n, rows[0], at, values);
  double sum = separation < 0 ? -separation * force[n - 1] : 0;
  for (int k = 0; k + 1 < n; k++) sum += rule[k].second * (high - low) * 2 * std::sqrt(rows[SEPARATION][k]) * force[k];
  return -sum;
}

}  // namespace pywet
