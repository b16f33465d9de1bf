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
  const View &at = world_.engine.at;
  wall.assign(world_.walls.triangles.size(), 0.0);
  long double sum = 0, entered = 0;
  for (const Given &g : given) sum += g.film;
  initial = double(sum);
  for (int a = 0; a < at.nlocal; a++) {
    if (world_.rules.scripted && at.liquid[a][ENTERS] > 0) {
      restored = true;
      continue;
    }
    const Given &g = given[at.tag[a]];
    enter(a, g.film, g.enters);
    entered += g.film;
  }
  begun = double(entered);
  std::vector<Given>().swap(given);
  part_thickness_.assign(world_.walls.parts.size(), 0.0);
  part_thickness_then = part_thickness_;
}

void Films::enter(int a, double film, int64_t step) {
  const double numbers[NUMBERS_TAKEN] = {film, film, double(step), film, film};
  std::copy(numbers, numbers + NUMBERS_TAKEN, world_.engine.at.liquid[a]);
}

void Films::mark() {
  const View &at = world_.engine.at;
  const int known = world_.ranks.alone() ? at.nlocal : at.nall;  // a single rank needs no ghosts, since it owns all spheres
  thicker = wall_thicker = 0;
  thickness_.resize(at.nall);
  for (int a = 0; a < known; a++) look_at(a);
  thickness_then = thickness_;
  std::fill(part_thickness_.begin(), part_thickness_.end(), 0.0);
  for (size_t k = 0; k < wall.size(); k++)
    if (at_wall(int(k)) > 0) {
      double &widest = part_thickness_[world_.walls.part_of[k]];
      widest = std::max(widest, on_triangle(int(k)));
    }
  part_thickness_then = part_thickness_;
}

double Films::of(int id) const {
  const int a = world_.engine.local(id);
  return a < 0 ? 0.0 : volume(a);
}

void Films::add(int id, double more) {
  const int a = world_.engine.local(id);
  if (a < 0) return;
  const double now = volume(a) + more;
  if (now < -1e-12 * initial || !std::isfinite(now))
    throw std::runtime_error("the film on sphere " + std::to_string(id) + " would be " + number(1e9 * now) + " mm3 after step " +
               std::to_string(world_.clock.now) + ", expected zero or more; the formation law draws more than it says");
  world_.engine.at.liquid[a][FILM] = now;
  if (world_.spheres.is_retired(id)) return;  // its film is not evaluated any more
  look_at(a);
  thicker = std::max(thicker, thickness_[a] - thickness_then[a]);
}

void Films::look_at(int a) {
  const double r = radius(a), allowed = world_.engine.thickest_film * r;
  thickness_[a] = film_thickness(std::max(volume(a), 0.0), r);
  if (thickness_[a] > allowed && volume(a) > 0)
    throw std::runtime_error("the film on sphere " + std::to_string(world_.engine.at.tag[a]) + " has grown to " +
                             number(1e3 * thickness_[a]) +
               " mm, the neighbour list sees films up to " + number(1e3 * allowed) +
               " mm; raise FILM_GROWTH in pywet/engines/liggghts/deck.py, or the skin in a script of your own");
}

void Films::add_to_wall(int triangle, double more) {
  wall[world_.walls.film_of[triangle]] += more;
  for (int part : world_.walls.sharing(world_.walls.part_of[triangle])) {
    part_thickness_[part] = std::max(part_thickness_[part], on_triangle(triangle));
    wall_thicker = std::max(wall_thicker, part_thickness_[part] - part_thickness_then[part]);
  }
}

double Films::thickest_part() const {
  return part_thickness_.empty() ? 0 : *std::max_element(part_thickness_.begin(), part_thickness_.end());
}

}  // namespace pywet
