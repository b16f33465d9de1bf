// Films: the liquid on spheres of this rank and their ghosts, and on walls (their triangles, parts, or whole); how thick it is, how much it has grown since
// pairs were last looked for. A wall reaches through the domains of many ranks and its films with it: all know all of these.
#pragma once
#include <vector>

#include "world.h"

namespace pywet {

double film_thickness(double volume, double radius);

struct Given {
  double film = 0;
  int64_t enters = 0;                    // step
};

class Films {
 public:
  std::vector<Given> given;              // by sphere id, until `begin`
  std::vector<double> wall;              // index: number of a film, see Walls [m3]
  double initial = 0;                    // what all spheres had together at the start
  double left = 0;                       // liquid that left the box
  double retired = 0;                    // films of spheres that were taken out; known to all ranks
  // when near pairs were last looked for, by local index; what sphere's and what wall's film has grown most since
  std::vector<double> thickness_then, part_thickness_then;
  double thicker = 0, wall_thicker = 0;

  explicit Films(const SimulationState &world) : world_(world) {}
  void begin();                          // from `given`; the engine is there
  void mark();                           // growth is counted from this call on
  void enter(int a, double volume, int64_t step);  // of a sphere that has come
  void add(int id, double volume);       // nothing where the sphere is not
  double of(int id) const;               // 0 where it is not
  void add_to_wall(int triangle, double volume);

  double volume(int a) const { return world_.engine.at.liquid[a][FILM]; }
  double thickness(int a) const { return thickness_[a]; }
  double reach(int a) const { return radius(a) + thickness_[a]; }
  double part_thickness(int part) const { return part_thickness_[part]; }  // the largest of its triangles', or more
  double thickest_part() const;
  double at_wall(int triangle) const { return wall[world_.walls.film_of[triangle]]; }  // of the whole film there
  double on_triangle(int triangle) const { return at_wall(triangle) / world_.walls.film_area[world_.walls.film_of[triangle]]; }

 private:
  const SimulationState &world_;
  std::vector<double> thickness_, part_thickness_;

  void look_at(int a);                   // how thick its film is now; the run stops where that is more than lists see
  double radius(int a) const { return world_.spheres.radius(world_.engine.at.tag[a]); }
};

}  // namespace pywet
