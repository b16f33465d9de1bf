// LAMMPS and YADE have no meshes of the engine that move.
#include "engine.h"

namespace pywet {

void Engine::move_meshes_together() const {}

}  // namespace pywet
