// Contacts of spheres in batches, in place of the engine's loop over its neighbour list; results are bitwise identical.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace pywet {

// Replaces the engine's loop by the batches; returns false and changes nothing if its contact model is not supported.
// `forgets`: the tangential spring of a separated pair is deleted at once, not when the neighbour list is rebuilt.
bool batch_contacts(LAMMPS_NS::LAMMPS *lmp, bool forgets);

// Whether the engine's contact model has an attractive force; -1: its pair style is not one of spheres.
int cohesion(LAMMPS_NS::LAMMPS *lmp);

}  // namespace pywet
