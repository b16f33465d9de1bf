// Forces and torques of the standing bridges, BATCH at a time, and which of them rupture.
#pragma once
#include <vector>

#include "implicit.h"
#include "together.h"

namespace pywet {

class Forces {
 public:
  Forces(const World &world, Standing &standing, EnergyBook &energy, Single &single, ImpulseSums &sums, Impulses &impulses,
         Implicit &implicit, Logs &logs)
      : world_(world), standing_(standing), energy_(energy), single_(single), sums_(sums), impulses_(impulses), implicit_(implicit),
        logs_(logs) {}

  // All that stand; those that rupture are left out and become events.
  void act(std::vector<Event> &events);
  // Those that have just formed, where bridges act every few steps. Every rank takes part.
  void act_new(const std::vector<Event> &events);

 private:
  const World &world_;
  Standing &standing_;
  EnergyBook &energy_;
  Single &single_;
  ImpulseSums &sums_;
  Impulses &impulses_;
  Implicit &implicit_;
  Logs &logs_;
  Together together_{};

  Geometry geometry_of(const Together &t, int k) const;
  void gather(Together &t);
  void rupture(Together &t, std::vector<Event> &events) const;
  void evaluate(Together &t);
  void defer(Together &t);
  void add(Together &t);
  void record(const Together &t, int k);
};

}  // namespace pywet
