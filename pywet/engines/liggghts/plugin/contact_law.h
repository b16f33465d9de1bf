// The engine's contact law of two spheres (hooke/stiffness, tangential history, rolling cdt, absolute damping), evaluated in batches.
// The operations and their order are the engine's, so that the results are bitwise identical on every processor.
#pragma once
#include <cmath>

namespace pywet {

const int BATCH = 64;

struct Material {                       // properties of a pair of types
  double normal, tangential, damping, friction, rolling;
};

// Arrays over contacts of spheres i and j, BATCH entries each.
struct alignas(64) ContactBatch {
  double apart[3][BATCH], velocity[3][BATCH];            // x_i - x_j, v_i - v_j
  double spin_i[3][BATCH], spin_j[3][BATCH], radius_i[BATCH], radius_j[BATCH];
  double normal[BATCH], tangential[BATCH], damping[BATCH], friction[BATCH], rolling[BATCH];
  double spring[3][BATCH];                               // tangential spring, input and output
  double force[3][BATCH];                                // force on i; that on j is opposite
  double torque_i[3][BATCH], torque_j[3][BATCH];
  int i[BATCH], j[BATCH];
  double *history[BATCH];
};

__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
static void press_together(ContactBatch &__restrict b, int n, double dt) {
#pragma GCC ivdep
  for (int k = 0; k < n; k++) {
    const double dx = b.apart[0][k], dy = b.apart[1][k], dz = b.apart[2][k];
    const double r = std::sqrt(dx * dx + dy * dy + dz * dz), inverse = 1.0 / r;
    const double ex = dx * inverse, ey = dy * inverse, ez = dz * inverse;
    const double ri = b.radius_i[k], rj = b.radius_j[k], overlap = ri + rj - r;
    const double ci = ri - 0.5 * overlap, cj = rj - 0.5 * overlap;
    const double vx = b.velocity[0][k], vy = b.velocity[1][k], vz = b.velocity[2][k];
    const double vn = vx * ex + vy * ey + vz * ez;
    const double wx = (ci * b.spin_i[0][k] + cj * b.spin_j[0][k]) * inverse;
    const double wy = (ci * b.spin_i[1][k] + cj * b.spin_j[1][k]) * inverse;
    const double wz = (ci * b.spin_i[2][k] + cj * b.spin_j[2][k]) * inverse;
    const double slip_x = (vx - vn * ex) - (dz * wy - dy * wz);
    const double slip_y = (vy - vn * ey) - (dx * wz - dz * wx);
    const double slip_z = (vz - vn * ez) - (dy * wx - dx * wy);
    const double fn = -b.damping[k] * vn + b.normal[k] * overlap;

    double sx = b.spring[0][k] + slip_x * dt, sy = b.spring[1][k] + slip_y * dt, sz = b.spring[2][k] + slip_z * dt;
    const double along = sx * ex + sy * ey + sz * ez;
    sx -= along * ex;
    sy -= along * ey;
    sz -= along * ez;
    const double kt = b.tangential[k], stretch = kt * std::sqrt(sx * sx + sy * sy + sz * sz);
    const double bound = b.friction[k] * std::fabs(fn);
    const bool slides = stretch > bound;
    const double ratio = slides ? bound / stretch : 1.0;
    const double tx = -(kt * sx) * ratio, ty = -(kt * sy) * ratio, tz = -(kt * sz) * ratio;
    b.spring[0][k] = slides ? -tx / kt : sx;
    b.spring[1][k] = slides ? -ty / kt : sy;
    b.spring[2][k] = slides ? -tz / kt : sz;
    const double mx = ey * tz - ez * ty, my = ez * tx - ex * tz, mz = ex * ty - ey * tx;

    const double ax = b.spin_i[0][k] - b.spin_j[0][k], ay = b.spin_i[1][k] - b.spin_j[1][k],
                 az = b.spin_i[2][k] - b.spin_j[2][k];
    const double rolls = std::sqrt(ax * ax + ay * ay + az * az);
    const double share = rolls > 0.0 ? b.rolling[k] * b.normal[k] * overlap * (ri * rj / (ri + rj)) / rolls : 0.0;
    double qx = ax * share, qy = ay * share, qz = az * share;
    const double twist = qx * ex + qy * ey + qz * ez;
    qx -= ex * twist;
    qy -= ey * twist;
    qz -= ez * twist;

    b.force[0][k] = fn * ex + tx;
    b.force[1][k] = fn * ey + ty;
    b.force[2][k] = fn * ez + tz;
    b.torque_i[0][k] = -ci * mx - qx;
    b.torque_i[1][k] = -ci * my - qy;
    b.torque_i[2][k] = -ci * mz - qz;
    b.torque_j[0][k] = -cj * mx + qx;
    b.torque_j[1][k] = -cj * my + qy;
    b.torque_j[2][k] = -cj * mz + qz;
  }
}

// For each of the given partners of sphere i at x: 1 if they touch.
__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
static void find_touching(int n, const int *__restrict partner, int mask, const double *__restrict places,
                          const double *__restrict radii, const double *x, double radius, unsigned *__restrict touches) {
  const double x0 = x[0], x1 = x[1], x2 = x[2];
  for (int k = 0; k < n; k++) {
    const int j = partner[k] & mask;
    const double dx = x0 - places[3 * j], dy = x1 - places[3 * j + 1], dz = x2 - places[3 * j + 2];
    const double sum = radius + radii[j];
    touches[k] = dx * dx + dy * dy + dz * dz < sum * sum;
  }
}

}  // namespace pywet
