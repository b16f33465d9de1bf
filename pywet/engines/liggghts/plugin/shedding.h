// Shedding: drops that detach from the films of spheres.
#pragma once
#include <vector>

#include "films.h"
#include "logs.h"
#include "weight.h"

namespace pywet {

class Shedding {
 public:
  Shedding(const SimulationState &world, Films &films, Weight &weight, Logs &logs)
      : world_(world), films_(films), weight_(weight), logs_(logs) {}
  void shed();

  template <class Each>
  void keep(Each each) {                 // fields stored in a checkpoint
    each(felt_);
    each(speed_then_);
  }

 private:
  const SimulationState &world_;
  Films &films_;
  Weight &weight_;
  Logs &logs_;
  std::vector<double> felt_, speed_then_;  // three values for each id: specific force, and velocity at the last evaluation

  std::vector<double> everywhere() const;
  void feel(const std::vector<double> &now);
  void record(const std::vector<double> &now) const;
  void land(const std::vector<double> &now, const std::vector<double> &coming, Drop &d) const;
  void fall(std::vector<double> &now, Drop &d);
};

}  // namespace pywet
