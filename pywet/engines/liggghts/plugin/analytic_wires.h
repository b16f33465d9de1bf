// Dry contacts with analytic wires: the engine's law at the closest point, one tangential spring for each sphere and wire.
#pragma once
#include <vector>

#include "analytic_wire.h"
#include "logs.h"
#include "simulation_state.h"

namespace pywet {

// Tangential spring of a sphere on a wire, or on a triangle (faces.h: number -1 - triangle); stored across searches and in checkpoints.
struct WireSpring {
  int32_t id, wire;
  double spring[3];
  bool operator<(const WireSpring &other) const { return id != other.id ? id < other.id : wire < other.wire; }
};

class AnalyticWires {
 public:
  std::vector<AnalyticWire> parts;

  AnalyticWires(const SimulationState &world, EnergyBudget &energy, Logs &logs) : world_(world), energy_(energy), logs_(logs) {}
  void arrange();                        // groups the parallel wires of a mesh, sorted across
  void touch(bool fresh);                // call after the engine's contacts, before the bridges

  // Tangential springs that are not zero; directly after a resumption all those of the checkpoint.
  std::vector<WireSpring> springs() const;
  void take_up(const std::vector<WireSpring> &springs);

 private:
  // Parallel wires of a mesh, sorted by their position on the axis across them.
  struct Weave {
    int mesh, axis;
    bool second;                          // whether this axis is `up` or `across`
    double widest;                        // radius of the largest circle around a section
    std::vector<double> place;
    std::vector<int> wires;               // indices of analytic wires, by position
  };

  // Sphere that may touch a wire before the next search; `a`: its local index.
  struct Candidate {
    int a, id, wire;
    double spring[3];
  };

  const SimulationState &world_;
  EnergyBudget &energy_;
  Logs &logs_;
  std::vector<Weave> weaves_;
  std::vector<Candidate> candidates_;
  std::vector<WireSpring> saved_;        // springs of the step at which the run is resumed, until the first search
  std::vector<Vec> shift_then_;          // shift of each mesh at the last search

  bool moved() const;
  void find();
};

}  // namespace pywet
