// Semi-implicit lubrication. The drag of a bridge is taken at the speeds at the end of the step, so that no viscosity is too large
// for the time step.
//
// Let all other forces (contacts, gravity, capillary) change the speeds first: v* = v + dt a. Then split each sphere of mass m
// into as many parts of equal mass as it has bridges, let each bridge act between its own two parts by backward Euler, and join
// the parts again, with the mean of their speeds. For the parts, relative mass 1/kick' = 1/(n_i/m_i + n_j/m_j),
//
//     F = -c v*/(1 + c dt (n_i/m_i + n_j/m_j)),
//
// along n with c of the normal law, and sideways with c v -> c_t v_t + c_r v_spin and c -> c_t + 2.5 c_r (r^2/I = 2.5/m). Neither
// a drag by backward Euler nor the mean adds kinetic energy: a drag that only dissipates cannot make the run unstable, however
// many bridges a sphere has. (The sideways law with c_t and c_r unequal is dissipative in c_t v_t + c_r v_spin, not in every
// norm.) At rest the forces balance as in the explicit form; the error is of first order in dt.
#include <algorithm>

#include "bridges.h"

namespace pywet {

struct Push {
  int64_t id;
  double linear[3], spin[3];  // dt a, and dt times the angular acceleration
};

static void store_push(const View &at, int a, double radius, Push &p) {
  const bool free = at.free(a);
  const double linear = free ? at.dt / at.mass[a] : 0.0, turning = free ? linear / (0.4 * radius * radius) : 0.0;
  p.id = at.tag[a];
  for (int k = 0; k < 3; k++) {
    p.linear[k] = linear * at.f[a][k];
    p.spin[k] = turning * at.torque[a][k];
  }
}

// Of the spheres of other ranks that have a bridge with one of this rank.
static std::unordered_map<int, Push> exchange(const std::vector<Push> &mine, MPI_Comm world, int ranks) {
  std::vector<int> bytes(ranks), offset(ranks, 0);
  int size = int(mine.size() * sizeof(Push));
  MPI_Allgather(&size, 1, MPI_INT, bytes.data(), 1, MPI_INT, world);
  for (int k = 1; k < ranks; k++) offset[k] = offset[k - 1] + bytes[k - 1];
  std::vector<Push> all((offset.back() + bytes.back()) / sizeof(Push));
  MPI_Allgatherv(mine.data(), size, MPI_BYTE, all.data(), bytes.data(), offset.data(), MPI_BYTE, world);
  std::unordered_map<int, Push> found;
  for (const Push &p : all) found[int(p.id)] = p;
  return found;
}

// Change of the relative speed in one step per force; a driven body counts as immovable.
double Bridges::kick_of(const Bridge &b, Terms &t) const {
  t.sharing_i = at_.free(b.a) ? standing_[b.i] : 0;
  t.sharing_j = b.kind == SPHERE && at_.free(b.b) ? standing_[b.j] : 0;
  double sum = t.sharing_i / at_.mass[b.a];
  if (t.sharing_j > 0) sum += t.sharing_j / at_.mass[b.b];
  return weight_ * at_.dt * sum;
}

// Called by every rank once all other forces are known.
void Bridges::act_at_the_end(bool log) {
  std::vector<Push> sent, pushes(at_.nlocal);
  for (int a = 0; a < at_.nlocal; a++) store_push(at_, a, radius(at_.tag[a]), pushes[a]);
  std::unordered_map<int, Push> others;
  set_aside();
  if (ranks_ > 1) {
    for (const Waiting &w : waiting_)
      if (w.bridge->kind == SPHERE && owned(w.bridge->a) != owned(w.bridge->b))
        sent.push_back(pushes[owned(w.bridge->a) ? w.bridge->a : w.bridge->b]);
    others = exchange(sent, world_, ranks_);
  }
  auto push_of = [&](int a, int id) -> const Push & { return owned(a) ? pushes[a] : others.at(id); };
  for (Waiting &w : waiting_) {
    const Bridge &b = *w.bridge;
    const Push &i = push_of(b.a, b.i);
    w.terms.kick = kick_of(b, w.terms);
    w.terms.push = Vec(i.linear);
    w.terms.spin_push = b.radius_i * Vec(i.spin);
    if (b.kind == SPHERE) {
      const Push &j = push_of(b.b, b.j);
      w.terms.push = w.terms.push - Vec(j.linear);
      w.terms.spin_push = w.terms.spin_push + b.radius_j * Vec(j.spin);
    }
    add_viscous(b, w.geometry, w.terms);
    Terms only = w.terms;
    only.capillary = 0;
    act(b, w.geometry, only);
    if (log && owned(b.a)) write_contact(b, w.geometry, w.terms);
  }
  act_as_impulses();
}

}  // namespace pywet
