// What a scene asks of the plugin, set once before the run.
#pragma once
#include "vec.h"

namespace pywet {

struct Rules {
  Vec gravity;
  bool batched = false;                 // contacts of spheres in batches, see contacts.h
  bool touches_faces = false;           // contacts with the triangles of walls are made here, see faces.h
  double largest_overlap = 0.5;         // of the smaller radius; beyond, the run stops
  bool moist = true;                    // false: nothing but contacts with prisms
  bool semi_implicit = false;
  bool energy = true;                   // works are added up and logged
  bool weighs = false;                  // the liquid has mass
  double density = 0;                   // of the liquid
  bool retires = false;                 // spheres that lie in the bin are taken out at checkpoints
  double retire_below = 0;              // height of the centre [m]
  double retire_slower = 0;             // speed [m/s]
};

}  // namespace pywet
