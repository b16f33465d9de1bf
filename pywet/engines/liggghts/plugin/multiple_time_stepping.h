// Multiple time stepping: bridge forces are evaluated every few steps and applied as impulses for that many steps.
#pragma once
#include <vector>

#include "energy.h"

namespace pywet {

class MultipleTimeStepping {
 public:
  double weight = 1;                     // number of steps for which the forces being evaluated act

  MultipleTimeStepping(const SimulationState &world, EnergyBudget &energy) : world_(world), energy_(energy) {}
  bool on() const { return world_.clock.bridges_every > 1; }
  void set_aside();                      // stores all other forces; those of bridges are then accumulated from zero
  void act();                            // multiplies the bridge forces by their weight and adds the stored forces

  // Upper bound of the displacement of any sphere since the last call, and, with `fresh`, since the last search for near pairs.
  double moved(bool fresh);

 private:
  const SimulationState &world_;
  EnergyBudget &energy_;
  std::vector<double> others_;           // other forces and torques, works and power, while those of bridges are accumulated
  std::vector<Acting> other_works_;
  double other_power_[EFFECTS] = {};
  std::vector<Vec> before_;              // positions of spheres and ghosts at the last call
};

}  // namespace pywet
