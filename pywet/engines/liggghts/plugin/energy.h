// Work done on the spheres since the start, by effect, and the energy of bridges [J]. energy.cpp says how it is added up.
#pragma once
#include <vector>

#include "standing.h"

namespace pywet {

enum Effect { GRAVITY, CONTACT, CAPILLARY, VISCOUS_NORMAL, VISCOUS_TANGENTIAL, WALL, DRIVE, EFFECTS };

// Forces of the bridges on one sphere in this step, by effect, and the torque of the tangential one.
struct Acting {
  double capillary[3], normal[3], tangential[3], torque[3];
};

// What is added up from step to step; plain numbers, so that a checkpoint can hold it as it is.
struct Sums {
  double work[EFFECTS] = {};   // up to the present step
  double power[EFFECTS] = {};  // at the present step
  double half_kick = 0;        // what the rule of the work leaves out: see energy.cpp
  double pending_kick = 0;
};

class EnergyBook {
 public:
  Sums sums;
  double formed = 0, ruptured = 0;     // capillary energy that formations stored and ruptures lost, of bridges that are counted here
  double kinetic = 0, spin = 0;        // of this rank's free spheres
  double wall_power[EFFECTS] = {};     // of this step, through bridges at moving walls, by effect
  std::vector<Acting> acting;          // by local index

  EnergyBook(const SimulationState &world, const BridgeList &standing) : world_(world), standing_(standing) {}
  void begin(double power_of_walls);   // a step
  void add(const Bridge &b, const Geometry &g, const Terms &t);
  void add_up();                       // once all forces are known
  double stored(size_t bridge, double separation) const;

 private:
  const SimulationState &world_;
  const BridgeList &standing_;

  void add(int a, const Vec &capillary, const Vec &normal, const Vec &tangential, const Vec &torque);
};

}  // namespace pywet
