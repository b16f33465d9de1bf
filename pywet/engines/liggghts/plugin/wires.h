// Dry contacts with wires that are prisms: the engine's own law at the closest point, one spring for each sphere and wire.
#pragma once
#include <vector>

#include "logs.h"
#include "prism.h"
#include "world.h"

namespace pywet {

// The tangential spring of a sphere on a wire, or on a triangle (faces.h: then -1 less its number); handed on when the candidates are found anew, and by checkpoints.
struct WireSpring {
  int32_t id, wire;
  double spring[3];
  bool operator<(const WireSpring &other) const { return id != other.id ? id < other.id : wire < other.wire; }
};

class AnalyticWires {
 public:
  std::vector<Prism> prisms;

  AnalyticWires(const SimulationState &world, EnergyBook &energy, Logs &logs) : world_(world), energy_(energy), logs_(logs) {}
  void arrange();                        // groups parallel wires of a mesh, in order across
  void touch(bool fresh);                // after the engine's own contacts, before the bridges

  // The springs here that are not zero; just after a resumption those of the checkpoint, all of them.
  std::vector<WireSpring> springs() const;
  void take_up(const std::vector<WireSpring> &springs);

 private:
  // Parallel wires of a mesh in order of their place on the axis that tells them apart.
  struct Weave {
    int mesh, axis;
    bool second;                          // whether that is `up` or `across`
    double widest;                        // radius of the largest circle about a section
    std::vector<double> place;
    std::vector<int> wires;               // indices of prisms, by place
  };

  // A sphere that may touch a wire before the candidates are found anew; `a`: its local index.
  struct Candidate {
    int a, id, wire;
    double spring[3];
  };

  const SimulationState &world_;
  EnergyBook &energy_;
  Logs &logs_;
  std::vector<Weave> weaves_;
  std::vector<Candidate> candidates_;
  std::vector<WireSpring> saved_;        // of the step the run is resumed at, until the first candidates are found
  std::vector<Vec> shift_then_;          // of each mesh, when the candidates were found

  bool moved() const;
  void find();
};

}  // namespace pywet
