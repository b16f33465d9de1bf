// Spheres that enter during the run. Until its step a sphere has no weight, so that it comes along as it began; its liquid counts as
// put in from then on.
#pragma once
#include <cstdint>
#include <vector>

#include "engine.h"
#include "rules.h"

namespace pywet {

struct Feed {
  std::vector<int64_t> enters;  // index: sphere id; empty: all are there from the start
  std::vector<double> first;    // their films at the start
  int64_t last = 0;             // step at which all are in

  bool waits(int id, int64_t now) const { return now < last && now < enters[id]; }

  // Takes the engine's gravity off the spheres that wait.
  void hold(const View &at, const Rules &rules, int64_t now) const {
    if (now >= last) return;
    for (int a = 0; a < at.nlocal; a++)
      if (now < enters[at.tag[a]]) accumulate(at.f[a], (-at.mass[a]) * rules.gravity);
  }

  // Liquid that is still to come.
  double to_come(int64_t now) const {
    long double sum = 0;
    for (size_t id = 1; now < last && id < enters.size(); id++)
      if (now < enters[id]) sum += first[id];
    return double(sum);
  }
};

}  // namespace pywet
