// Pairs that are close enough to form a bridge before the engine rebuilds its neighbour lists, and those that form one now.
#pragma once
#include <unordered_map>
#include <vector>

#include "bridge_list.h"
#include "films.h"
#include "records.h"

namespace pywet {

class NearPairs {
 public:
  NearPairs(const SimulationState &world, const Films &films, BridgeList &standing) : world_(world), films_(films), standing_(standing) {}
  void find();                           // call after a rebuild of the neighbour lists, when the bridges are sorted
  void move_on(double moved);            // `moved`: upper bound of any sphere's displacement since the last call; infinity: computed from the speed
  void propose(std::vector<Event> &events);

  void bridged(Bridge &b);               // registers a bridge that has just formed
  void activate(const Bridge &b);            // registers a rupture
  size_t at_walls() const { return wall_pairs_.size(); }

 private:
  struct Pair {
    int i, j;                            // ids
    int a, b;
    int bridge;                          // index of the bridge that existed at the search, or -1
    double radii;                        // sum of the radii
    double gap;                          // gap between the films at the search, or less
  };
  struct WallPair {
    int i, j, a;                         // j: wall part
    Site site;
  };
  const SimulationState &world_;
  const Films &films_;
  BridgeList &standing_;
  static const int CLASSES = 64;
  std::vector<Pair> found_, pairs_;      // in the order of the list; sorted by classes of the gap at the search
  size_t first_[CLASSES + 1] = {};       // index of the first pair of each class
  int active_classes_ = 0;
  std::vector<WallPair> wall_pairs_;
  std::vector<double> rest_, wall_rest_; // displacement before which the films of a pair cannot touch; infinity: the pair has a bridge
  size_t active_ = 0;                     // number of pairs, at the start of pairs_, whose films may have touched since the search
  std::unordered_map<uint64_t, int> proposed_;  // key -> pair, proposed in this step
  double travel_ = 0, wall_travel_ = 0;  // bounds of the displacement of a sphere and of a wall since the search
  std::vector<Vec> shift_before_;        // shift of each mesh in the last step

  std::vector<size_t> of_sphere_;        // local index -> first bridge of the sphere at the search

  int bridge_of(int kind, int a, int j) const;
  int class_of(const Pair &pair) const;
  void order();
  void find_walls();
  void refuse_fast(int known) const;
  void add(int a, int b);
  double &rest_of(int kind, int pair) { return (kind == SPHERE ? rest_ : wall_rest_)[pair]; }
  double rest(const WallPair &pair, double distance) const;
  void propose_pairs(std::vector<Event> &events);
  void propose_walls(std::vector<Event> &events);
  bool given_to_neighbour(size_t c, const Closest &own);
  void form(std::vector<Event> &events, int kind, int i, int j, int pair, const Geometry &g, double drawn_i, double drawn_j);
};

}  // namespace pywet
