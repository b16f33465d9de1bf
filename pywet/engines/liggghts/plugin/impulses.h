// Forces of bridges that act every few steps, for as many steps as they stand for.
#pragma once
#include <vector>

#include "energy.h"

namespace pywet {

class MultipleTimeStepping {
 public:
  double weight = 1;                     // steps for which the forces that are being evaluated act

  MultipleTimeStepping(const SimulationState &world, EnergyBook &energy) : world_(world), energy_(energy) {}
  bool on() const { return world_.clock.bridges_every > 1; }
  void set_aside();                      // all other forces; those of bridges are gathered from zero
  void act();                            // they are weighed and added to the others

  // No sphere has moved further than this since the last look, nor since the near pairs were found, when `fresh`.
  double moved(bool fresh);

 private:
  const SimulationState &world_;
  EnergyBook &energy_;
  std::vector<double> others_;           // forces and torques, works and power, while those of bridges are gathered
  std::vector<Acting> other_works_;
  double other_power_[EFFECTS] = {};
  std::vector<Vec> before_;              // where spheres and ghosts were at the last look
};

}  // namespace pywet
