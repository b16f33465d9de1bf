// Removes spheres that have passed and lie in the bin, with their liquid, at checkpoints.
#pragma once
#include "liquid_ledger.h"

namespace pywet {

class Retirement {
 public:
  Retirement(SimulationState &world, Films &films, BridgeList &standing, LiquidLedger &ledger, Logs &logs)
      : world_(world), films_(films), standing_(standing), ledger_(ledger), logs_(logs) {}
  void retire();                         // call at the end of a step, when its forces and events are complete

 private:
  SimulationState &world_;
  Films &films_;
  BridgeList &standing_;
  LiquidLedger &ledger_;
  Logs &logs_;

  std::vector<RetiredSphere> chosen() const;  // spheres of this rank to be removed
  void end_bridges();
  void hand_over(std::vector<RetiredSphere> &all);
};

}  // namespace pywet
