// Semi-implicit lubrication. The drag of a bridge is evaluated at the velocities at the end of the step, so that no viscosity is too large
// for the time step.
//
// First all other forces (contacts, gravity, capillary) change the velocities: v* = v + dt a. Then each sphere of mass m is split
// into as many parts of equal mass as it has bridges, each bridge acts between its own two parts by backward Euler, and the parts
// are joined again with their mean velocity. For the parts, relative mass 1/kick' = 1/(n_i/m_i + n_j/m_j),
//
//     F = -c v*/(1 + c dt (n_i/m_i + n_j/m_j)),
//
// along n with c of the normal law, and tangentially with c v -> c_t v_t + c_r v_spin and c -> c_t + 2.5 c_r (r^2/I = 2.5/m). Neither
// a drag by backward Euler nor the mean adds kinetic energy: a drag that only dissipates cannot make the run unstable, however
// many bridges a sphere has. (The tangential law with c_t and c_r unequal is dissipative in c_t v_t + c_r v_spin, not in every
// norm.) At rest the forces balance as in the explicit form; the error is of first order in dt.
#include "semi_implicit_drag.h"

#include <unordered_map>

namespace pywet {

struct Push {
  int id, bridges;            // number of its bridges
  double linear[3], spin[3];  // dt a, and dt times the angular acceleration
};

static void store_push(const View &at, int a, double radius, Push &p) {
  const bool free = at.free(a);
  const double linear = free ? at.dt / at.mass[a] : 0.0, turning = free ? linear / (0.4 * radius * radius) : 0.0;
  p.id = at.tag[a];
  p.bridges = 0;
  for (int k = 0; k < 3; k++) {
    p.linear[k] = linear * at.f[a][k];
    p.spin[k] = turning * at.torque[a][k];
  }
}

void SemiImplicitDrag::act() {
  const View &at = world_.engine.at;
  std::vector<Push> sent, pushes(at.nlocal);
  for (int a = 0; a < at.nlocal; a++) store_push(at, a, world_.spheres.radius(at.tag[a]), pushes[a]);
  for (const Bridge &b : standing_.bridges) {
    if (at.owned(b.a)) pushes[b.a].bridges++;
    if (at.owned(b.b)) pushes[b.b].bridges++;
  }
  std::unordered_map<int, Push> others;  // spheres of other ranks that share a bridge with this one
  impulses_.set_aside();
  if (!world_.ranks.alone()) {
    for (const Waiting &w : waiting_)
      if (w.bridge->kind == SPHERE && at.owned(w.bridge->a) != at.owned(w.bridge->b))
        sent.push_back(pushes[at.owned(w.bridge->a) ? w.bridge->a : w.bridge->b]);
    for (const Push &p : world_.ranks.near(sent)) others[p.id] = p;
  }
  auto push_of = [&](int a, int id) -> const Push & { return at.owned(a) ? pushes[a] : others.at(id); };
  for (Waiting &w : waiting_) {
    Bridge &b = *w.bridge;
    const Push &i = push_of(b.a, b.i);
    w.terms.sharing_i = at.free(b.a) ? i.bridges : 0;  // a driven body counts as immovable
    double inverse = w.terms.sharing_i / at.mass[b.a];
    w.terms.push = Vec(i.linear);
    w.terms.spin_push = b.radius_i * Vec(i.spin);
    if (b.kind == SPHERE) {
      const Push &j = push_of(b.b, b.j);
      w.terms.sharing_j = at.free(b.b) ? j.bridges : 0;
      if (w.terms.sharing_j > 0) inverse += w.terms.sharing_j / at.mass[b.b];
      w.terms.push = w.terms.push - Vec(j.linear);
      w.terms.spin_push = w.terms.spin_push + b.radius_j * Vec(j.spin);
    }
    w.terms.kick = impulses_.weight * at.dt * inverse;  // change of the relative velocity in one step per unit force
    single_.add_viscous(b, w.geometry, w.terms);
    Terms only = w.terms;
    only.capillary = 0;
    single_.act(b, w.geometry, only);
    if (world_.clock.logs_contacts() && at.owned(b.a)) logs_.contact(b, w.geometry, w.terms, impulses_.weight);
  }
  impulses_.act();
}

}  // namespace pywet
