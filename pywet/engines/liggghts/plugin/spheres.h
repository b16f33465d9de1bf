// Dry properties of the spheres of a scene: sizes, contact angles, masses by type.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace pywet {

class Spheres {
 public:
  std::vector<double> type_radius, type_angle, type_mass;  // index: type - 1
  std::vector<int> type_of;                                // index: sphere id; 0: no such sphere
  int64_t count = 0;
  std::vector<int64_t> retired;                            // sorted ids of spheres that are removed, or will be at the end of this step

  size_t ids() const { return type_of.size(); }            // largest id plus one
  bool exists(int64_t id) const { return id > 0 && id < int64_t(ids()) && type_of[id] > 0; }
  bool is_retired(int64_t id) const { return std::binary_search(retired.begin(), retired.end(), id); }
  double radius(int id) const { return type_radius[type_of[id] - 1]; }
  double angle(int id) const { return type_angle[type_of[id] - 1]; }
  double mass(int id) const { return type_mass[type_of[id] - 1]; }
};

}  // namespace pywet
