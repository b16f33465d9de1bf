// The plugin's state at a step, saved and taken up.
#pragma once
#include <memory>
#include <string>

#include "faces.h"
#include "shedding.h"
#include "wires.h"

namespace pywet {

// A sphere of a checkpoint: its place in the plan view (for state_file.py, which reads these records), its liquid as in View::liquid, force
// and torque of the step.
struct SphereState {
  int64_t id;
  double place[2], film, load, weighed, impulse[3], force[3], torque[3];
};
static_assert(sizeof(SphereState) == 120, "records must match SPHERE of state_file.py");

class Checkpoint {
 public:
  Checkpoint(SimulationState &world, Films &films, BridgeList &standing, EnergyBook &energy, Faces &faces, AnalyticWires &wires, Weight &weight, Shedding &shedding,
             Logs &logs)
      : world_(world), films_(films), standing_(standing), energy_(energy), faces_(faces), wires_(wires), weight_(weight), shedding_(shedding),
        logs_(logs) {}
  void save();                                   // at the end of the plugin's part of a step; forces are complete
  void resume(const std::string &state_file);    // every rank reads the same file, before the first step
  bool restore_forces();                         // in the set-up of a run that goes on; false: of another

 private:
  SimulationState &world_;
  Films &films_;
  BridgeList &standing_;
  EnergyBook &energy_;
  Faces &faces_;
  AnalyticWires &wires_;
  Weight &weight_;
  Shedding &shedding_;
  Logs &logs_;
  std::shared_ptr<const char> file_;             // of the step the run is resumed at, until its forces are restored
  const SphereState *spheres_ = nullptr;         // in it, by id
  int64_t count_ = 0;

  const SphereState &of(int id) const;
};

}  // namespace pywet
