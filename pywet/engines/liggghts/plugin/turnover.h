// Spheres that the engine creates or deletes while it reads a user's script: a created sphere has a film; a deleted one
// takes its film along, and its bridges end.
#pragma once
#include <vector>

#include "bridge_list.h"
#include "films.h"
#include "logs.h"

namespace pywet {

// Sphere as created by the engine.
struct Newcomer {
  int32_t id, type;
  double radius, mass, x[3];
};

// Returns the plugin's type and the liquid [m3] of created spheres; collective.
typedef void (*Enter)(int n, int64_t step, const Newcomer *all, int *types, double *films);

class Turnover {
 public:
  Enter enter = nullptr;

  Turnover(SimulationState &world, Films &films, BridgeList &standing, Logs &logs)
      : world_(world), films_(films), standing_(standing), logs_(logs) {}
  void begin();                          // registers the spheres that exist already
  void look();                           // call after a rebuild of the lists, before anything else; collective
  std::vector<double> serialized() const;      // values stored in a restart file
  void resume(const std::vector<double> &values);  // call after begin(), without values if no restart file has any; collective
  void apply_events();                           // call at the end of a step, after all other events: removes the liquid of deleted spheres from the ledger

 private:
  SimulationState &world_;
  Films &films_;
  BridgeList &standing_;
  Logs &logs_;
  std::vector<RetiredSphere> kept_;      // spheres of this rank at the end of the last step, or at the last rebuild since
  std::vector<RetiredSphere> gone_;      // deleted spheres in the order of their deletion, since the last call of apply_events(); the same on all ranks
  std::vector<Event> ended_;             // events that end their bridges

  bool known(int a) const { return world_.engine.at.liquid[a][ENTERS] > 0; }
  int64_t present() const { return world_.spheres.count; }
  void refuse_incomplete(const BridgeRecord *bridges, size_t n) const;
  void find_gone();
  void end_bridges(std::vector<RetiredSphere> gone);
  void take_in(std::vector<Newcomer> all);
  RetiredSphere *went(int id);
  void keep();
};

}  // namespace pywet
