// Forces and torques of the active bridges in batches, and the bridges that rupture.
#pragma once
#include <vector>

#include "bridge_batch.h"
#include "semi_implicit_drag.h"

namespace pywet {

class Forces {
 public:
  Forces(const SimulationState &world, BridgeList &standing, EnergyBudget &energy, Single &single, ImpulseSums &sums, MultipleTimeStepping &impulses,
         SemiImplicitDrag &implicit, Logs &logs)
      : world_(world), standing_(standing), energy_(energy), single_(single), sums_(sums), impulses_(impulses), implicit_(implicit),
        logs_(logs) {}

  // Evaluates all active bridges; those that rupture are skipped and become events.
  void act(std::vector<Event> &events);
  // Evaluates bridges that have just formed, in multiple time stepping; collective.
  void act_new(const std::vector<Event> &events);

 private:
  const SimulationState &world_;
  BridgeList &standing_;
  EnergyBudget &energy_;
  Single &single_;
  ImpulseSums &sums_;
  MultipleTimeStepping &impulses_;
  SemiImplicitDrag &implicit_;
  Logs &logs_;
  BridgeBatch together_{};

  Geometry geometry_of(const BridgeBatch &t, int k) const;
  void gather(BridgeBatch &t);
  void rupture(BridgeBatch &t, std::vector<Event> &events) const;
  void evaluate(BridgeBatch &t);
  void defer(BridgeBatch &t);
  void add(BridgeBatch &t);
  void record(const BridgeBatch &t, int k);
};

}  // namespace pywet
