// Films: the liquid on spheres and wall triangles, how thick it is, how much it has grown since pairs were last looked for.
#pragma once
#include <vector>

#include "world.h"

namespace pywet {

double film_thickness(double volume, double radius);

class Films {
 public:
  std::vector<double> volume;            // index: sphere id [m3]
  std::vector<double> wall;              // index: triangle [m3]
  double initial = 0;                    // what all spheres had together at the start
  double left = 0;                       // liquid that fell on nothing
  // when near pairs were last looked for; what sphere's and what wall's film has grown most since
  std::vector<double> thickness_then, part_thickness_then;
  double thicker = 0, wall_thicker = 0;

  explicit Films(const World &world) : world_(world) {}
  void begin();                          // from `volume`; the engine is there
  void mark();                           // growth counts from here
  void set(int id, double volume);
  void add_to_wall(int triangle, double volume);

  double thickness(int id) const { return thickness_[id]; }
  double reach(int id) const { return world_.spheres.radius(id) + thickness_[id]; }
  double part_thickness(int part) const { return part_thickness_[part]; }  // the largest of its triangles', or more
  double thickest_part() const;
  double on_triangle(int triangle) const { return wall[triangle] / world_.walls.area[triangle]; }

 private:
  const World &world_;
  std::vector<double> thickness_, part_thickness_;
};

}  // namespace pywet
