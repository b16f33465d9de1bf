// Drops that let go of spheres.
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
  void keep(Each each) {                 // what a checkpoint holds
    each(felt_);
    each(speed_then_);
  }

 private:
  const SimulationState &world_;
  Films &films_;
  Weight &weight_;
  Logs &logs_;
  std::vector<double> felt_, speed_then_;  // 3 numbers an id: specific force, velocity at the last look

  std::vector<double> everywhere() const;
  void feel(const std::vector<double> &now);
  void record(const std::vector<double> &now) const;
  void land(const std::vector<double> &now, Drop &d) const;
  void fall(std::vector<double> &now, Drop &d);
};

}  // namespace pywet
