// Contacts of spheres in batches, in place of the engine's loop over its neighbour list; results are bitwise identical.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace pywet {

// Replaces the engine's loop by the batches; returns false and changes nothing if its contact model is not supported.
// The tangential spring of a separated pair is deleted at once; the engine keeps it as long as the pair is in its list.
bool batch_contacts(LAMMPS_NS::LAMMPS *lmp);

// Whether the engine's contact model has an attractive force; -1: its pair style is not one of spheres.
int cohesion(LAMMPS_NS::LAMMPS *lmp);

}  // namespace pywet
