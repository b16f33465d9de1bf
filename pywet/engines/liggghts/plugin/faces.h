// Dry contacts with the triangles of walls, in place of the engine's loop over them; results are bitwise identical. A triangle is
// examined when a sphere reaches its plane; its contact is then computed by the engine.
#pragma once
#include <vector>

#include "analytic_wires.h"
#include "cells.h"

namespace pywet {

class Faces {
 public:
  Faces(const SimulationState &world, EnergyBudget &energy, Logs &logs) : world_(world), energy_(energy), logs_(logs) {}
  void arrange();                        // call once before the run
  void touch(bool fresh);                // call after the engine's sphere contacts, before wires and bridges

  // Tangential springs of all contacts, including those of length zero; directly after a resumption those of the checkpoint. A triangle
  // differs from a wire by the sign of its number.
  std::vector<WireSpring> springs() const;
  void take_up(const std::vector<WireSpring> &springs);

 private:
  // Candidates: spheres that may touch a triangle before the next search.
  struct Run {
    int triangle, local;                 // number among the triangles of all meshes; number in the engine's mesh on this rank
    size_t first, last;                  // range of candidates
  };
  struct Plane {
    Vec normal;                          // normal at rest
    double height;                       // position of the plane along the normal
  };
  struct Surface {
    size_t mesh;
    Cells cells;
    size_t first = 0, last = 0;          // range of runs
    std::vector<Vec> corners_then = {};  // corners of its bounding box at the last search
  };
  struct Candidate {
    int id, triangle;
    size_t next;                         // next candidate of the same sphere on the same surface
    bool touches;                        // whether there is a contact, from the last step or this one
    int64_t last_touch;                  // value of times_ when the contact last existed
    double spring[3];
  };

  const SimulationState &world_;
  EnergyBudget &energy_;
  Logs &logs_;
  std::vector<Plane> planes_;            // planes of all triangles
  std::vector<Surface> surfaces_;        // surfaces in the order of meshes
  std::vector<Run> runs_;                // sorted by surface, and in the engine's order of triangles
  std::vector<Candidate> candidates_;    // in the order of runs
  std::vector<int> sphere_;              // local index of the sphere of each candidate,
  std::vector<double> reach_;            // its radius plus a rounding error,
  std::vector<unsigned> near_;           // and whether it reaches the plane
  std::vector<WireSpring> saved_;        // springs of the step at which the run is resumed, until the first search
  std::vector<size_t> parted_;
  int64_t times_ = 0;                    // number of calls so far

  std::vector<Vec> corners(const Mesh &mesh) const;
  bool moved() const;
  void find();
  void find_on(Surface &surface, const std::vector<WireSpring> &known);
  void join(size_t first);
  void touch_on(Surface &surface);
  Vec velocity(const Mesh &mesh, const MeshNow &now, const Meeting &met, const Vec &point) const;
  bool take(size_t c, bool face, const MeshNow &now);
};

}  // namespace pywet
