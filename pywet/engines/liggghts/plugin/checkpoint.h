// Writes and restores the plugin's state at a step.
#pragma once
#include <memory>
#include <string>

#include "analytic_wires.h"
#include "faces.h"
#include "shedding.h"

namespace pywet {

// State of a sphere in a checkpoint: its place in the plan view (for state_file.py, which reads these records), its liquid as in View::liquid,
// force and torque of the step.
struct SphereState {
  int64_t id;
  double place[2], film, load, weighed, impulse[3], force[3], torque[3];
};
static_assert(sizeof(SphereState) == 120, "records must match SPHERE of state_file.py");

class Checkpoint {
 public:
  Checkpoint(SimulationState &world, Films &films, BridgeList &standing, EnergyBudget &energy, Faces &faces, AnalyticWires &wires, Weight &weight, Shedding &shedding,
             Logs &logs)
      : world_(world), films_(films), standing_(standing), energy_(energy), faces_(faces), wires_(wires), weight_(weight), shedding_(shedding),
        logs_(logs) {}
  void save();                                   // call at the end of the plugin's part of a step, when all forces are known
  void resume(const std::string &state_file);    // every rank reads the same file before the first step
  bool restore_forces();                         // call in the set-up of a resumed run; returns false in a run that is not resumed

 private:
  SimulationState &world_;
  Films &films_;
  BridgeList &standing_;
  EnergyBudget &energy_;
  Faces &faces_;
  AnalyticWires &wires_;
  Weight &weight_;
  Shedding &shedding_;
  Logs &logs_;
  std::shared_ptr<const char> file_;             // state file of the step at which the run is resumed, until its forces are restored
  const SphereState *spheres_ = nullptr;         // spheres in this file, by id
  int64_t count_ = 0;

  const SphereState &of(int id) const;
};

}  // namespace pywet
