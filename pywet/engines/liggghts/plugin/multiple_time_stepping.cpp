// Multiple time stepping for bridges in the impulse form (Verlet-I, Grubmueller et al. 1991; r-RESPA,
// Tuckerman et al. 1992).
//
// The engine kicks by dt/2 F(n) before and after the forces of step n are known. A force of k F(n) at every k-th step and zero
// otherwise is then the symmetric splitting: half a kick of k dt at either end of k steps under the other forces alone.
// All decisions and records about bridges are made at these steps: events, outputs, checkpoints, the contact log.
#include "multiple_time_stepping.h"

#include <algorithm>

namespace pywet {

void MultipleTimeStepping::set_aside() {
  if (!on()) return;
  const View &at = world_.engine.at;
  const int n = 3 * at.nlocal;
  others_.assign(at.f[0], at.f[0] + n);
  others_.insert(others_.end(), at.torque[0], at.torque[0] + n);
  std::fill_n(at.f[0], n, 0.0);
  std::fill_n(at.torque[0], n, 0.0);
  if (!world_.rules.energy) return;
  other_works_.assign(at.nlocal, Acting{});
  other_works_.swap(energy_.acting);
  std::copy(energy_.wall_power, energy_.wall_power + EFFECTS, other_power_);
  std::fill(energy_.wall_power, energy_.wall_power + EFFECTS, 0.0);
}

static void add_times(double weight, double *now, const double *before, int n) {
  for (int k = 0; k < n; k++) now[k] = before[k] + weight * now[k];
}

void MultipleTimeStepping::act() {
  if (!on()) return;
  const View &at = world_.engine.at;
  add_times(weight, at.f[0], others_.data(), 3 * at.nlocal);
  add_times(weight, at.torque[0], others_.data() + 3 * at.nlocal, 3 * at.nlocal);
  if (!world_.rules.energy) return;
  for (int a = 0; a < at.nlocal; a++) {
    Acting &now = energy_.acting[a], &before = other_works_[a];
    add_times(weight, now.capillary, before.capillary, 3);
    add_times(weight, now.normal, before.normal, 3);
    add_times(weight, now.tangential, before.tangential, 3);
    add_times(weight, now.torque, before.torque, 3);
  }
  add_times(weight, energy_.wall_power, other_power_, EFFECTS);
}

double MultipleTimeStepping::moved(bool fresh) {
  const View &at = world_.engine.at;
  double farthest = 0;
  if (fresh) before_.resize(at.nall);
  for (int a = 0; a < at.nall; a++) {
    const Vec x(at.x[a]), d = x - before_[a];
    if (!fresh) farthest = std::max(farthest, dot(d, d));
    before_[a] = x;
  }
  return std::sqrt(farthest);
}

}  // namespace pywet
