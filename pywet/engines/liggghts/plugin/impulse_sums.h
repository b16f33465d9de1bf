// Impulses of the bridges since the last output, with which the replay checks steps between sampling windows: the sum on every
// sphere, and of each bridge by effect with its least and largest separation. They follow from the values of the laws, not from
// the engine's sums of forces. A force counts for half of the step at an output, on either side, as the engine's kick does.
#pragma once
#include <algorithm>
#include <vector>

#include "bridge.h"

namespace pywet {

class ImpulseSums {
 public:
  explicit ImpulseSums(const SimulationState &world) : world_(world) {}

  // Call at the start of a step: an output needs the sums from before the step.
  void begin() {
    before_.clear();
    const View &at = world_.engine.at;
    for (int a = 0; a < at.nlocal && world_.clock.output(); a++)
      for (int k = 0; k < 3; k++) before_.push_back(at.impulse(a)[k]);
  }

  // Number of steps for which the forces evaluated next act; zero if a set-up repeats a step.
  void act_for(double steps) { span_ = world_.clock.again ? 0.0 : steps * world_.engine.at.dt; }

  double span() const { return span_; }

  // Adds the impulse of a force on the first sphere of a bridge, and of its reaction on the second.
  void add(int a, int b, const Vec &force) const {
    const View &at = world_.engine.at;
    if (at.owned(a)) accumulate(at.impulse(a), span_ * force);
    if (at.owned(b)) accumulate(at.impulse(b), (-span_) * force);
  }

  void add(BridgeSums &sums, double separation, double capillary, double viscous) const {
    sums.capillary += span_ * capillary;
    sums.viscous += span_ * viscous;
    sums.least = std::min(sums.least, separation);
    sums.largest = std::max(sums.largest, separation);
  }

  // Impulse on a sphere up to this output; the rest of the step belongs to the next one.
  Vec taken(int a) const {
    double *now = world_.engine.at.impulse(a), until[3];
    for (int k = 0; k < 3; k++) {
      const double before = before_[3 * a + k];
      until[k] = 0.5 * (before + now[k]);
      now[k] = 0.5 * (now[k] - before);
    }
    return Vec(until);
  }

 private:
  const SimulationState &world_;
  double span_ = 0;                      // duration [s]
  std::vector<double> before_;           // three values for each sphere
};

}  // namespace pywet
