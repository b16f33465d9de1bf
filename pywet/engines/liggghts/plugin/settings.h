// Settings of the scene for the plugin, fixed before the run.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "vec.h"

namespace pywet {

// A region in which spheres leave the run: low <= centre < high, infinite where it is open. With a finite `least`, of spheres that
// were as high since they crossed the plane of its low x, on the parabola through position and velocity, at most `longest` before.
struct Outlet {
  Vec low, high;
  double least, longest;
  bool holds(const Vec &x, const Vec &v, const Vec &gravity) const {
    return low.x <= x.x && x.x < high.x && low.y <= x.y && x.y < high.y && low.z <= x.z && x.z < high.z &&
           (std::isinf(least) || highest(x, v, gravity) >= least);
  }
  double highest(const Vec &x, const Vec &v, const Vec &g) const {
    const double beyond = x.x - low.x;
    const double mean = 0.5 * (v.x + std::sqrt(v.x * v.x - 2 * g.x * beyond));  // speed along x since the crossing; NaN: none
    const double back = mean * longest > beyond ? beyond / mean : longest;
    const auto height = [&](double before) { return x.z - before * v.z + 0.5 * before * before * g.z; };
    const double apex = g.z < 0 ? std::clamp(v.z / g.z, 0.0, back) : 0.0;
    return std::max({x.z, height(apex), height(back)});
  }
};

struct Settings {
  Vec gravity;
  bool batched = false;                 // contacts of spheres are evaluated in batches, see contacts.h
  bool touches_faces = false;           // contacts with triangles of walls are made by the plugin, see faces.h
  bool scripted = false;                // the engine reads a user's script, in which spheres are inserted and removed
  double largest_overlap = 0.5;         // relative to the smaller radius; the run stops beyond it
  bool moist = true;                    // false: only contacts with analytic wires
  bool semi_implicit = false;
  bool energy = true;                   // work terms are accumulated and logged
  bool weighs = false;                  // the liquid has mass
  double density = 0;                   // density of the liquid [kg/m3]
  bool retires = false;                 // spheres that lie in the bin are removed at checkpoints
  double retire_below = 0;              // height of the centre below which a sphere is removed [m]
  double retire_slower = 0;             // speed below which a sphere is removed [m/s]
  std::vector<Outlet> outlets;          // in place of the bin: spheres inside one of them at a checkpoint are removed

  // Number of the outlet, from 1, in which a sphere of this position and velocity leaves; 0: none.
  int outlet(const Vec &x, const Vec &v) const {
    for (size_t k = 0; k < outlets.size(); k++)
      if (outlets[k].holds(x, v, gravity)) return int(k) + 1;
    return 0;
  }
};

}  // namespace pywet
