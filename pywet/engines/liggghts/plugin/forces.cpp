#include "forces.h"

#include <algorithm>
#include <cmath>

namespace pywet {

Geometry Forces::geometry_of(const BridgeBatch &t, int k) const {
  const Bridge &b = standing_.bridges[t.first + k];
  if (b.kind == SPHERE) return between_spheres(world_, b.a, b.b, b.radius_i, b.radius_j);
  return at_wall(world_, b.a, b.radius_i, b.j, t.near[k]);
}

// The engine stores its vectors contiguously.
static Vec vector_of(double **all, int a) { return Vec(all[0] + 3 * a); }

// Unless it is inlined, a call of a function that only prefetches is dropped by the compiler, as one without effect.
#define INLINE static inline __attribute__((always_inline))

// Prefetches a cache line of the next block: a block has too many rows for the processor's own prefetcher.
INLINE void fetch(const Block *next, size_t line) {
  if (64 * line < sizeof(Block)) __builtin_prefetch(reinterpret_cast<const char *>(next) + 64 * line);
}

// With fewer spheres their arrays stay in the caches, and prefetching what bridges need of them costs more than it saves.
const int LARGE = 24000;

// Prefetches what a bridge needs of its second end, which lies elsewhere in memory: its state a few bridges ahead, its sums for `add`.
INLINE void fetch_ends(const View &at, const Block &block, int k, bool last) {
  const int later = k + 16;
  const int c = later < BATCH ? block.b[later] : last ? -1 : (&block + 1)->b[later - BATCH];
  if (c >= 0) {
    __builtin_prefetch(at.x[0] + 3 * c);
    __builtin_prefetch(at.v[0] + 3 * c);
    __builtin_prefetch(at.omega[0] + 3 * c);
  }
  const int b = block.b[k];
  if (b < 0) return;
  __builtin_prefetch(at.f[0] + 3 * b, 1);
  __builtin_prefetch(at.torque[0] + 3 * b, 1);
  __builtin_prefetch(at.impulse(b), 1);
  __builtin_prefetch(at.impulse(b) + 2, 1);
}

// Positions and velocities of the ends of the bridges.
void Forces::gather(BridgeBatch &t) {
  const Block &block = standing_.blocks[t.first / BATCH];
  const bool last = t.first + BATCH >= standing_.bridges.size();
  const View &at = world_.engine.at;
  const bool large = at.nall > LARGE;
  const Walls &walls = world_.walls;
  auto set = [&t](double (*out)[BATCH], int k, const Vec &a) {
    out[0][k] = a.x; out[1][k] = a.y; out[2][k] = a.z;
  };
  int before = -1;
  Vec x, v, w;
  const size_t lines = world_.laws.lines;
  for (int k = 0; k < t.n; k++) {
    fetch(&block + 1, k);
    fetch(&block + 1, BATCH + k);
    for (size_t line = 0; line < lines; line++) __builtin_prefetch(standing_.prepared(t.first + k) + line);
    if (large) fetch_ends(at, block, k, last);
    const int a = block.a[k], b = block.b[k];
    t.acts[k] = a >= 0;
    if (a < 0) {  // not owned by this rank
      set(t.d, k, Vec(1, 0, 0)); set(t.v, k, Vec()); set(t.spin, k, Vec());
      continue;
    }
    if (a != before) {
      x = vector_of(at.x, a); v = vector_of(at.v, a); w = block.row[RADIUS_I][k] * vector_of(at.omega, a);
      before = a;
    }
    if (b >= 0) {
      set(t.d, k, at.images.nearest(x - vector_of(at.x, b))); set(t.v, k, v - vector_of(at.v, b));
      set(t.spin, k, w + block.spin_j[k] * vector_of(at.omega, b));
      continue;
    }
    Site &site = standing_.sites[-1 - b];
    const Closest &c = t.near[k] = walls.closest(x, site);
    set(t.d, k, x - c.point); set(t.v, k, v - walls.meshes[site.mesh].velocity_at(c.on_wall())); set(t.spin, k, w);
  }
}

// Bridges that overlap too deeply stop the run; those that are too long rupture.
void Forces::rupture(BridgeBatch &t, std::vector<Event> &events) const {
  const Block &block = standing_.blocks[t.first / BATCH];
  for (int k = 0; k < t.n; k++) {
    if (!t.acts[k]) continue;
    const double gap = block.row[SEPARATION][k];
    if (gap >= block.deepest[k] && gap < block.longest[k]) continue;
    const Bridge &b = standing_.bridges[t.first + k];
    const Geometry g = geometry_of(t, k);
    check_overlap(world_, g, b.kind, b.i, b.j);
    if (world_.clock.again || !(g.separation >= b.rupture_distance && g.separation >= standing_.rupture_limit(b, g))) continue;
    t.acts[k] = false;
    if (!world_.engine.at.owned(b.a)) continue;
    Event e = {};
    e.step = world_.clock.now; e.time = world_.clock.time; e.kind = RUPTURE; e.partner_kind = b.kind;
    e.i = b.i; e.j = b.j; e.triangle = g.triangle;
    e.volume = b.volume;
    e.share_i = standing_.share(b);
    e.share_j = b.volume - e.share_i;
    e.separation = g.separation; e.rupture_distance = b.rupture_distance; e.speed = norm(g.vi - g.vj);
    events.push_back(e);
  }
}

// Laws are evaluated for active bridges only; the others are set to touch.
void Forces::evaluate(BridgeBatch &t) {
  Block &block = standing_.blocks[t.first / BATCH];
  const Laws &laws = world_.laws;
  for (int k = 0; k < t.n; k++)
    if (!t.acts[k]) block.row[SEPARATION][k] = block.row[SPEED][k] = 0;
  const CacheLine *lines = standing_.prepared(t.first);
  for (int k = 0; k < t.n; k++) t.prepared[k] = reinterpret_cast<int64_t>(lines + k * laws.lines);
  laws.evaluate(t.n, block.row[0], t.prepared, t);
  if (!world_.rules.semi_implicit) return;
  LawValues at_one;
  std::fill(block.row[SPEED], block.row[SPEED] + t.n, 1.0);
  laws.evaluate(t.n, block.row[0], t.prepared, at_one, VISCOUS);
  std::copy(at_one.viscous, at_one.viscous + t.n, t.drag);
}

// Viscous forces that are evaluated after all other forces.
void Forces::defer(BridgeBatch &t) {
  for (int k = 0; k < t.n; k++) {
    Terms terms;
    terms.capillary = t.pull[k];
    terms.viscous_law = t.viscous[k];
    terms.slide = t.tangential[0][k];
    terms.roll = t.tangential[1][k];
    terms.drag = -t.drag[k];
    if (t.acts[k]) implicit_.wait(standing_.bridges[t.first + k], geometry_of(t, k), terms);
    t.viscous[k] = t.tangential[0][k] = t.tangential[1][k] = 0;
  }
}

// Writes the force of a bridge to the contact log and to the work terms.
void Forces::record(const BridgeBatch &t, int k) {
  const Bridge &b = standing_.bridges[t.first + k];
  const Geometry g = geometry_of(t, k);
  Terms terms;
  terms.capillary = t.pull[k];
  terms.viscous = terms.viscous_law = t.viscous[k];
  terms.slide = t.tangential[0][k];
  terms.roll = t.tangential[1][k];
  terms.tangential = Vec(t.side[0][k], t.side[1][k], t.side[2][k]);
  if (world_.rules.energy) energy_.add(b, g, terms);
  if (world_.clock.logs_contacts() && !world_.rules.semi_implicit && world_.engine.at.owned(b.a))
    logs_.contact(b, g, terms, impulses_.weight);
}

void Forces::add(BridgeBatch &t) {
  const Block &block = standing_.blocks[t.first / BATCH];
  const View &engine = world_.engine.at;
  const bool recorded = world_.clock.logs_contacts() || world_.rules.energy;
  evaluate(t);
  if (world_.rules.semi_implicit) defer(t);
  find_forces(block, t);
  auto at = [](const double (*from)[BATCH], int k) { return Vec(from[0][k], from[1][k], from[2][k]); };
  int before = -1;  // bridges of one sphere are consecutive: its sums are held in local variables
  const double span = sums_.span();
  Vec f, q, p;
  auto put = [&] {
    if (!engine.owned(before)) return;
    store(f, engine.f[before]);
    store(q, engine.torque[before]);
    store(p, engine.impulse(before));
  };
  for (int k = 0; k < t.n; k++) {
    if (!t.acts[k]) continue;
    const int a = block.a[k], b = block.b[k];
    if (!(t.square[k] < INF)) single_.not_finite(standing_.bridges[t.first + k], block.row[SEPARATION][k]);
    if (a != before) {
      put();
      f = vector_of(engine.f, a); q = vector_of(engine.torque, a); p = Vec(engine.impulse(a));
      before = a;
    }
    const Vec force = at(t.force, k);
    f = f + force;
    q = q + at(t.torque_i, k);
    p = p + span * force;
    if (engine.owned(b)) {
      accumulate(engine.f[0] + 3 * b, (-1.0) * force);
      accumulate(engine.torque[0] + 3 * b, at(t.torque_j, k));
      accumulate(engine.impulse(b), (-span) * force);
    }
    sums_.add(standing_.sums[t.first + k], block.row[SEPARATION][k], t.pull[k], t.viscous[k]);
    if (recorded) record(t, k);
  }
  put();
}

void Forces::act(std::vector<Event> &events) {
  impulses_.weight = world_.clock.bridges_every;
  sums_.act_for(impulses_.weight);
  impulses_.set_aside();
  implicit_.clear();
  BridgeBatch &t = together_;
  for (t.first = 0; t.first < standing_.bridges.size(); t.first += BATCH) {
    t.n = int(std::min<size_t>(BATCH, standing_.bridges.size() - t.first));
    gather(t);
    if (find_gaps(standing_.blocks[t.first / BATCH], t)) rupture(t, events);
    add(t);
  }
  impulses_.act();
}

// A bridge that forms at step n acts for the k/2 steps up to the middle of the interval, less the half step that is also lost if
// bridges act from the next step on: (k - 1)/2 steps, twice that at the start, where only half a kick follows.
void Forces::act_new(const std::vector<Event> &events) {
  if (!impulses_.on()) return;
  impulses_.weight = (world_.clock.first ? 1.0 : 0.5) * (world_.clock.bridges_every - 1);
  sums_.act_for(impulses_.weight);
  impulses_.set_aside();
  implicit_.clear();
  for (const Event &e : events) {
    if (e.kind != FORMATION) continue;
    const int k = standing_.find(e.partner_kind, e.i, e.j);
    if (k < 0) continue;
    Bridge &b = standing_.bridges[k];
    const Geometry g = standing_.geometry(b);
    Terms t = single_.laws(k, g);
    if (world_.rules.semi_implicit) {
      implicit_.wait(b, g, t);
      t.viscous = 0;
    } else {
      single_.add_viscous(b, g, t);
    }
    single_.act(b, g, t);
    if (world_.clock.logs_contacts() && !world_.rules.semi_implicit && world_.engine.at.owned(b.a))
      logs_.contact(b, g, t, impulses_.weight);
  }
  impulses_.act();
  if (world_.rules.semi_implicit) implicit_.act();
}

}  // namespace pywet
