// What a scene asks of the plugin, set once before the run.
#pragma once
#include <vector>

#include "vec.h"

namespace pywet {

// A region in which spheres leave the run: low <= centre < high, infinite where it is open.
struct Outlet {
  Vec low, high;
  bool holds(const Vec &x) const {
    return low.x <= x.x && x.x < high.x && low.y <= x.y && x.y < high.y && low.z <= x.z && x.z < high.z;
  }
};

struct Settings {
  Vec gravity;
  bool batched = false;                 // contacts of spheres in batches, see contacts.h
  bool touches_faces = false;           // contacts with the triangles of walls are made here, see faces.h
  bool scripted = false;                // the engine reads a script of the user's own, in which spheres come and go
  double largest_overlap = 0.5;         // of the smaller radius; beyond, the run stops
  bool moist = true;                    // false: nothing but contacts with prisms
  bool semi_implicit = false;
  bool energy = true;                   // works are added up and logged
  bool weighs = false;                  // the liquid has mass
  double density = 0;                   // of the liquid
  bool retires = false;                 // spheres that lie in the bin are taken out at checkpoints
  double retire_below = 0;              // height of the centre [m]
  double retire_slower = 0;             // speed [m/s]
  std::vector<Outlet> outlets;          // in place of the bin: who is in one of them at a checkpoint is taken out

  // Number of the outlet, from 1 on, that holds a centre; 0: none.
  int outlet(const Vec &x) const {
    for (size_t k = 0; k < outlets.size(); k++)
      if (outlets[k].holds(x)) return int(k) + 1;
    return 0;
  }
};

}  // namespace pywet
