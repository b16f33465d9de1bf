// The events of a step: every rank books the same ones in the same order.
#pragma once
#include <string>
#include <vector>

#include "logs.h"
#include "near_pairs.h"
#include "weight.h"

namespace pywet {

class Booking {
 public:
  std::vector<Event> events;             // of this step: proposed by this rank; gathered, of all ranks in order

  Booking(const World &world, Films &films, Standing &standing, NearPairs &near, EnergyBook &energy, Weight &weight, Logs &logs)
      : world_(world), films_(films), standing_(standing), near_(near), energy_(energy), weight_(weight), logs_(logs) {}
  void gather(const std::string &problem);  // of this rank, or empty; where any rank has one all stop
  void book();

 private:
  const World &world_;
  Films &films_;
  Standing &standing_;
  NearPairs &near_;
  EnergyBook &energy_;
  Weight &weight_;
  Logs &logs_;

  void book_formations();
  void book_ruptures();
};

}  // namespace pywet
