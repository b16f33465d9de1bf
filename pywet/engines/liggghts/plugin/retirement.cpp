// A sphere is removed if its centre is far below the plane of the bin and it is too slow to return (thresholds are part of the
// scene), or if its centre is in an outlet. Its bridges end in the same step as by rupture, each side with its share of the transfer law; its film
// afterwards leaves with it. The worker deletes the sphere in the engine before it writes
// the checkpoint. In a sampling window
// no sphere is removed.
#include "retirement.h"

#include <algorithm>

namespace pywet {

// Velocity at the end of the step, as after the engine's second half kick and in the trajectory.
std::vector<RetiredSphere> Retirement::chosen() const {
  const View &at = world_.engine.at;
  const Settings &rules = world_.rules;
  std::vector<RetiredSphere> found;
  for (int a = 0; a < at.nlocal; a++) {
    if (!at.free(a) || world_.feed.waits(at, a, world_.clock.now)) continue;
    const double half = 0.5 * at.dt / at.mass[a];
    const Vec v = Vec(at.v[a]) + half * Vec(at.f[a]);
    const int outlet = rules.outlet(Vec(at.x[a]), v, at.dt * double(world_.clock.now));
    const bool lies = at.x[a][2] < rules.retire_below && dot(v, v) < rules.retire_slower * rules.retire_slower;
    if (!(rules.outlets.empty() ? lies : outlet > 0)) continue;
    RetiredSphere s = {};
    s.outlet = outlet;
    s.step = world_.clock.now; s.time = world_.clock.time; s.id = at.tag[a]; s.type = world_.spheres.type_of[at.tag[a]];
    store(Vec(at.x[a]), s.x);
    store(v, s.v);
    found.push_back(s);
  }
  return found;
}

void Retirement::end_bridges() {
  const Spheres &spheres = world_.spheres;
  ledger_.events.clear();
  for (const Bridge &b : standing_.bridges) {
    if (!world_.engine.at.owned(b.a)) continue;
    if (!spheres.is_retired(b.i) && !(b.kind == SPHERE && spheres.is_retired(b.j))) continue;
    const Geometry g = standing_.geometry(b);
    Event e = {};
    e.step = world_.clock.now; e.time = world_.clock.time; e.kind = RETIREMENT; e.partner_kind = b.kind;
    e.i = b.i; e.j = b.j; e.triangle = g.triangle;
    e.volume = b.volume;
    e.share_i = standing_.share(b);
    e.share_j = b.volume - e.share_i;
    e.separation = g.separation; e.rupture_distance = b.rupture_distance; e.speed = norm(g.vi - g.vj);
    ledger_.events.push_back(e);
  }
  ledger_.gather("");
  if (ledger_.any) ledger_.apply_events();
}

// Each rank knows the films of its own spheres.
void Retirement::hand_over(std::vector<RetiredSphere> &all) {
  const Engine &engine = world_.engine;
  std::vector<RetiredSphere> mine;
  for (RetiredSphere s : all)
    if (const int a = engine.local(s.id); engine.at.owned(a)) {
      s.film = films_.volume(a);
      mine.push_back(s);
    }
  all = world_.ranks.gathered(mine);
  std::sort(all.begin(), all.end(), [](const RetiredSphere &p, const RetiredSphere &q) { return p.id < q.id; });
  long double sum = films_.retired;
  for (const RetiredSphere &s : all) {
    sum += s.film;
    if (const int a = engine.local(s.id); a >= 0) engine.at.liquid[a][FILM] = 0;  // its film counts as removed from now on
    logs_.write(s);
  }
  films_.retired = double(sum);
}

void Retirement::retire() {
  const StepSchedule &clock = world_.clock;
  if (!world_.rules.retires || !clock.checkpoint() || clock.logs_contacts()) return;
  std::vector<RetiredSphere> all = world_.ranks.gathered(chosen());
  if (all.empty()) return;
  std::vector<int64_t> &retired = world_.spheres.retired;
  for (const RetiredSphere &s : all) retired.push_back(s.id);
  std::sort(retired.begin(), retired.end());
  if (films_.initial > 0) end_bridges();
  hand_over(all);
}

}  // namespace pywet
