// Spheres that are inserted during the run. Before that a sphere has no weight and moves uniformly; its liquid counts as
// put in from then on.
#pragma once
#include <cstdint>

#include "engine.h"
#include "rules.h"

namespace pywet {

struct Insertion {
  int64_t last = 0;             // step at which all are in

  bool waits(const View &at, int a, int64_t now) const { return now < last && now < at.liquid[a][ENTERS]; }

  // Takes the engine's gravity off the spheres that wait.
  void hold(const View &at, const Settings &rules, int64_t now) const {
    for (int a = 0; a < at.nlocal && now < last; a++)
      if (waits(at, a, now)) accumulate(at.f[a], (-at.mass[a]) * rules.gravity);
  }
};

}  // namespace pywet
