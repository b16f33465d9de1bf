// Spheres that the engine makes or takes away while it reads a script of the user's own: who comes has a film from then on; who goes
// takes its film along, and its bridges end.
#pragma once
#include <vector>

#include "films.h"
#include "logs.h"
#include "standing.h"

namespace pywet {

// A sphere as the engine has made it.
struct Newcomer {
  int32_t id, type;
  double radius, mass, x[3];
};

// Says of spheres that come which type of the plugin they are of and how much liquid is on them [m3]; every rank asks.
typedef void (*Enter)(int n, int64_t step, const Newcomer *all, int *types, double *films);

class Turnover {
 public:
  Enter enter = nullptr;

  Turnover(SimulationState &world, Films &films, BridgeList &standing, Logs &logs)
      : world_(world), films_(films), standing_(standing), logs_(logs) {}
  void begin();                          // those that are there already
  void look();                           // when the engine has made its lists anew, before anything acts; all ranks take part
  std::vector<double> told() const;      // what a restart file holds
  void resume(const std::vector<double> &told);
  void book();                           // at the end of a step: the liquid of those that went, after all other events

 private:
  SimulationState &world_;
  Films &films_;
  BridgeList &standing_;
  Logs &logs_;
  std::vector<RetiredSphere> kept_;      // of this rank, as they were at the end of the last step
  std::vector<RetiredSphere> gone_;      // in order, since the last booking; known to all ranks
  std::vector<Event> ended_;             // their bridges

  bool known(int a) const { return world_.engine.at.liquid[a][ENTERS] > 0; }
  int64_t present() const { return world_.spheres.count; }
  void find_gone();
  void end_bridges(const std::vector<RetiredSphere> &gone);
  void take_in(std::vector<Newcomer> all);
  RetiredSphere *went(int id);
  void keep();
};

}  // namespace pywet
