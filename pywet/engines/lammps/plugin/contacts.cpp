// LAMMPS and YADE compute their contacts themselves.
#include "engine.h"

namespace pywet {

bool Engine::contacts_in_batches(bool) { return false; }

}  // namespace pywet
