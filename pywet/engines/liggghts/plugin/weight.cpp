// Weight of the liquid: the engine moves a sphere with the sum of its own mass and that of its liquid, its film
// and its side of each bridge by the transfer ratio, as the liquid is counted elsewhere (at a wall the rest belongs to the wall).
//
// The engine's masses are changed and no forces are added, so that the liquid also has inertia and falls freely with g. The liquid rotates as if
// distributed in the sphere (I = 0.4 m r^2; a shell would have 2/3, liquid that does not rotate 0). Nothing else uses the masses: dry
// contacts have their dashpots in kg/s. The mass is constant within a step, from the liquid at its start. A sphere keeps its
// velocity when its mass changes: the kinetic energy that liquid brings or takes is counted under drive.
#include "weight.h"

namespace pywet {

double Weight::wet_mass(int a) const {
  const View &at = world_.engine.at;
  return world_.spheres.mass(at.tag[a]) + world_.rules.density * at.liquid[a][WEIGHED];
}

void Weight::begin() {
  if (!world_.rules.weighs) return;
  const View &at = world_.engine.at;
  for (int a = 0; a < at.nlocal; a++) at.mass[a] = wet_mass(a);
}

// Gravity has acted on the masses of the previous step.
void Weight::weigh(bool fresh) {
  if (!world_.rules.weighs || !(fresh || heavier_)) return;
  const View &at = world_.engine.at;
  if (world_.clock.again || !heavier_) {
    for (int a = 0; a < at.nall; a++) at.mass[a] = wet_mass(a);
    return;
  }
  heavier_ = false;
  for (int a = 0; a < at.nall; a++) {
    at.liquid[a][WEIGHED] = at.liquid[a][LOAD];
    const double mass = wet_mass(a), more = mass - at.mass[a];
    at.mass[a] = mass;
    if (a >= at.nlocal || more == 0) continue;
    accumulate(at.f[a], more * world_.rules.gravity);
    if (!at.free(a)) continue;
    const Vec v(at.v[a]), w(at.omega[a]);
    const double r = world_.spheres.radius(at.tag[a]);
    energy_.sums.work[DRIVE] += 0.5 * more * (dot(v, v) + 0.4 * r * r * dot(w, w));
  }
}

// A bridge returns what it was counted with: only formations move liquid from one side to the other. The owner of a sphere knows both ends
// of all its bridges and sends the result to the ghosts of the sphere.
void Weight::carry(const std::vector<Event> &events) {
  if (!world_.rules.weighs) return;
  heavier_ = true;
  const Engine &engine = world_.engine;
  for (const Event &e : events)
    if (e.kind == FORMATION) {
      const double own = standing_.share(standing_.made(e.partner_kind, e.i, e.j, e.volume));
      const int a = engine.local(e.i), b = e.partner_kind == SPHERE ? engine.local(e.j) : -1;
      if (engine.at.owned(a)) engine.at.liquid[a][LOAD] += own - e.share_i;
      if (engine.at.owned(b)) engine.at.liquid[b][LOAD] += (e.volume - own) - e.share_j;
    }
  if (!world_.ranks.alone()) engine.update_ghosts();
}

void Weight::carry(const Drop &d) {
  if (!world_.rules.weighs) return;
  heavier_ = true;
  const Engine &engine = world_.engine;
  const int a = engine.local(d.i), b = d.partner_kind == SPHERE ? engine.local(d.j) : -1;
  if (a >= 0) engine.at.liquid[a][LOAD] -= d.volume;
  if (b >= 0) engine.at.liquid[b][LOAD] += d.volume;
}

}  // namespace pywet
