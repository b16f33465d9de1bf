// Vectorised loops over a batch. Values are bitwise identical for every instruction set and position in a batch:
// operations are not reordered, and multiplications are not fused with additions.
#include "bridge_batch.h"

#include <cmath>

// Selected when the library is loaded, so that machines can share a cache.
#define FOR_THIS_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))

namespace pywet {

FOR_THIS_PROCESSOR bool find_gaps(Block &__restrict block, BridgeBatch &__restrict t) {
  int odd = 0;
  for (int k = 0; k < t.n; k++) {
    const double x = t.d[0][k], y = t.d[1][k], z = t.d[2][k];
    const double distance = std::sqrt(x * x + y * y + z * z), one = 1.0 / distance;
    const double gap = distance - block.row[RADIUS_I][k] - block.spin_j[k];
    const double nx = one * x, ny = one * y, nz = one * z;
    t.normal[0][k] = nx;
    t.normal[1][k] = ny;
    t.normal[2][k] = nz;
    block.row[SEPARATION][k] = gap;
    block.row[SPEED][k] = t.v[0][k] * nx + t.v[1][k] * ny + t.v[2][k] * nz;
    odd |= !(gap >= block.deepest[k]) | !(gap < block.longest[k]);
  }
  return odd;
}

FOR_THIS_PROCESSOR void find_forces(const Block &__restrict block, BridgeBatch &__restrict t) {
  for (int k = 0; k < t.n; k++) {
    const double nx = t.normal[0][k], ny = t.normal[1][k], nz = t.normal[2][k];
    const double vx = t.v[0][k], vy = t.v[1][k], vz = t.v[2][k], along = vx * nx + vy * ny + vz * nz;
    const double wx = t.spin[0][k], wy = t.spin[1][k], wz = t.spin[2][k];
    const double slide = -t.tangential[0][k], roll = -t.tangential[1][k];
    const double sx = slide * (vx - along * nx) + roll * (ny * wz - nz * wy);
    const double sy = slide * (vy - along * ny) + roll * (nz * wx - nx * wz);
    const double sz = slide * (vz - along * nz) + roll * (nx * wy - ny * wx);
    const double straight = t.viscous[k] - t.pull[k];
    const double fx = straight * nx + sx, fy = straight * ny + sy, fz = straight * nz + sz;
    const double tx = ny * sz - nz * sy, ty = nz * sx - nx * sz, tz = nx * sy - ny * sx;
    const double arm_i = -block.row[RADIUS_I][k], arm_j = -block.spin_j[k];
    t.side[0][k] = sx;
    t.side[1][k] = sy;
    t.side[2][k] = sz;
    t.force[0][k] = fx;
    t.force[1][k] = fy;
    t.force[2][k] = fz;
    t.torque_i[0][k] = arm_i * tx;
    t.torque_i[1][k] = arm_i * ty;
    t.torque_i[2][k] = arm_i * tz;
    t.torque_j[0][k] = arm_j * tx;
    t.torque_j[1][k] = arm_j * ty;
    t.torque_j[2][k] = arm_j * tz;
    t.square[k] = fx * fx + fy * fy + fz * fz;
  }
}

}  // namespace pywet
