// Logs: events always (booking.cpp), contacts in windows, the rest at output steps.
#include "bridges.h"

#include <cstdio>

namespace pywet {

void Bridges::open_logs() {
  const std::string end = "." + std::to_string(rank_) + ".bin";
  contact_log_.open(directory_ + "/contacts" + end);
  bridge_log_.open(directory_ + "/bridges" + end);
  wire_log_.open(directory_ + "/wire_springs" + end);
  if (rank_ > 0) return;
  event_log_.open(directory_ + "/events" + end);
  drop_log_.open(directory_ + "/drops" + end);
  ledger_log_.open(directory_ + "/ledger" + end);
  film_log_.open(directory_ + "/films" + end);
  wall_film_log_.open(directory_ + "/wall_films" + end);
  energy_log_.open(directory_ + "/energy" + end);
}

bool Bridges::logging() const {
  for (size_t k = 0; k < window_first.size(); k++)
    if (now_ >= window_first[k] && now_ < window_last[k]) return true;
  return false;
}

void Bridges::write_contact(const Bridge &b, const Geometry &g, const Terms &t) {
  const Vec turn = cross(g.n, t.tangential);
  Contact c = {};
  c.step = now_; c.time = time_; c.partner_kind = b.kind; c.i = b.i; c.j = b.j; c.triangle = g.triangle;
  store(g.xi, c.xi); store(g.vi, c.vi); store(g.wi, c.wi);
  store(g.xj, c.xj); store(g.vj, c.vj); store(g.wj, c.wj);
  c.volume = b.volume; c.separation = g.separation; c.rupture_distance = rupture_limit(b, g);
  c.capillary = t.capillary; c.viscous_normal = t.viscous; c.viscous_law = t.viscous_law;
  c.factor_normal = t.factor_normal; c.factor_tangential = t.factor_tangential;
  c.sharing_i = t.sharing_i; c.sharing_j = t.sharing_j;
  store(t.push, c.push); store(t.spin_push, c.spin_push);
  c.weight = weight_;
  store(t.tangential, c.viscous_tangential);
  store((t.viscous - t.capillary) * g.n + t.tangential, c.force_i);
  store((-g.radius_i) * turn, c.torque_i);
  store(b.kind == SPHERE ? (-g.radius_j) * turn : Vec(), c.torque_j);
  contact_log_.write(c);
}

void Bridges::write_ledger() {
  Ledger l = {};
  l.step = now_; l.time = time_; l.initial = initial_;
  long double films = 0, standing = 0, wall = 0;
  for (size_t id = 1; id < film.size(); id++)
    if (type_of[id] > 0) films += film[id];
  for (const Bridge &b : bridges_) standing += b.volume;
  for (double w : walls.film) wall += w;
  l.films = double(films); l.bridges = double(standing); l.walls = double(wall); l.left = left_;
  l.spheres = spheres_;
  l.bridge_count = int64_t(bridges_.size());
  l.formations = formations_; l.ruptures = ruptures_;
  ledger_log_.write(l);
}

// Every rank takes part; rank 0 writes.
void Bridges::write_energy() {
  if (!energy) return;
  double mine[EFFECTS + 4] = {}, all[EFFECTS + 4] = {};
  for (int e = 0; e < EFFECTS; e++) mine[e] = energy_.sums.work[e];
  double *rest = mine + EFFECTS;
  rest[0] = energy_.kinetic; rest[1] = energy_.spin; rest[2] = energy_.sums.half_kick;
  for (size_t k = 0; k < bridges_.size(); k++) {
    if (!owned(bridges_[k].a)) continue;
    Geometry g;
    geometry(bridges_[k], g);
    rest[3] += stored(k, g.separation);
  }
  MPI_Reduce(mine, all, EFFECTS + 4, MPI_DOUBLE, MPI_SUM, 0, world_);
  if (rank_ > 0) return;
  const double *w = all, *t = all + EFFECTS;
  energy_log_.write(Energy{now_, time_, t[0], t[1], t[3], energy_.formed, energy_.ruptured, w[GRAVITY], w[CONTACT], w[CAPILLARY],
                           w[VISCOUS_NORMAL], w[VISCOUS_TANGENTIAL], w[WALL], w[DRIVE], t[2]});
}

void Bridges::snapshot() {
  for (Bridge &b : bridges_) {
    if (!owned(b.a)) continue;
    Geometry g;
    geometry(b, g);
    BridgeSnapshot s = {};
    s.step = now_; s.partner_kind = b.kind; s.i = b.i; s.j = b.j; s.triangle = g.triangle;
    s.volume = b.volume; s.share_i = share(b); s.separation = g.separation;
    store(g.xi, s.xi); store(g.xj, s.xj);
    bridge_log_.write(s);
  }
  write_energy();
  if (rank_ == 0) {
    write_ledger();
    for (size_t id = 1; id < film.size(); id++)
      if (type_of[id] > 0) film_log_.write(Film{now_, int32_t(id), 0, film[id]});
    for (size_t k = 0; k < walls.film.size(); k++)
      if (walls.film[k] > 0) wall_film_log_.write(Film{now_, int32_t(k), 0, walls.film[k]});
  }
  flush();
}

void Bridges::flush() {
  for (RecordFile *log :
       {&event_log_, &contact_log_, &ledger_log_, &bridge_log_, &film_log_, &wall_film_log_, &energy_log_, &wire_log_, &drop_log_})
    log->flush();
}

// Where every sphere of this rank was when the run stopped: stopped.<rank>.csv, for a look at the cause.
void Bridges::save_stop(const std::string &why) const {
  FILE *file = fopen((directory_ + "/stopped." + std::to_string(rank_) + ".csv").c_str(), "w");
  if (!file) return;
  fprintf(file, "# step %lld: %s\nid,x,y,z,vx,vy,vz,film\n", static_cast<long long>(now_), why.c_str());
  for (int a = 0; a < at_.nlocal; a++) {
    const double *x = at_.x[a], *v = at_.v[a];
    fprintf(file, "%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", at_.tag[a], x[0], x[1], x[2], v[0], v[1], v[2],
            film[at_.tag[a]]);
  }
  fclose(file);
}

}  // namespace pywet
