// What the host is told of YADE by worker.py, mirrored in memory.py: where its numbers lie, and what it makes its frames of.
#pragma once
#include <cstdint>

namespace pywet {

// Bytes from an object's start to a number or a pointer in it; memory.py names them, and compares what lies there with what YADE says.
struct Layout {
  int64_t position, orientation, velocity, spin;        // of a State
  int64_t forces, torques;                              // of a Scene: of each thread a row of all bodies
  int64_t listed;                                       // of an InteractionContainer: pointers to Interactions
  int64_t bodies, geometry, physics;                    // of an Interaction: two numbers, and what it has once it is one
  int64_t normal, depth;                                // of a ScGeom
};

struct Given {
  int64_t spheres, walls, bodies, types, every;         // `every`: steps between frames
  const char *const *state;                             // of each sphere its State
  const int32_t *tag, *kind;                            // its number in the scene, its type; spheres are YADE's first bodies
  const char *const *wall_state;                        // of each wall that of a body which moves with it; none: it rests
  const int32_t *wall_turns, *driven;                   // of each sphere whether it is held at its velocity
  const char *scene, *interactions;
  const double *mass, *radius, *rolling;                // rolling[kind * (types + 1) + kind of the partner, 0: a wall]: torque over overlap [N]
  const double *low, *high, *gravity;
  double dt, skin, thickest_film;
  Layout at;
  const char *recorded;                                 // of each step whether motion is recorded: 1
};

}  // namespace pywet
