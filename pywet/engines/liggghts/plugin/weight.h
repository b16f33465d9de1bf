// Weight of the liquid on each sphere: its film and its side of each bridge.
#pragma once
#include <vector>

#include "energy.h"
#include "records.h"

namespace pywet {

class Weight {
 public:
  Weight(const SimulationState &world, const BridgeList &standing, EnergyBudget &energy)
      : world_(world), standing_(standing), energy_(energy) {}
  void begin();                          // call before the first step, or after a resumption
  void weigh(bool fresh);                // call at the start of the plugin's part of a step
  void carry(const std::vector<Event> &events);
  void carry(const Drop &d);
  void taken_up() { heavier_ = true; }

 private:
  const SimulationState &world_;
  const BridgeList &standing_;
  EnergyBudget &energy_;
  bool heavier_ = false;                 // the liquid on the spheres is not yet included in their mass

  double wet_mass(int a) const;
};

}  // namespace pywet
