// Bridges in memory order, in batches: arrays that the compiler can vectorise.
#pragma once
#include "laws.h"
#include "walls.h"

namespace pywet {

// Constant data of a bridge, and the two rows of arguments that change in each step: SEPARATION and SPEED.
struct alignas(64) Block {
  double row[ROWS][BATCH];
  double spin_j[BATCH];                 // radius of j about its centre; 0 at a wall, whose rotation is part of its velocity
  double deepest[BATCH];                // separation below which the overlap is too large
  double longest[BATCH];                // static rupture distance
  int a[BATCH], b[BATCH];               // local indices of the ends; a < 0: not owned by this rank, b < 0: at a wall, site -1 - b
};

// State of the same bridges in this step; vectors by component.
struct alignas(64) BridgeBatch : LawValues {
  int n = 0;
  size_t first = 0;                     // index of the first bridge of the batch
  bool acts[BATCH];                     // owned by this rank and not ruptured
  Closest near[BATCH];                  // closest points at walls
  int64_t prepared[BATCH];
  double d[3][BATCH], v[3][BATCH];      // x_i - x_j, v_i - v_j
  double spin[3][BATCH];                // r_i w_i + r_j w_j
  double normal[3][BATCH];
  double drag[BATCH];
  double side[3][BATCH], force[3][BATCH], torque_i[3][BATCH], torque_j[3][BATCH];
  double square[BATCH];                 // square of the force
};

// Computes normal, separation and normal speed; returns whether any bridge overlaps too deeply or exceeds its static rupture distance.
bool find_gaps(Block &block, BridgeBatch &t);

// Computes tangential force, total force and torques from the values of the laws, with explicit drag.
void find_forces(const Block &block, BridgeBatch &t);

}  // namespace pywet
