// Analytic wires: convex sections extruded along one axis of the mesh at rest. Closest point in closed form.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "vec.h"

namespace pywet {

// Axes: `along` is the wire's axis (0, 1, 2 for x, y, z), `across` and `up` the next two in cyclic order.
class AnalyticWire {
 public:
  int mesh, wall, triangle;             // number of the mesh in the scene and of the wire's first triangle in it, which identify the wire in logs
  int along, across, up;
  double low, high;                     // ends [m]
  double middle[2], round;              // centre and radius of the circle around the section

  // section: n corners (across, up), counter-clockwise seen against the axis
  AnalyticWire(int mesh, int wall, int triangle, int axis, double low, double high, int n, const double *section)
      : mesh(mesh), wall(wall), triangle(triangle), along(axis), across((axis + 1) % 3), up((axis + 2) % 3), low(low), high(high) {
    double least[2] = {section[0], section[1]}, most[2] = {section[0], section[1]};
    for (int k = 0; k < n; k++) {
      const double *p = section + 2 * k, *q = section + 2 * ((k + 1) % n);
      const double du = q[0] - p[0], dv = q[1] - p[1], length = std::sqrt(du * du + dv * dv);
      sides_.push_back(Side{p[0], p[1], du / length, dv / length, length});
      for (int m = 0; m < 2; m++) {
        least[m] = std::min(least[m], p[m]);
        most[m] = std::max(most[m], p[m]);
      }
    }
    round = 0;
    for (int m = 0; m < 2; m++) middle[m] = 0.5 * (least[m] + most[m]);
    for (const Side &s : sides_) round = std::max(round, std::hypot(s.u - middle[0], s.v - middle[1]));
  }

  // Whether a point may be within `reach`, by the circle around the section.
  bool near(const double *y, double reach) const {
    const double u = y[across] - middle[0], v = y[up] - middle[1], far = reach + round;
    return u * u + v * v < far * far && y[along] > low - reach && y[along] < high + reach;
  }

  // Closest point of the surface to a point outside; false where the point is inside.
  bool closest(const double *y, double *q) const {
    double best = std::numeric_limits<double>::infinity(), u = y[across], v = y[up];
    bool inside = true;
    for (const Side &s : sides_) {
      const double du = y[across] - s.u, dv = y[up] - s.v;
      if (du * s.tv - dv * s.tu <= 0) continue;  // the point is behind this side
      inside = false;
      const double way = std::min(std::max(du * s.tu + dv * s.tv, 0.0), s.length);
      const double a = s.u + way * s.tu, b = s.v + way * s.tv;
      const double square = (y[across] - a) * (y[across] - a) + (y[up] - b) * (y[up] - b);
      if (square < best) {
        best = square;
        u = a;
        v = b;
      }
    }
    q[along] = std::min(std::max(y[along], low), high);
    q[across] = u;
    q[up] = v;
    return !(inside && y[along] > low && y[along] < high);
  }

 private:
  struct Side {
    double u, v, tu, tv, length;        // first corner, direction
  };
  std::vector<Side> sides_;
};

}  // namespace pywet
