#include "logs.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace pywet {

void Logs::open(const std::string &directory) {
  directory_ = directory;
  const std::string end = "." + std::to_string(world_.ranks.me) + ".bin";
  contacts_.open(directory + "/contacts" + end);
  bridges_.open(directory + "/bridges" + end);
  wires_.open(directory + "/wire_springs" + end);
  events_.open(directory + "/events" + end);
  film_.open(directory + "/films" + end);
  impulses_.open(directory + "/impulses" + end);
  if (world_.rules.scripted) states_.open(directory + "/states" + end);
  if (!world_.ranks.first()) return;
  drops_.open(directory + "/drops" + end);
  if (world_.rules.scripted) poses_.open(directory + "/poses" + end);
  if (world_.rules.retires || world_.rules.scripted) retired_.open(directory + "/retired" + end);
  ledger_.open(directory + "/ledger" + end);
  wall_film_.open(directory + "/wall_films" + end);
  felt_.open(directory + "/felt" + end);
  energies_.open(directory + "/energy" + end);
  window_energies_.open(directory + "/window_energy" + end);
}

void Logs::write(const Event &e) { events_.write(e); }

void Logs::write(const Drop &d) {
  if (world_.ranks.first()) drops_.write(d);
}

void Logs::write(const Felt &f) {
  if (world_.ranks.first()) felt_.write(f);
}

void Logs::write(const RetiredSphere &s) {
  if (world_.ranks.first()) retired_.write(s);
}

void Logs::write(const WireContact &c) { wires_.write(c); }

void Logs::contact(const Bridge &b, const Geometry &g, const Terms &t, double weight) {
  const Vec turn = cross(g.n, t.tangential);
  Contact c = {};
  c.step = world_.clock.now; c.time = world_.clock.time; c.partner_kind = b.kind; c.i = b.i; c.j = b.j; c.triangle = g.triangle;
  store(g.xi, c.xi); store(g.vi, c.vi); store(g.wi, c.wi);
  store(g.xj, c.xj); store(g.vj, c.vj); store(g.wj, c.wj);
  c.volume = b.volume; c.separation = g.separation; c.rupture_distance = standing_.rupture_limit(b, g);
  c.capillary = t.capillary; c.viscous_normal = t.viscous; c.viscous_law = t.viscous_law;
  c.factor_normal = t.factor_normal; c.factor_tangential = t.factor_tangential;
  c.sharing_i = t.sharing_i; c.sharing_j = t.sharing_j;
  store(t.push, c.push); store(t.spin_push, c.spin_push);
  c.weight = weight;
  store(t.tangential, c.viscous_tangential);
  store((t.viscous - t.capillary) * g.n + t.tangential, c.force_i);
  store((-g.radius_i) * turn, c.torque_i);
  store(b.kind == SPHERE ? (-g.radius_j) * turn : Vec(), c.torque_j);
  contacts_.write(c);
}

Ledger Logs::counted() const {
  Ledger l = {};
  l.step = world_.clock.now; l.time = world_.clock.time;
  const View &at = world_.engine.at;
  enum { FILMS, TO_COME, BRIDGES, HOW_MANY, FORMED, RUPTURED, SUMS };
  long double sum[SUMS] = {}, wall = 0;
  for (int a = 0; a < at.nlocal; a++) {
    sum[FILMS] += films_.volume(a);
    if (world_.feed.waits(at, a, l.step)) sum[TO_COME] += at.liquid[a][FIRST];
  }
  for (const Bridge &b : standing_.bridges)
    if (b.mine) {
      sum[BRIDGES] += b.volume;
      sum[HOW_MANY] += 1;
    }
  sum[FORMED] = standing_.formations;
  sum[RUPTURED] = standing_.ruptures;
  world_.ranks.add_up(sum);
  if (!world_.ranks.first()) return l;
  for (double w : films_.wall) wall += w;
  long double absent = 0;               // of spheres that the engine does not hold yet
  for (const Coming &c : world_.feed.coming) absent += c.film;
  l.initial = double(films_.initial - absent - sum[TO_COME]);
  l.films = double(sum[FILMS] - sum[TO_COME]); l.bridges = double(sum[BRIDGES]); l.walls = double(wall); l.left = films_.left;
  l.retired = films_.retired;
  l.spheres = world_.spheres.count + int64_t(world_.feed.coming.size());
  l.bridge_count = int64_t(sum[HOW_MANY]);
  l.formations = int64_t(sum[FORMED]); l.ruptures = int64_t(sum[RUPTURED]);
  return l;
}

// Velocity at the end of the step, as after the engine's second half kick; at the start of a run no kick precedes.
void Logs::states() {
  const View &at = world_.engine.at;
  for (int a = 0; a < at.nlocal; a++) {
    State s = {world_.clock.now, world_.clock.time, at.tag[a], world_.spheres.type_of[at.tag[a]], {}, {}, {}};
    const double half = at.free(a) && !world_.clock.first ? 0.5 * at.dt / at.mass[a] : 0.0;
    store(Vec(at.x[a]), s.x);
    store(Vec(at.v[a]) + half * Vec(at.f[a]), s.v);
    store(Vec(at.omega[a]) + (half / (0.4 * at.radius[a] * at.radius[a])) * Vec(at.torque[a]), s.w);
    states_.write(s);
  }
}

void Logs::poses() {
  if (!world_.ranks.first()) return;
  for (size_t m = 0; m < world_.walls.meshes.size(); m++) {
    const Mesh &mesh = world_.walls.meshes[m];
    Pose p = {world_.clock.now, int32_t(m), 0, {}, {}, {}, {}, {}, {}};
    store(mesh.shift, p.shift);
    store(mesh.turn.x, p.turn_0); store(mesh.turn.y, p.turn_1); store(mesh.turn.z, p.turn_2);
    store(mesh.velocity, p.velocity);
    store(mesh.spin, p.spin);
    poses_.write(p);
  }
}

void Logs::energies_in_window() { energies(window_energies_); }

void Logs::energies(RecordFile &file) {
  if (!world_.rules.energy) return;
  double all[EFFECTS + 6] = {}, *rest = all + EFFECTS;
  std::copy(energy_.sums.work, energy_.sums.work + EFFECTS, all);
  rest[0] = energy_.kinetic; rest[1] = energy_.spin; rest[2] = energy_.sums.half_kick;
  for (size_t k = 0; k < standing_.bridges.size(); k++) {
    const Bridge &b = standing_.bridges[k];
    if (b.mine) rest[3] += energy_.stored(k, standing_.geometry(b).separation);
  }
  rest[4] = energy_.formed; rest[5] = energy_.ruptured;
  world_.ranks.add_up(all);
  if (!world_.ranks.first()) return;
  const double *w = all, *t = all + EFFECTS;
  file.write(Energy{world_.clock.now, world_.clock.time, t[0], t[1], t[3], t[4], t[5], w[GRAVITY],
                         w[CONTACT], w[CAPILLARY], w[VISCOUS_NORMAL], w[VISCOUS_TANGENTIAL], w[WALL], w[DRIVE], t[2]});
}

void Logs::snapshot() {
  const int64_t now = world_.clock.now;
  for (Bridge &b : standing_.bridges) {
    if (!b.here) continue;
    const Geometry g = standing_.geometry(b);
    const BridgeSums since = std::exchange(standing_.since(b), BridgeSums{0, 0, g.separation, g.separation});
    if (!b.mine) continue;
    BridgeSnapshot s = {};
    s.step = now; s.partner_kind = b.kind; s.i = b.i; s.j = b.j; s.triangle = g.triangle;
    s.volume = b.volume; s.share_i = standing_.share(b); s.separation = g.separation;
    store(g.xi, s.xi); store(g.xj, s.xj);
    s.capillary_impulse = since.capillary; s.viscous_impulse = since.viscous;
    s.least_separation = since.least; s.largest_separation = since.largest;
    bridges_.write(s);
  }
  energies(energies_);
  const Ledger now_held = counted();
  if (world_.ranks.first()) ledger_.write(now_held);
  if (world_.rules.scripted) states();
  const View &at = world_.engine.at;
  for (int a = 0; a < at.nlocal; a++)
    if (!world_.spheres.is_retired(at.tag[a])) {
      film_.write(Film{now, at.tag[a], 0, films_.volume(a)});
      Impulse push = {now, at.tag[a], 0, {}};
      store(sums_.taken(a), push.impulse);
      impulses_.write(push);
    }
  for (int k = 0; k < int(films_.wall.size()) && world_.ranks.first(); k++)
    if (films_.at_wall(k) > 0) wall_film_.write(Film{now, k, 0, world_.walls.share_of(k) * films_.at_wall(k)});
  flush();
}

void Logs::flush() {
  for (RecordFile *log : {&contacts_, &bridges_, &wires_, &events_, &drops_, &felt_, &retired_, &ledger_, &film_, &wall_film_,
                          &impulses_, &energies_, &window_energies_, &states_, &poses_})
    log->flush();
}

void Logs::stop(const std::string &why) const {
  FILE *file = fopen((directory_ + "/stopped." + std::to_string(world_.ranks.me) + ".csv").c_str(), "w");
  if (!file) return;
  fprintf(file, "# step %lld: %s\nid,x,y,z,vx,vy,vz,film\n", static_cast<long long>(world_.clock.now), why.c_str());
  const View &at = world_.engine.at;
  for (int a = 0; a < at.nlocal; a++) {
    const double *x = at.x[a], *v = at.v[a];
    fprintf(file, "%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", at.tag[a], x[0], x[1], x[2], v[0], v[1], v[2],
            films_.volume(a));
  }
  fclose(file);
}

}  // namespace pywet
