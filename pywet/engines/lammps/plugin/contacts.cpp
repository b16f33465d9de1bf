// LAMMPS and YADE compute their contacts themselves.
#include "engine.h"

namespace pywet {

bool Engine::contacts_in_batches() { return false; }

}  // namespace pywet
