// Active bridges of which this rank owns an end, sorted by the position of their ends in memory at the last rebuild of the lists.
#pragma once
#include <memory>
#include <vector>

#include "bridge.h"
#include "bridge_batch.h"
#include "index.h"

namespace pywet {

class BridgeList {
 public:
  std::vector<Bridge> bridges;
  std::vector<BridgeSums> sums;          // in the order of `bridges`; apart, as every step changes them and little else
  std::vector<Site> sites;               // closest points of the bridges at walls
  std::vector<Block> blocks;             // their data in the loops of a step, BATCH bridges each
  int64_t formations = 0, ruptures = 0;  // number since the start of those decided by this rank

  explicit BridgeList(const SimulationState &world) : world_(world) {}
  Bridge made(int kind, int i, int j, double volume) const;
  Bridge made(const BridgeRecord &record) const;
  bool has_ends(const BridgeRecord &record) const;  // whether both ends exist
  void place(Bridge &b) const;           // finds the local indices of its ends
  void add(Bridge b, const BridgeSums &since);
  void remove(size_t k);                 // the last bridge takes its place
  void expect(std::shared_ptr<const BridgeRecord> all, int64_t n);  // bridges of a checkpoint, on every rank
  void exchange();                       // call after spheres have migrated between ranks; collective
  void sort();
  std::vector<BridgeRecord> mine() const;        // bridges that this rank counts

  int find(int kind, int i, int j) const;  // index of the bridge, or -1
  Geometry geometry(const Bridge &b);
  BridgeSums &since(const Bridge &b) { return sums[&b - bridges.data()]; }
  double share(const Bridge &b) const;   // share of i, by the transfer ratio
  // Rupture distance of a new bridge and, with the dynamic factor, of an active one; the run stops if a law gives none.
  double rupture_distance(const Bridge &b) const;
  double rupture_limit(const Bridge &b, const Geometry &g) const;
  // Precomputed data of the capillary law for a bridge.
  const CacheLine *prepared(size_t k) const { return prepared_.data() + k * world_.laws.lines; }

 private:
  const SimulationState &world_;
  std::vector<CacheLine> prepared_;      // Laws::lines cache lines for each bridge, in the order of `bridges`
  Index index_;                          // index of `bridges` by key_of
  std::shared_ptr<const BridgeRecord> recorded_;     // bridges of the checkpoint that may have an end on this rank
  int64_t count_recorded_ = 0;

  double checked(double distance, const char *law, const Bridge &b) const;
  std::vector<int> in_order() const;     // order of the bridges in memory that `sort` makes
  void index(size_t k);
  void enter(size_t k);
  BridgeRecord record(size_t k) const;
  void take_up(const BridgeRecord *record, int64_t n);
  void locate(Bridge &b) const;
};

}  // namespace pywet
