// Work done on the spheres since the start, by effect, and the energy of bridges [J]; for the method see energy.cpp.
#pragma once
#include <vector>

#include "bridge_list.h"

namespace pywet {

enum Effect { GRAVITY, CONTACT, CAPILLARY, VISCOUS_NORMAL, VISCOUS_TANGENTIAL, WALL, DRIVE, EFFECTS };

// Forces of the bridges on one sphere in this step, by effect, and the torque of the tangential one.
struct Acting {
  double capillary[3], normal[3], tangential[3], torque[3];
};

// Accumulated sums; plain numbers, so that a checkpoint can store the object as it is.
struct Sums {
  double work[EFFECTS] = {};   // work up to the present step
  double power[EFFECTS] = {};  // power at the present step
  double half_kick = 0;        // remainder of the quadrature rule, see energy.cpp
  double pending_kick = 0;
};

class EnergyBudget {
 public:
  Sums sums;
  double formed = 0, ruptured = 0;     // capillary energy stored by formations and lost by ruptures, of the bridges that this rank counts
  double kinetic = 0, spin = 0;        // kinetic energy of this rank's free spheres
  double wall_power[EFFECTS] = {};     // power of moving walls through bridges in this step, by effect
  std::vector<Acting> acting;          // forces and torques by local index

  EnergyBudget(const SimulationState &world, const BridgeList &standing) : world_(world), standing_(standing) {}
  void begin(double power_of_walls);   // begins a step
  void add(const Bridge &b, const Geometry &g, const Terms &t);
  void add_up();                       // call when all forces are known
  double stored(size_t bridge, double separation) const;

 private:
  const SimulationState &world_;
  const BridgeList &standing_;

  void add(int a, const Vec &capillary, const Vec &normal, const Vec &tangential, const Vec &torque);
};

}  // namespace pywet
