// The life of the liquid: films, bridges, formation, forces, rupture, sharing out, ledger, logs.
//
// State (films, bridges, wall films) is the same on every rank. Each step, the rank that owns sphere i of a pair decides about
// it; the events of all ranks are gathered, sorted and booked by every rank alike, so results do not depend on the ranks.
#pragma once
#include <mpi.h>

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "laws.h"
#include "records.h"
#include "walls.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace pywet {

struct Bridge {
  int kind, i, j;                        // j: sphere id or wall part
  double volume, rupture_distance;       // static
  int triangle = -1;
  int candidate = -1;                    // index into the local candidates of its kind, or -1
  Site site;
};

struct Candidate {
  int i, j;                              // ids (j: part for walls)
  bool active;
  Site site;
};

// One bridge or pair as it stands in this step.
struct Geometry {
  Vec xi, vi, wi, xj, vj, wj, n;
  double separation, radius_i, radius_j;
  int triangle;
};

class Bridges {
 public:
  Laws laws;
  TransferTables transfer;
  Walls walls;
  std::vector<double> type_radius, type_angle;   // index: type - 1
  std::vector<int> type_of;                       // index: sphere id
  std::vector<double> film;                       // index: sphere id [m3]
  std::vector<int64_t> output_steps, window_first, window_last;

  void attach(LAMMPS_NS::LAMMPS *lmp, const std::string &directory);
  void step(int64_t n);
  void flush();

 private:
  LAMMPS_NS::LAMMPS *lmp_ = nullptr;
  MPI_Comm world_ = MPI_COMM_NULL;
  int rank_ = 0, ranks_ = 1;
  int64_t now_ = -1;
  double time_ = 0, initial_ = 0, margin_ = 0;
  int64_t formations_ = 0, ruptures_ = 0;
  std::vector<double> thickness_;                 // of the film on each sphere
  std::vector<double> part_thickness_;            // the largest since the candidates were made, per part
  std::vector<Bridge> bridges_;
  std::unordered_map<uint64_t, int> index_;       // key -> bridge
  std::vector<Candidate> pairs_, wall_pairs_;
  std::unordered_map<uint64_t, int> proposed_;    // key -> candidate, of this step
  std::vector<Event> events_;
  RecordFile event_log_, contact_log_, ledger_log_, bridge_log_, film_log_, wall_film_log_;

  static uint64_t key(int kind, int i, int j) {
    return (uint64_t(kind == SPHERE ? 0 : 1) << 62) | (uint64_t(uint32_t(i)) << 31) | uint64_t(uint32_t(j));
  }
  double radius(int id) const { return type_radius[type_of[id] - 1]; }
  double angle(int id) const { return type_angle[type_of[id] - 1]; }
  double reach(int id) const { return radius(id) + thickness_[id]; }
  void set_film(int id, double volume);
  int local(int id) const;
  bool owned(int id) const;
  void read_mesh_motion();
  void find_candidates();
  void find_pair_candidates();
  void find_wall_candidates();
  bool pair_geometry(int i, int j, Geometry &g) const;
  void wall_geometry(int i, int part, const Closest &c, Geometry &g) const;
  bool geometry(Bridge &b, Geometry &g);
  double reduced_volume(const Bridge &b) const;
  double share(const Bridge &b) const;
  double angle_j(int kind, int j) const { return kind == SPHERE ? angle(j) : walls.parts[j].contact_angle; }
  double rupture_limit(const Bridge &b, const Geometry &g) const;
  void act(const Bridge &b, const Geometry &g, bool log);
  void stand_or_rupture(bool decide, bool log);
  void propose_pairs();
  void propose_walls();
  void propose(int kind, int i, int j, int candidate, const Geometry &g, double drawn_i, double drawn_j);
  void gather_events();
  void book();
  void book_formations();
  void book_ruptures();
  void snapshot();
  void write_ledger();
  bool logging() const;
};

}  // namespace pywet
