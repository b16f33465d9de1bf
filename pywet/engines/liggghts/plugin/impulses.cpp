// Bridges that act every so many steps: the impulse form of multiple time stepping (Verlet-I, Grubmueller et al. 1991; r-RESPA,
// Tuckerman et al. 1992).
//
// The engine kicks by dt/2 F(n) before and after the forces of step n are known. A force that is k F(n) at every k-th step and
// nothing between is then the symmetrical splitting: half a kick of k dt at either end of k steps under the other forces alone.
// Everything that is decided or written about bridges happens at these steps: events, outputs, checkpoints, the contact log.
//
// A bridge that forms at step n acts for all of the k/2 steps to the middle of the interval but the half step that is lost where
// bridges act at every step from the next on: (k - 1)/2 steps, twice that at the start, where only half a kick follows.
#include <algorithm>

#include "bridges.h"

namespace pywet {

// Forces and works of bridges are gathered from zero.
void Bridges::set_aside() {
  if (bridges_every == 1) return;
  others_.assign(6 * at_.nlocal, 0.0);
  for (int a = 0; a < at_.nlocal; a++) {
    std::swap_ranges(at_.f[a], at_.f[a] + 3, &others_[6 * a]);
    std::swap_ranges(at_.torque[a], at_.torque[a] + 3, &others_[6 * a + 3]);
  }
  if (!energy) return;
  other_works_.assign(at_.nlocal, Acting{});
  other_works_.swap(energy_.acting);
  std::copy(energy_.wall_power, energy_.wall_power + EFFECTS, other_power_);
  std::fill(energy_.wall_power, energy_.wall_power + EFFECTS, 0.0);
}

static void add_times(double weight, double *now, const double *before, int n) {
  for (int k = 0; k < n; k++) now[k] = before[k] + weight * now[k];
}

// They act for as many steps as they stand for.
void Bridges::act_as_impulses() {
  if (bridges_every == 1) return;
  for (int a = 0; a < at_.nlocal; a++) {
    add_times(weight_, at_.f[a], &others_[6 * a], 3);
    add_times(weight_, at_.torque[a], &others_[6 * a + 3], 3);
  }
  if (!energy) return;
  for (int a = 0; a < at_.nlocal; a++) {
    Acting &now = energy_.acting[a], &before = other_works_[a];
    add_times(weight_, now.capillary, before.capillary, 3);
    add_times(weight_, now.normal, before.normal, 3);
    add_times(weight_, now.tangential, before.tangential, 3);
    add_times(weight_, now.torque, before.torque, 3);
  }
  add_times(weight_, energy_.wall_power, other_power_, EFFECTS);
}

// The forces of one bridge, as in a batch.
Terms Bridges::terms_of(size_t bridge, const Geometry &g) const {
  const Bridge &b = bridges_[bridge];
  const double same[ROWS] = {g.separation, b.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j, dot(g.vi - g.vj, g.n)};
  const int64_t prepared = reinterpret_cast<int64_t>(prepared_.data() + bridge * laws.lines);
  double row[ROWS][BATCH], out[2][BATCH];
  for (int k = 0; k < ROWS; k++) row[k][0] = same[k];
  auto call = [&](Batch law, int of) {
    out[0][0] = out[1][0] = law ? std::nan("") : 0.0;
    if (law) law(1, row[0], laws.surface_tension, laws.viscosity, &prepared, out[0]);
    return out[of][0];
  };
  Terms t;
  t.capillary = call(laws.capillary, 0);
  t.viscous = t.viscous_law = call(laws.viscous_normal, 0);
  t.slide = call(laws.viscous_tangential, 0);
  t.roll = out[1][0];
  row[SPEED][0] = 1;
  if (semi_implicit) t.drag = -call(laws.viscous_normal, 0);
  return t;
}

// Those that have just formed. Every rank takes part.
void Bridges::act_new(bool first, bool log) {
  if (bridges_every == 1) return;
  weight_ = (first ? 1.0 : 0.5) * (bridges_every - 1);
  set_aside();
  waiting_.clear();
  for (const Event &e : events_) {
    if (e.kind != FORMATION) continue;
    const int at = index_.at(key(e.partner_kind, e.i, e.j));
    Bridge &b = bridges_[at];
    if (!b.here) continue;
    Geometry g;
    geometry(b, g);
    Terms t = terms_of(at, g);
    if (semi_implicit) {
      waiting_.push_back(Waiting{&b, g, t});
      t.viscous = 0;
    } else {
      add_viscous(b, g, t);
    }
    act(b, g, t);
    if (log && !semi_implicit && owned(b.a)) write_contact(b, g, t);
  }
  act_as_impulses();
  if (semi_implicit) act_at_the_end(log);
}

// No sphere has moved further than this since the last look, nor since the candidates were found, when `fresh`.
double Bridges::moved(bool fresh) {
  double farthest = 0;
  if (fresh) before_.resize(at_.nall);
  for (int a = 0; a < at_.nall; a++) {
    const Vec x(at_.x[a]), d = x - before_[a];
    if (!fresh) farthest = std::max(farthest, dot(d, d));
    before_[a] = x;
  }
  return std::sqrt(farthest);
}

}  // namespace pywet
