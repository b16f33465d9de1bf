// Pairs that are near enough to form a bridge before the engine makes its lists anew, and which of them form one now.
#pragma once
#include <unordered_map>
#include <vector>

#include "films.h"
#include "records.h"
#include "standing.h"

namespace pywet {

class NearPairs {
 public:
  NearPairs(const SimulationState &world, const Films &films, BridgeList &standing) : world_(world), films_(films), standing_(standing) {}
  void find();                           // when the engine has made its lists anew and the bridges are in order
  void move_on(double moved);            // `moved`: no sphere moved further since the last call; infinity: by its speed
  void propose(std::vector<Event> &events);

  void bridged(Bridge &b);               // has just formed
  void wake(const Bridge &b);            // has ruptured
  size_t at_walls() const { return wall_pairs_.size(); }

 private:
  struct Pair {
    int i, j;                            // ids
    int a, b;
    int bridge;                          // that stood when the pairs were found, or -1
    double radii;                        // sum of radii
    double gap;                          // between the films when the pairs were found, or less
  };
  struct WallPair {
    int i, j, a;                         // j: part
    Site site;
  };
  const SimulationState &world_;
  const Films &films_;
  BridgeList &standing_;
  static const int CLASSES = 64;
  std::vector<Pair> found_, pairs_;      // in the order of the list, and by classes of the gap when they were found
  size_t first_[CLASSES + 1] = {};       // pair of a class
  int awake_classes_ = 0;
  std::vector<WallPair> wall_pairs_;
  std::vector<double> rest_, wall_rest_; // way of each pair before which films cannot touch; infinity: a bridge
  size_t awake_ = 0;                     // the first pairs_, whose films may have met since they were found
  std::unordered_map<uint64_t, int> proposed_;  // key -> pair, of this step
  double travel_ = 0, wall_travel_ = 0;  // bounds of the way of a sphere and of a wall since the pairs were found
  std::vector<Vec> shift_before_;        // of each mesh, in the step before

  std::vector<size_t> of_sphere_;        // local index -> first of its bridges when the pairs are found

  int bridge_of(int kind, int a, int j) const;
  int class_of(const Pair &pair) const;
  void order();
  void find_walls();
  void add(int a, int b);
  double &rest_of(int kind, int pair) { return (kind == SPHERE ? rest_ : wall_rest_)[pair]; }
  double rest(const WallPair &pair, double distance) const;
  void propose_pairs(std::vector<Event> &events);
  void propose_walls(std::vector<Event> &events);
  bool given_to_neighbour(size_t c, const Closest &own);
  void form(std::vector<Event> &events, int kind, int i, int j, int pair, const Geometry &g, double drawn_i, double drawn_j);
};

}  // namespace pywet
