// Settings of the scene for the plugin, fixed before the run.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "vec.h"

namespace pywet {

// Vibration of a wall from where it is at the start, along x and z; at rest with amplitudes of 0.
struct Sway {
  Vec amplitude, phase;
  double rate;                          // 2 pi times the frequency [rad/s]
  double x(double time) const { return along(amplitude.x, phase.x, time); }
  double z(double time) const { return along(amplitude.z, phase.z, time); }
  double highest() const { return amplitude.z * (1 - std::sin(phase.z)); }

 private:
  double along(double a, double p, double time) const {
    return a == 0 ? 0.0 : a * (std::sin(rate * std::max(0.0, time) + p) - std::sin(p));
  }
};

// A region in which spheres leave the run: low <= centre < high, infinite where it is open. With a finite `least`, of spheres that
// were as high when they last crossed the plane of its low x, on the parabola through position and velocity, at most `longest`
// before; plane and height move with a wall, though not the region. Or of spheres that then rise as high as they ever are.
struct Outlet {
  static const int SAMPLES = 400;       // of the path; the crossing is interpolated between two of them
  Vec low, high;
  double least, longest;
  Sway wall;
  bool holds(const Vec &x, const Vec &v, const Vec &gravity, double now) const {
    return low.x <= x.x && x.x < high.x && low.y <= x.y && x.y < high.y && low.z <= x.z && x.z < high.z &&
           (std::isinf(least) || clearance(x, v, gravity, now) >= 0);
  }
  // Height above `least` at the crossing within `longest`, or later above its highest place; minus infinity before the plane.
  double clearance(const Vec &x, const Vec &v, const Vec &g, double now) const {
    double most = -HUGE_VAL, last_beyond = 0, last_above = -HUGE_VAL;
    for (int k = 0; k <= SAMPLES; k++) {
      const double before = longest * k / SAMPLES;
      const double beyond = x.x - before * v.x + 0.5 * before * before * g.x - low.x - wall.x(now - before);
      const double height = x.z - before * v.z + 0.5 * before * before * g.z - least, above = height - wall.z(now - before);
      if (beyond < 0)
        return k == 0 ? most : std::max(most, last_above + (above - last_above) * last_beyond / (last_beyond - beyond));
      most = std::max(most, height - wall.highest());
      last_beyond = beyond;
      last_above = above;
    }
    return most;  // it crossed before `longest`, so that an earlier check has decided
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

  // Number of the outlet, from 1, in which a sphere of this position and velocity leaves at a time [s]; 0: none.
  int outlet(const Vec &x, const Vec &v, double now) const {
    for (size_t k = 0; k < outlets.size(); k++)
      if (outlets[k].holds(x, v, gravity, now)) return int(k) + 1;
    return 0;
  }
};

}  // namespace pywet
