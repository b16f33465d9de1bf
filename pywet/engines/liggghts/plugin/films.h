// Films: the liquid on spheres of this rank and their ghosts, and on walls (per triangle, part or mesh); their thickness, and its growth since
// the last search for pairs. A wall extends through the domains of many ranks, so every rank stores all films of walls.
#pragma once
#include <vector>

#include "simulation_state.h"

namespace pywet {

double film_thickness(double volume, double radius);

struct Given {
  double film = 0;
  int64_t enters = 0;                    // step at which it enters
};

class Films {
 public:
  std::vector<Given> given;              // initial films by sphere id, until `begin`
  std::vector<double> wall;              // volume by the number of the film, see Walls [m3]
  double initial = 0;                    // sum over all spheres at the start
  double begun = 0;                      // sum over this rank's spheres whose films `begin` has entered
  bool restored = false;                 // whether this rank has spheres whose films were restored from a restart file
  double left = 0;                       // liquid that left the box
  double retired = 0;                    // films of removed spheres; the same on all ranks
  // thickness at the last search for pairs, by local index; largest growth of a sphere's and of a wall's film since then
  std::vector<double> thickness_then, part_thickness_then;
  double thicker = 0, wall_thicker = 0;

  explicit Films(const SimulationState &world) : world_(world) {}
  void begin();                          // takes over the initial films; the engine exists by now
  void mark();                           // growth is measured from this call
  void enter(int a, double volume, int64_t step);  // film of an inserted sphere
  void add(int id, double volume);       // does nothing if the sphere is not on this rank
  double of(int id) const;               // 0 if the sphere is not on this rank
  void add_to_wall(int triangle, double volume);

  double volume(int a) const { return world_.engine.at.liquid[a][FILM]; }
  double thickness(int a) const { return thickness_[a]; }
  double reach(int a) const { return radius(a) + thickness_[a]; }
  double part_thickness(int part) const { return part_thickness_[part]; }  // upper bound of the thickness on its triangles
  double thickest_part() const;
  double at_wall(int triangle) const { return wall[world_.walls.film_of[triangle]]; }  // volume of the whole film of the triangle
  double on_triangle(int triangle) const { return at_wall(triangle) / world_.walls.film_area[world_.walls.film_of[triangle]]; }

 private:
  const SimulationState &world_;
  std::vector<double> thickness_, part_thickness_;

  void look_at(int a);                   // updates the thickness; the run stops where it exceeds that covered by the lists
  double radius(int a) const { return world_.spheres.radius(world_.engine.at.tag[a]); }
};

}  // namespace pywet
