// Bridges whose viscous forces are evaluated after all other forces.
#pragma once
#include <vector>

#include "logs.h"
#include "multiple_time_stepping.h"
#include "single.h"

namespace pywet {

class SemiImplicitDrag {
 public:
  SemiImplicitDrag(const SimulationState &world, const BridgeList &standing, Single &single, MultipleTimeStepping &impulses, Logs &logs)
      : world_(world), standing_(standing), single_(single), impulses_(impulses), logs_(logs) {}
  void clear() { waiting_.clear(); }
  void wait(Bridge &b, const Geometry &g, const Terms &t) { waiting_.push_back(Waiting{&b, g, t}); }
  void act();                            // collective; call when all other forces are known

 private:
  struct Waiting {
    Bridge *bridge;
    Geometry geometry;
    Terms terms;
  };
  const SimulationState &world_;
  const BridgeList &standing_;
  Single &single_;
  MultipleTimeStepping &impulses_;
  Logs &logs_;
  std::vector<Waiting> waiting_;

};

}  // namespace pywet
