// Spheres inserted during the run. Before its insertion a sphere has no weight and moves uniformly; its liquid is added to the ledger
// at its insertion. In a run with outlets the engine holds it only from a checkpoint shortly before.
#pragma once
#include <cstdint>
#include <vector>

#include "engine.h"
#include "settings.h"

namespace pywet {

// Sphere that the engine does not hold yet: at x + v t at the time t of the run.
struct Coming {
  int64_t created, enters;      // checkpoint at which it is created, step at which it is inserted
  int32_t id, type;
  double density, film, x[3], v[3];
  Vec at(double time) const { return Vec(x) + time * Vec(v); }
};
static_assert(sizeof(Coming) == 88, "records must match COMING of creation.py");

struct Insertion {
  int64_t last = 0;             // step at which all spheres have been inserted
  std::vector<Coming> coming;   // the same on all ranks

  std::vector<Coming> due(int64_t now) const {
    std::vector<Coming> found;
    for (const Coming &c : coming)
      if (c.created == now) found.push_back(c);
    return found;
  }

  bool waits(const View &at, int a, int64_t now) const { return now < last && now < at.liquid[a][ENTERS]; }

  // Cancels the engine's gravity on spheres that are not inserted yet.
  void hold(const View &at, const Settings &rules, int64_t now) const {
    for (int a = 0; a < at.nlocal && now < last; a++)
      if (waits(at, a, now)) accumulate(at.f[a], (-at.mass[a]) * rules.gravity);
  }
};

}  // namespace pywet
