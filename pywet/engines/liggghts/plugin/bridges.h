// The life of the liquid: films, bridges, formation, forces, rupture, sharing out, ledger, logs, checkpoints.
//
// State (films, bridges, wall films) is the same on every rank. Each step, the rank that owns sphere i of a pair decides about
// it; the events of all ranks are gathered, sorted and booked by every rank alike, so results do not depend on the ranks.
// Which file does what: engine.cpp asks the engine (the only one with its headers), formation.cpp and forces.cpp act on what
// stands near, weight.cpp and shedding.cpp hold what the liquid weighs and what drips, together.cpp holds their loops over many bridges, prisms.cpp dry contacts with wires, implicit.cpp holds the semi-implicit drag, impulses.cpp lets bridges act every few steps, booking.cpp books, energy.cpp adds up work, output.cpp writes, checkpoint.cpp saves and restores.
#pragma once
#include <mpi.h>

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "energy.h"
#include "laws.h"
#include "prisms.h"
#include "records.h"
#include "together.h"
#include "walls.h"

namespace LAMMPS_NS {
class LAMMPS;
class FixMeshSurface;
class FixWallGran;
}  // namespace LAMMPS_NS

namespace pywet {

extern const double INF;

// What the engine holds in this step on this rank: arrays over owned spheres (first nlocal) and ghosts.
struct View {
  double **x = nullptr, **v = nullptr, **omega = nullptr, **f = nullptr, **torque = nullptr;
  double *mass = nullptr;
  int *tag = nullptr, *mask = nullptr;
  int nlocal = 0, nall = 0, free_group = 0;
  double dt = 0;
  bool free(int a) const { return mask[a] & free_group; }  // moved by its forces, not driven
};

// `a`, `b`: indices of i and j on this rank (-1: not here), valid until the engine makes its neighbour list anew.
struct Bridge {
  int kind, i, j;                        // j: sphere id or wall part
  double volume, rupture_distance;       // static
  int triangle = -1;
  int candidate = -1;                    // index into the local candidates of its kind, or -1
  int a = -1, b = -1;
  bool here = false;                     // this rank owns an end
  double radius_i = 0, radius_j = 0, angle_i = 0, angle_j = 0;
  std::unique_ptr<Site> site;            // at a wall
};

struct Candidate {
  int i, j;                              // ids
  int a, b;
  double radii;                          // sum of radii
  double gap;                            // between the films when the candidates were found, or less
};

struct WallCandidate {
  int i, j, a;                           // j: part
  Site site;
};

// One bridge or pair as it stands in this step.
struct Geometry {
  Vec xi, vi, wi, xj, vj, wj, n;
  double separation, radius_i, radius_j;
  int triangle;
};

// Forces of one bridge: capillary attracts, viscous acts along n on i, tangential on i.
struct Terms {
  double capillary = 0, viscous = 0, viscous_law = 0, factor_normal = 1, factor_tangential = 1;
  double drag = 0, slide = 0, roll = 0;  // coefficients of the viscous laws
  int sharing_i = 0, sharing_j = 0;
  double kick = 0;
  Vec tangential, push, spin_push;
};

// A bridge whose viscous forces wait for all other forces.
struct Waiting {
  const Bridge *bridge;
  Geometry geometry;
  Terms terms;
};

// A run that has to stop, known to every rank alike.
struct Stop : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Bridges {
 public:
  Laws laws;
  TransferTables transfer;
  Walls walls;
  std::vector<Prism> prisms;                      // wires whose dry contact is not left to the engine
  std::vector<double> type_radius, type_angle;   // index: type - 1
  std::vector<int> type_of;                       // index: sphere id
  std::vector<double> film;                       // index: sphere id [m3]
  std::vector<int64_t> output_steps, window_first, window_last;
  Vec gravity;
  double largest_overlap = 0.5;                   // of the smaller radius; beyond, the run stops
  bool semi_implicit = false;
  bool moist = true;                              // false: nothing but contacts with prisms
  bool energy = true;                             // works are added up and logged
  int64_t checkpoint_every = 0;                   // steps; 0: none
  int bridges_every = 1;                          // steps from one evaluation of the bridges to the next
  bool weighs = false;                            // the liquid has mass
  double density = 0;                             // of the liquid
  std::vector<double> type_mass;                  // dry; index: type - 1
  int64_t drop_every = 0;                         // steps between looks at what drips

  void attach(LAMMPS_NS::LAMMPS *lmp, const std::string &directory);
  void resume(const std::string &state_file);
  void step(int64_t n);
  void flush();
  void save_stop(const std::string &why) const;
  int rank() const { return rank_; }

 private:
  LAMMPS_NS::LAMMPS *lmp_ = nullptr;
  MPI_Comm world_ = MPI_COMM_NULL;
  int rank_ = 0, ranks_ = 1;
  std::string directory_;
  View at_;
  int64_t now_ = -1, spheres_ = 0;
  double time_ = 0, initial_ = 0, margin_ = 0;
  int64_t formations_ = 0, ruptures_ = 0;
  std::vector<double> thickness_;                 // of the film on each sphere
  std::vector<double> thickness_then_;            // when the candidates were found
  std::vector<int> standing_;                     // number of bridges on each sphere
  std::vector<double> part_thickness_, part_thickness_then_;  // the largest of each part, now and when the candidates were found
  std::vector<Bridge> bridges_;
  std::unordered_map<uint64_t, int> index_;       // key -> bridge
  std::vector<Line> prepared_;                    // of the capillary law, laws.lines a bridge, in the order of bridges_
  std::vector<Block> blocks_;                     // of the bridges, in the order of bridges_
  std::vector<Candidate> pairs_;                  // by the gap when they were found
  std::vector<WallCandidate> wall_pairs_;
  std::vector<double> pair_rest_, wall_rest_;     // way_ of pairs and of spheres at walls before which their films cannot touch; infinity: has a bridge
  size_t awake_ = 0;                              // the first pairs_, whose films may have met since they were found
  std::unordered_map<uint64_t, int> proposed_;    // key -> candidate, of this step
  // bounds since the candidates were found: way of a sphere and of a wall, growth of a sphere's and of a wall's film
  double travel_ = 0, wall_travel_ = 0, thicker_ = 0, wall_thicker_ = 0;
  std::vector<Event> events_;
  std::vector<Waiting> waiting_;
  Together together_;
  RecordFile event_log_, contact_log_, ledger_log_, bridge_log_, film_log_, wall_film_log_, energy_log_, wire_log_,
      drop_log_;
  std::vector<LAMMPS_NS::FixMeshSurface *> surfaces_;
  LAMMPS_NS::FixWallGran *wall_law_ = nullptr;    // the engine's dry contact with walls
  std::vector<Weave> weaves_;
  std::vector<WireCandidate> wire_candidates_;
  std::vector<WireSpring> saved_springs_;         // of the step the run is resumed at, until the first candidates are found
  std::vector<Vec> shift_then_;                   // of each mesh, when the candidates were found
  std::vector<Vec> shift_before_;                 // of each mesh, in the step before
  EnergyBook energy_;
  std::vector<double> saved_forces_;              // 6 numbers an id, of the step the run is resumed at
  double weight_ = 1;                             // steps for which the forces that are being evaluated act
  std::vector<double> others_;                    // all other forces and torques, works and power, while these are gathered
  std::vector<Acting> other_works_;
  double other_power_[EFFECTS];
  std::vector<Vec> before_;                       // where spheres and ghosts were at the last look

  std::vector<double> load_, weighed_;            // liquid a sphere carries [m3]: now, and in its present mass; index: id
  bool heavier_ = false;                          // they differ
  std::vector<double> felt_, speed_then_;         // 3 numbers an id: specific force, velocity at the last look
  double left_ = 0;                               // liquid that fell on nothing

  static uint64_t key(int kind, int i, int j) {
    return (uint64_t(kind == SPHERE ? 0 : 1) << 62) | (uint64_t(uint32_t(i)) << 31) | uint64_t(uint32_t(j));
  }
  double radius(int id) const { return type_radius[type_of[id] - 1]; }
  double angle(int id) const { return type_angle[type_of[id] - 1]; }
  double reach(int id) const { return radius(id) + thickness_[id]; }
  bool owned(int a) const { return a >= 0 && a < at_.nlocal; }

  // engine.cpp
  int local(int id) const;
  double allowed_thickness(int id) const;
  double skin() const;
  void look();
  bool lists_are_new() const;
  void read_mesh_motion(bool all);
  bool read_mesh(size_t m, double *out) const;
  void find_pair_candidates();
  void inside_the_box() const;
  Vec press(int a, double radius, const Vec &d, double distance, const Vec &wall_velocity, double *spring);

  // prisms.cpp
  void arrange_wires();
  bool wires_moved() const;
  void find_wire_candidates();
  std::vector<WireSpring> wire_springs() const;
  void touch_wires(bool fresh, bool log);

  // formation.cpp
  void find_candidates();
  void find_wall_candidates();
  void place(Bridge &b);
  Bridge made(int kind, int i, int j, double volume) const;
  void add(Bridge b);
  void sort_bridges();
  void enter(size_t k);
  void add_pair(int a, int b);
  double rest(const WallCandidate &pair, double distance) const;
  void move_bounds();
  void propose_pairs();
  void propose_walls();
  void propose(int kind, int i, int j, int candidate, const Geometry &g, double drawn_i, double drawn_j);

  // forces.cpp
  void set_film(int id, double volume);
  void pair_geometry(int a, int b, double radius_i, double radius_j, Geometry &g) const;
  void wall_geometry(int a, double radius_i, int part, const Closest &c, Geometry &g) const;
  void geometry(Bridge &b, Geometry &g);
  void check_overlap(const Geometry &g, int kind, int i, int j) const;
  double reduced_volume(const Bridge &b) const;
  double share(const Bridge &b) const;
  double angle_j(int kind, int j) const { return kind == SPHERE ? angle(j) : walls.parts[j].contact_angle; }
  double rupture_limit(const Bridge &b, const Geometry &g) const;
  Geometry geometry_of(const Together &t, int k) const;
  void gather(Together &t);
  void rupture(Together &t, bool decide);
  void evaluate(Together &t);
  void defer(Together &t);
  void act_together(Together &t, bool log);
  void record(const Together &t, int k, bool log);
  void add_viscous(const Bridge &b, const Geometry &g, Terms &t) const;
  void not_finite(const Bridge &b, double separation) const;
  void act(const Bridge &b, const Geometry &g, const Terms &t);
  void add_work(const Bridge &b, const Geometry &g, const Terms &t);
  void stand_or_rupture(bool decide, bool log);

  // impulses.cpp
  void set_aside();
  void act_as_impulses();
  void act_new(bool first, bool log);
  Terms terms_of(size_t bridge, const Geometry &g) const;
  double moved(bool fresh);

  // implicit.cpp
  double kick_of(const Bridge &b, Terms &t) const;
  void act_at_the_end(bool log);

  // booking.cpp
  void agree(const std::string &problem);
  template <class T>
  std::vector<T> gathered(const std::vector<T> &mine) const;
  void gather_events();
  void book();
  void book_formations();
  void book_ruptures();

  // energy.cpp
  void begin_work();
  void add_work(bool first, bool again);
  double stored(size_t bridge, double separation) const;
  void book_energy_of_events();

  // weight.cpp
  double wet_mass(int id) const;
  void load();
  void weigh(bool again, bool fresh);
  void carry();

  // shedding.cpp
  std::vector<double> everywhere() const;
  void feel(const std::vector<double> &now);
  void land(const std::vector<double> &now, Drop &d) const;
  void fall(Drop &d);
  void shed();

  // output.cpp
  void open_logs();
  bool logging() const;
  void write_contact(const Bridge &b, const Geometry &g, const Terms &t);
  void write_ledger();
  void write_energy();
  void snapshot();

  // checkpoint.cpp
  void save_state();
  void restore_forces();
};

double film_thickness(double volume, double r);

// Records of all ranks, in order of the ranks.
template <class T>
std::vector<T> Bridges::gathered(const std::vector<T> &mine) const {
  std::vector<int> bytes(ranks_), offset(ranks_, 0);
  const int size = int(mine.size() * sizeof(T));
  MPI_Allgather(&size, 1, MPI_INT, bytes.data(), 1, MPI_INT, world_);
  for (int k = 1; k < ranks_; k++) offset[k] = offset[k - 1] + bytes[k - 1];
  std::vector<T> all((offset.back() + bytes.back()) / sizeof(T));
  MPI_Allgatherv(mine.data(), size, MPI_BYTE, all.data(), bytes.data(), offset.data(), MPI_BYTE, world_);
  return all;
}

}  // namespace pywet
