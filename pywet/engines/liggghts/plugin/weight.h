// What the liquid weighs on each sphere: its film and its side of each bridge.
#pragma once
#include <vector>

#include "energy.h"
#include "records.h"

namespace pywet {

class Weight {
 public:
  Weight(const SimulationState &world, const BridgeList &standing, EnergyBook &energy)
      : world_(world), standing_(standing), energy_(energy) {}
  void begin();                          // before the first step, or where a run resumes
  void weigh(bool fresh);                // at the start of a step's part
  void carry(const std::vector<Event> &events);
  void carry(const Drop &d);
  void taken_up() { heavier_ = true; }

 private:
  const SimulationState &world_;
  const BridgeList &standing_;
  EnergyBook &energy_;
  bool heavier_ = false;                 // the liquid on the spheres is not in their mass yet

  double wet_mass(int a) const;
};

}  // namespace pywet
