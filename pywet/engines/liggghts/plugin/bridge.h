// One bridge: its identity, the state of its ends in this step, its forces.
#pragma once
#include <cstdint>

#include "records.h"
#include "simulation_state.h"

namespace pywet {

// Sums over a bridge since the last output: impulses along the normal [N s], and the range of its separation [m].
struct BridgeSums {
  double capillary = 0, viscous = 0, least = 0, largest = 0;
};

// `a`, `b`: indices of i and j on this rank (-1: not here), valid until the engine rebuilds its neighbour list.
struct Bridge {
  int kind, i, j;                        // j: sphere id or wall part
  double volume, rupture_distance;       // static rupture distance
  int candidate = -1;                    // index into the near pairs of its kind, or -1
  int a = -1, b = -1;
  bool here = false;                     // this rank owns an end
  bool mine = false;                     // this rank owns i, and counts the bridge in sums over ranks
  double radius_i = 0, radius_j = 0, angle_i = 0, angle_j = 0;
  int site = -1;                         // index into BridgeList::sites, for a bridge at a wall
};

// Record of a bridge, for exchange between ranks and for checkpoints.
struct BridgeRecord {
  int32_t kind, i, j, pad;
  double volume, rupture_distance;
  BridgeSums sums;
};

// Key of a bridge or pair; a sphere and a wall part are the same pair whatever the kind of bridge.
inline uint64_t key_of(int kind, int i, int j) {
  return (uint64_t(kind == SPHERE ? 0 : 1) << 62) | (uint64_t(uint32_t(i)) << 31) | uint64_t(uint32_t(j));
}

// Geometry of one bridge or pair in this step; n points from j to i.
struct Geometry {
  Vec xi, vi, wi, xj, vj, wj, n;
  double separation = 0, radius_i = 0, radius_j = 0;
  int triangle = -1;
};

// Forces of one bridge: capillary attracts, viscous is the component along n on i, tangential acts on i.
struct Terms {
  double capillary = 0, viscous = 0, viscous_law = 0, factor_normal = 1, factor_tangential = 1;
  double drag = 0, slide = 0, roll = 0;  // coefficients of the viscous laws
  int sharing_i = 0, sharing_j = 0;
  double kick = 0;
  Vec tangential, push, spin_push;
};

Geometry between_spheres(const SimulationState &world, int a, int b, double radius_i, double radius_j);
Geometry at_wall(const SimulationState &world, int a, double radius_i, int part, const Closest &closest);

// The run stops if two bodies overlap too deeply.
void check_overlap(const SimulationState &world, const Geometry &g, int kind, int i, int j);

}  // namespace pywet
