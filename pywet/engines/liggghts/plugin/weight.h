// What the liquid weighs on each sphere: its film and its side of each bridge.
#pragma once
#include <vector>

#include "energy.h"
#include "films.h"
#include "records.h"

namespace pywet {

class Weight {
 public:
  Weight(const World &world, const Films &films, const Standing &standing, EnergyBook &energy)
      : world_(world), films_(films), standing_(standing), energy_(energy) {}
  void begin();                          // before the first step, or where a run goes on
  void weigh(bool fresh);                // at the start of a step's part
  void carry(const std::vector<Event> &events);
  void carry(const Drop &d);

  template <class Each>
  void keep(Each each) {                 // what a checkpoint holds
    each(load_);
    each(weighed_);
  }
  void taken_up() { heavier_ = true; }

 private:
  const World &world_;
  const Films &films_;
  const Standing &standing_;
  EnergyBook &energy_;
  std::vector<double> load_, weighed_;   // liquid a sphere carries [m3]: now, and in its present mass; index: id
  bool heavier_ = false;                 // they differ

  double wet_mass(int id) const;
};

}  // namespace pywet
