#include "films.h"

#include <algorithm>
#include <cmath>

#include "records.h"

namespace pywet {

static const double PI = 3.14159265358979323846;

double film_thickness(double volume, double radius) {
  const double q = 3.0 * volume / (4.0 * PI * radius * radius * radius);
  return radius * std::expm1(std::log1p(q) / 3.0);  // (3L/4pi + r^3)^(1/3) - r without cancellation
}

void Films::begin() {
  wall.assign(world_.walls.triangles.size(), 0.0);
  thickness_.assign(volume.size(), 0.0);
  thickness_then = thickness_;
  long double sum = 0;
  for (size_t id = 1; id < volume.size(); id++)
    if (world_.spheres.exists(id)) {
      set(int(id), volume[id]);
      sum += volume[id];
    }
  initial = double(sum);
  part_thickness_.assign(world_.walls.parts.size(), 0.0);
  part_thickness_then = part_thickness_;
}

void Films::mark() {
  thicker = wall_thicker = 0;
  thickness_then = thickness_;
  std::fill(part_thickness_.begin(), part_thickness_.end(), 0.0);
  for (size_t k = 0; k < wall.size(); k++)
    if (wall[k] > 0) {
      double &widest = part_thickness_[world_.walls.part_of[k]];
      widest = std::max(widest, on_triangle(int(k)));
    }
  part_thickness_then = part_thickness_;
}

void Films::set(int id, double now) {
  if (now < -1e-12 * initial || !std::isfinite(now))
    throw Stop("the film on sphere " + std::to_string(id) + " would be " + number(1e9 * now) + " mm3 after step " +
               std::to_string(world_.clock.now) + ", expected zero or more; the formation law draws more than it says");
  const double radius = world_.spheres.radius(id), allowed = world_.engine.thickest_film * radius;
  volume[id] = now;
  thickness_[id] = film_thickness(std::max(now, 0.0), radius);
  thicker = std::max(thicker, thickness_[id] - thickness_then[id]);
  if (thickness_[id] > allowed && now > 0)
    throw Stop("the film on sphere " + std::to_string(id) + " has grown to " + number(1e3 * thickness_[id]) +
               " mm, the neighbour list sees films up to " + number(1e3 * allowed) +
               " mm; raise FILM_GROWTH in pywet/engines/liggghts/deck.py");
}

void Films::add_to_wall(int triangle, double more) {
  const int part = world_.walls.part_of[triangle];
  wall[triangle] += more;
  part_thickness_[part] = std::max(part_thickness_[part], on_triangle(triangle));
  wall_thicker = std::max(wall_thicker, part_thickness_[part] - part_thickness_then[part]);
}

double Films::thickest_part() const {
  return part_thickness_.empty() ? 0 : *std::max_element(part_thickness_.begin(), part_thickness_.end());
}

}  // namespace pywet
