// Bridges in the order of memory, BATCH at a time: arrays over which the compiler makes vector instructions.
#pragma once
#include "laws.h"
#include "walls.h"

namespace pywet {

// What stays the same for the life of a bridge, and the two rows of the laws that do not: SEPARATION and SPEED.
struct alignas(64) Block {
  double row[ROWS][BATCH];
  double spin_j[BATCH];                 // radius of j about its centre; 0 at a wall, whose spin is in its velocity
  double deepest[BATCH];                // separation below which the overlap is too large
  double longest[BATCH];                // static rupture distance
  int a[BATCH], b[BATCH];               // local indices of the ends; a < 0: not of this rank, b < 0: at a wall, site -1 - b
};

// The same bridges as they stand in this step; vectors by component.
struct alignas(64) BridgeBatch {
  int n = 0;
  size_t first = 0;                     // index of the first bridge
  bool acts[BATCH];                     // of this rank, and not ruptured
  Closest near[BATCH];                  // at walls
  int64_t prepared[BATCH];
  double d[3][BATCH], v[3][BATCH];      // x_i - x_j, v_i - v_j
  double spin[3][BATCH];                // r_i w_i + r_j w_j
  double normal[3][BATCH];
  double pull[BATCH], viscous[BATCH], drag[BATCH], tangential[2][BATCH];
  double side[3][BATCH], force[3][BATCH], torque_i[3][BATCH], torque_j[3][BATCH];
  double square[BATCH];                 // of the force
};

// Normal, separation and speed along the normal; whether any bridge is too deep or longer than its static rupture distance.
bool find_gaps(Block &block, BridgeBatch &t);

// Tangential force, force and torques, from the values of the laws and explicit drag.
void find_forces(const Block &block, BridgeBatch &t);

}  // namespace pywet
