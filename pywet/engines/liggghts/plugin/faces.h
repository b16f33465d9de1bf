// Dry contacts with the triangles of walls, in place of the engine's own loop over them: the same contacts, to the last bit. A
// triangle is looked at where a sphere reaches its plane; what that makes of a contact is asked of the engine.
#pragma once
#include <vector>

#include "cells.h"
#include "wires.h"

namespace pywet {

class Faces {
 public:
  Faces(const SimulationState &world, EnergyBook &energy, Logs &logs) : world_(world), energy_(energy), logs_(logs) {}
  void arrange();                        // once, before the run
  void touch(bool fresh);                // after the engine's contacts of spheres, before wires and bridges

  // Springs of all contacts, also those of length zero; just after a resumption those of the checkpoint. A triangle is told from a
  // wire by its sign.
  std::vector<WireSpring> springs() const;
  void take_up(const std::vector<WireSpring> &springs);

 private:
  // Spheres that may touch one triangle before they are found anew.
  struct Run {
    int triangle, local;                 // of all meshes; in the engine's mesh on this rank
    size_t first, last;                  // candidates
  };
  struct Plane {
    Vec normal;                          // at rest
    double height;                       // along it
  };
  struct Surface {
    size_t mesh;
    Cells cells;
    size_t first = 0, last = 0;          // runs
    std::vector<Vec> corners_then = {};  // of its bounds, when the candidates were found
    Vec velocity = {};                   // as Mesh::velocity, in the last step that was no set-up
  };
  struct Candidate {
    int id, triangle;
    size_t next;                         // candidate of this sphere on the same surface, in turn
    bool touches;                        // there is a contact, of the step before or of this one
    int64_t kept;                        // the last time that it was there, see times_
    double spring[3];
  };

  const SimulationState &world_;
  EnergyBook &energy_;
  Logs &logs_;
  std::vector<Plane> planes_;            // of all triangles
  std::vector<Surface> surfaces_;        // in the order of meshes
  std::vector<Run> runs_;                // in order of surfaces, and in the engine's order of triangles
  std::vector<Candidate> candidates_;    // in order of runs
  std::vector<int> sphere_;              // of each candidate its local index,
  std::vector<double> reach_;            // its radius and a rounding more,
  std::vector<unsigned> near_;           // and whether it reaches the plane
  std::vector<WireSpring> saved_;        // of the step the run is resumed at, until the first candidates are found
  std::vector<size_t> parted_;
  int64_t times_ = 0;                    // that contacts were made

  std::vector<Vec> corners(const Mesh &mesh) const;
  bool moved() const;
  void find();
  void find_on(Surface &surface, const std::vector<WireSpring> &known);
  void join(size_t first);
  void touch_on(Surface &surface);
  Vec velocity(const Surface &surface, const MeshNow &now, const Meeting &met) const;
  bool take(size_t c, bool face, const MeshNow &now);
};

}  // namespace pywet
