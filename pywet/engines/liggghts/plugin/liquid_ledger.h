// Liquid ledger of a step: every rank applies the events of its own spheres and ghosts, in the same order. All ranks store the films
// of walls, which change by the sum over all ranks.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "logs.h"
#include "near_pairs.h"
#include "weight.h"

namespace pywet {

class LiquidLedger {
 public:
  std::vector<Event> events;             // events of this step: those this rank proposes; after gather() all with an end here, sorted
  bool any = false;                      // whether there is an event on any rank

  LiquidLedger(const SimulationState &world, Films &films, BridgeList &standing, NearPairs &near, EnergyBudget &energy, Weight &weight, Logs &logs)
      : world_(world), films_(films), standing_(standing), near_(near), energy_(energy), weight_(weight), logs_(logs) {}
  void gather(const std::string &problem);  // `problem`: message of this rank, or empty; all ranks stop if there is one
  void apply_events();                           // collective: call on every rank

 private:
  const SimulationState &world_;
  Films &films_;
  BridgeList &standing_;
  NearPairs &near_;
  EnergyBudget &energy_;
  Weight &weight_;
  Logs &logs_;

  bool at_walls_ = false;                // whether any event on any rank is at a wall

  bool mine(const Event &e) const;       // whether this rank decides about the event and writes it
  struct AtWall {
    int64_t film;
    double volume;
  };
  std::vector<int> place_;               // index of a wall's film in the arrays that are summed over ranks; -1: not in them
  // Sums over all ranks what the events at walls move; collective.
  std::vector<AtWall> of_walls(const std::function<double(const Event &)> &part);
  void grant();                          // distributes the liquid that formations draw
  void count(const Event &e);
  void apply_all();
  void apply_formations();
  void apply_ruptures();
};

}  // namespace pywet
