// Bridges that stand and of which this rank owns an end, in the order of their ends in memory since the engine last made its lists.
#pragma once
#include <memory>
#include <vector>

#include "bridge.h"
#include "index.h"
#include "together.h"

namespace pywet {

class BridgeList {
 public:
  std::vector<Bridge> bridges;
  std::vector<Site> sites;               // of the bridges at walls
  std::vector<Block> blocks;             // their data in the loops of a step, BATCH each
  int64_t formations = 0, ruptures = 0;  // since the start, decided by this rank

  explicit BridgeList(const SimulationState &world) : world_(world) {}
  Bridge made(int kind, int i, int j, double volume) const;
  Bridge made(const BridgeRecord &told) const;
  void place(Bridge &b) const;           // where its ends are on this rank
  void add(Bridge b);
  void remove(size_t k);                 // the last one takes its place
  void expect(std::shared_ptr<const BridgeRecord> all, int64_t n);  // those of a checkpoint, on every rank
  void exchange();                       // after spheres have changed ranks; all ranks take part
  void sort();
  std::vector<BridgeRecord> mine() const;        // those that are counted here

  int find(int kind, int i, int j) const;  // its index, or -1
  Geometry geometry(const Bridge &b);
  double share(const Bridge &b) const;   // of i, by the transfer ratio
  double rupture_limit(const Bridge &b, const Geometry &g) const;
  // What the capillary law has prepared for a bridge.
  const Line *prepared(size_t k) const { return prepared_.data() + k * world_.laws.lines; }

 private:
  const SimulationState &world_;
  std::vector<Line> prepared_;           // Laws::lines a bridge, in the order of `bridges`
  Index index_;                          // of `bridges`, by key_of
  std::shared_ptr<const BridgeRecord> told_;     // of which it is not known yet whether they have an end here
  int64_t count_told_ = 0;

  std::vector<int> in_order() const;     // those that are here
  void enter(size_t k);
  void take_up(const BridgeRecord *told, int64_t n);
  void locate(Bridge &b) const;
};

}  // namespace pywet
