// The weight of the liquid: the mass with which the engine moves a sphere is its own and that of the liquid it holds, its film
// and its side of each bridge by the transfer ratio, as the liquid is counted everywhere else (at a wall the rest is the wall's).
//
// The engine's masses are changed, not forces added, so that what weighs also has inertia: what falls freely falls with g. The liquid turns as if
// spread in the sphere (I = 0.4 m r^2; a shell would have 2/3, liquid that does not turn 0). Nothing else asks for the masses: dry
// contacts have their dashpots in kg/s. A step has one mass throughout, from the liquid at its start, in its forces and in both halves of its kick. A sphere keeps its
// speed when its mass changes: the kinetic energy that liquid brings or takes is booked as that of the drive.
#include "bridges.h"

namespace pywet {

double Bridges::wet_mass(int id) const { return type_mass[type_of[id] - 1] + density * weighed_[id]; }

// Before the first step, when what is held is known; the state of a run that goes on brings the loads of its last step.
void Bridges::load() {
  if (!weighs) return;
  if (load_.empty()) {
    load_ = film;
    for (const Bridge &b : bridges_) {
      const double own = share(b);
      load_[b.i] += own;
      if (b.kind == SPHERE) load_[b.j] += b.volume - own;
    }
    weighed_ = load_;
  }
  look();
  for (int a = 0; a < at_.nlocal; a++) at_.mass[a] = wet_mass(at_.tag[a]);
}

// At the start of a step's part, gravity having acted on the masses of the step before.
void Bridges::weigh(bool again, bool fresh) {
  if (!weighs || !(fresh || heavier_)) return;
  if (again || !heavier_) {
    for (int a = 0; a < at_.nall; a++) at_.mass[a] = wet_mass(at_.tag[a]);
    return;
  }
  heavier_ = false;
  weighed_ = load_;
  for (int a = 0; a < at_.nall; a++) {
    const double mass = wet_mass(at_.tag[a]), more = mass - at_.mass[a];
    at_.mass[a] = mass;
    if (a >= at_.nlocal || more == 0) continue;
    accumulate(at_.f[a], more * gravity);
    if (!at_.free(a)) continue;
    const Vec v(at_.v[a]), w(at_.omega[a]);
    const double r = radius(at_.tag[a]);
    energy_.sums.work[DRIVE] += 0.5 * more * (dot(v, v) + 0.4 * r * r * dot(w, w));
  }
}

// A bridge gives back what it counts for: only formations move liquid from one side to the other.
void Bridges::carry() {
  if (!weighs) return;
  heavier_ = true;
  for (const Event &e : events_)
    if (e.kind == FORMATION) {
      const double own = share(bridges_[index_.at(key(e.partner_kind, e.i, e.j))]);
      load_[e.i] += own - e.share_i;
      if (e.partner_kind == SPHERE) load_[e.j] += (e.volume - own) - e.share_j;
    }
}

}  // namespace pywet
