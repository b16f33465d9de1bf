// The plugin: its components, and their order within a step.
//
// Each step, the rank that owns sphere i of a pair decides about it. Every event goes to all ranks that hold one of its spheres,
// as its own or as a ghost; each applies those it holds, in sorted order, so that results do not depend on the number of ranks.
#pragma once
#include <string>

#include "checkpoint.h"
#include "faces.h"
#include "forces.h"
#include "liquid_ledger.h"
#include "retirement.h"
#include "turnover.h"

namespace pywet {

class Plugin {
 public:
  SimulationState world;
  Films films{world};
  BridgeList standing{world};
  EnergyBudget energy{world, standing};
  ImpulseSums sums{world};
  Logs logs{world, films, standing, energy, sums};
  Faces faces{world, energy, logs};
  AnalyticWires wires{world, energy, logs};
  Single single{world, standing, energy, sums};
  MultipleTimeStepping impulses{world, energy};
  SemiImplicitDrag implicit{world, standing, single, impulses, logs};
  Forces forces{world, standing, energy, single, sums, impulses, implicit, logs};
  NearPairs near{world, films, standing};
  Weight weight{world, standing, energy};
  LiquidLedger ledger{world, films, standing, near, energy, weight, logs};
  Shedding shedding{world, films, weight, logs};
  Retirement retirement{world, films, standing, ledger, logs};
  Turnover turnover{world, films, standing, logs};
  Checkpoint checkpoint{world, films, standing, energy, faces, wires, weight, shedding, logs};
  bool joined = false;                  // whether walls continue through faces of the box, see Engine::join_corners

  Plugin() = default;
  Plugin(const Plugin &) = delete;       // the components hold references to each other
  void attach(LAMMPS_NS::LAMMPS *lmp, const std::string &directory);
  void resume(const std::string &state_file);
  void step(int64_t n);
  void create();                         // creates the spheres that are due at a checkpoint

 private:
  bool wet() const { return films.initial > 0; }
  bool deletes_springs() const { return wet() || !world.rules.scripted; }  // a script without liquid moves as the stock program
  bool touches_walls() const { return world.rules.touches_faces || !wires.parts.empty(); }
  void act(bool fresh);
};

}  // namespace pywet
