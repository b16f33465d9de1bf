// Forces of one bridge outside the batches: for bridges that have just formed and for semi-implicit drag.
#pragma once
#include "energy.h"
#include "impulse_sums.h"

namespace pywet {

class Single {
 public:
  Single(const SimulationState &world, BridgeList &standing, EnergyBudget &energy, const ImpulseSums &sums)
      : world_(world), standing_(standing), energy_(energy), sums_(sums) {}
  Terms laws(size_t bridge, const Geometry &g) const;  // same values as in a batch
  // With t.kick = 0 at the present velocities; otherwise at those at the end of the step, see semi_implicit_drag.cpp.
  void add_viscous(const Bridge &b, const Geometry &g, Terms &t) const;
  void act(const Bridge &b, const Geometry &g, const Terms &t);
  [[noreturn]] void not_finite(const Bridge &b, double separation) const;

 private:
  const SimulationState &world_;
  BridgeList &standing_;
  EnergyBudget &energy_;
  const ImpulseSums &sums_;
};

}  // namespace pywet
