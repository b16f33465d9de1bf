// The events of a step: every rank books those of its spheres and ghosts, in the same order. The films of walls, which all ranks know,
// change by what all of them have together.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "logs.h"
#include "near_pairs.h"
#include "weight.h"

namespace pywet {

class Booking {
 public:
  std::vector<Event> events;             // of this step: proposed by this rank; gathered, all with an end here, in order
  bool any = false;                      // on any rank

  Booking(const SimulationState &world, Films &films, BridgeList &standing, NearPairs &near, EnergyBook &energy, Weight &weight, Logs &logs)
      : world_(world), films_(films), standing_(standing), near_(near), energy_(energy), weight_(weight), logs_(logs) {}
  void gather(const std::string &problem);  // `problem` of this rank, or empty; all ranks stop if one has a problem
  void book();                           // every rank takes part

 private:
  const SimulationState &world_;
  Films &films_;
  BridgeList &standing_;
  NearPairs &near_;
  EnergyBook &energy_;
  Weight &weight_;
  Logs &logs_;

  bool at_walls_ = false;                // any of them, on any rank

  bool mine(const Event &e) const;       // decided and written here
  struct AtWall {
    int64_t film;
    double volume;
  };
  std::vector<int> place_;               // of a wall's film in the sums that are made; -1: in none
  // A part of the events at walls, of all ranks together; every rank takes part.
  std::vector<AtWall> of_walls(const std::function<double(const Event &)> &part);
  void grant();                          // what formations draw
  void count(const Event &e);
  void book_all();
  void book_formations();
  void book_ruptures();
};

}  // namespace pywet
