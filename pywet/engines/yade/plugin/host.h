// Description of YADE's memory as given by worker.py (mirrored in memory.py): where its data are, and where frames are written.
#pragma once
#include <cstdint>

namespace pywet {

// Byte offsets of numbers or pointers within an object; memory.py names them and checks the values there against YADE's own.
struct Layout {
  int64_t position, orientation, velocity, spin;        // offsets in a State
  int64_t forces, torques;                              // offsets in a Scene: one row of all bodies for each thread
  int64_t listed;                                       // offset in an InteractionContainer: pointers to Interactions
  int64_t bodies, geometry, physics;                    // offsets in an Interaction: two numbers, and its geometry and physics once it is real
  int64_t normal, depth;                                // offsets in a ScGeom
};

struct Given {
  int64_t spheres, walls, bodies, types, every;         // `every`: steps between frames
  const char *const *state;                             // State of each sphere
  const int32_t *tag, *kind;                            // id in the scene and type of each sphere; spheres are YADE's first bodies
  const char *const *wall_state;                        // State of a body that moves with each wall; null: the wall is at rest
  const int32_t *wall_turns, *driven;                   // driven: for each sphere whether its velocity is prescribed
  const char *scene, *interactions;
  const double *mass, *radius, *rolling;                // rolling[kind * (types + 1) + kind of the partner, 0: a wall]: torque over overlap [N]
  const double *low, *high, *gravity;
  double dt, skin, thickest_film;
  Layout at;
  const char *recorded;                                 // for each step whether motion is recorded: 1
};

}  // namespace pywet
