// Spheres inserted during the run. Before its insertion a sphere has no weight and moves uniformly; its liquid is added to the ledger
// at its insertion.
#pragma once
#include <cstdint>

#include "engine.h"
#include "settings.h"

namespace pywet {

struct Insertion {
  int64_t last = 0;             // step at which all spheres have been inserted

  bool waits(const View &at, int a, int64_t now) const { return now < last && now < at.liquid[a][ENTERS]; }

  // Cancels the engine's gravity on spheres that are not inserted yet.
  void hold(const View &at, const Settings &rules, int64_t now) const {
    for (int a = 0; a < at.nlocal && now < last; a++)
      if (waits(at, a, now)) accumulate(at.f[a], (-at.mass[a]) * rules.gravity);
  }
};

}  // namespace pywet
