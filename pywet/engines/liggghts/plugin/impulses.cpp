// Bridges that act every so many steps: the impulse form of multiple time stepping (Verlet-I, Grubmueller et al. 1991; r-RESPA,
// Tuckerman et al. 1992).
//
// The engine kicks by dt/2 F(n) before and after the forces of step n are known. A force that is k F(n) at every k-th step and
// nothing between is then the symmetrical splitting: half a kick of k dt at either end of k steps under the other forces alone.
// Everything that is decided or written about bridges happens at these steps: events, outputs, checkpoints, the contact log.
#include <algorithm>

#include "bridges.h"

namespace pywet {

// Forces of the bridges are gathered from zero.
void Bridges::set_aside() {
  if (bridges_every == 1) return;
  others_.assign(6 * at_.nlocal, 0.0);
  for (int a = 0; a < at_.nlocal; a++) {
    std::swap_ranges(at_.f[a], at_.f[a] + 3, &others_[6 * a]);
    std::swap_ranges(at_.torque[a], at_.torque[a] + 3, &others_[6 * a + 3]);
  }
}

// They act for all the steps they stand for.
void Bridges::act_as_impulses() {
  if (bridges_every == 1) return;
  for (int a = 0; a < at_.nlocal; a++)
    for (int k = 0; k < 3; k++) {
      at_.f[a][k] = others_[6 * a + k] + bridges_every * at_.f[a][k];
      at_.torque[a][k] = others_[6 * a + 3 + k] + bridges_every * at_.torque[a][k];
    }
}

// So does their work.
void Bridges::work_as_impulses() {
  if (bridges_every == 1 || !energy) return;
  for (Acting &on : energy_.acting)
    for (double *part : {on.capillary, on.normal, on.tangential, on.torque})
      for (int k = 0; k < 3; k++) part[k] *= bridges_every;
  for (int e : {CAPILLARY, VISCOUS_NORMAL, VISCOUS_TANGENTIAL}) energy_.wall_power[e] *= bridges_every;
}

// How far any sphere is from where it was when the candidates were found, instead of a sum over steps that nobody looked at.
void Bridges::measure_travel(bool fresh) {
  if (bridges_every == 1) return;
  double farthest = 0;
  if (fresh) then_.resize(at_.nall);
  for (int a = 0; a < at_.nall; a++) {
    const Vec x(at_.x[a]);
    if (fresh) then_[a] = x;
    const Vec d = x - then_[a];
    farthest = std::max(farthest, dot(d, d));
  }
  travel_ = std::sqrt(farthest);
}

}  // namespace pywet
