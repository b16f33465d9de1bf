#include "bridge.h"

#include <algorithm>

namespace pywet {

static Geometry of_sphere(const View &at, int a, double radius) {
  Geometry g;
  g.xi = Vec(at.x[a]); g.vi = Vec(at.v[a]); g.wi = Vec(at.omega[a]);
  g.radius_i = radius;
  return g;
}

Geometry between_spheres(const SimulationState &world, int a, int b, double radius_i, double radius_j) {
  const View &at = world.engine.at;
  Geometry g = of_sphere(at, a, radius_i);
  g.xj = Vec(at.x[b]); g.vj = Vec(at.v[b]); g.wj = Vec(at.omega[b]);
  g.radius_j = radius_j;
  const Vec d = at.images.nearest(g.xi - g.xj);
  if (at.images.any) g.xj = g.xi - d;  // nearest periodic image
  const double distance = norm(d);
  g.separation = distance - radius_i - radius_j;
  g.n = (1.0 / distance) * d;
  g.triangle = -1;
  return g;
}

Geometry at_wall(const SimulationState &world, int a, double radius_i, int part, const Closest &closest) {
  Geometry g = of_sphere(world.engine.at, a, radius_i);
  g.xj = closest.point; g.vj = world.walls.mesh_of(part).velocity_at(closest.on_wall()); g.wj = Vec();
  g.radius_j = INF;
  const Vec d = g.xi - g.xj;
  const double distance = norm(d);
  g.separation = distance - radius_i;
  g.n = (1.0 / distance) * d;
  g.triangle = closest.triangle;
  return g;
}

void check_overlap(const SimulationState &world, const Geometry &g, int kind, int i, int j) {
  const double smaller = std::min(g.radius_i, g.radius_j), largest = world.rules.largest_overlap;
  if (g.separation >= -largest * smaller) return;
  throw std::runtime_error("sphere " + std::to_string(i) + " overlaps " + (kind == SPHERE ? "sphere " : "wall part ") +
                           std::to_string(j) + " by " + number(-g.separation / smaller) + " of its radius at step " +
                           std::to_string(world.clock.now) + ", allowed is " + number(largest) +
                           "; likely too large a time step or too soft a contact");
}

}  // namespace pywet
