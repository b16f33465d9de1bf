// Contacts of spheres in batches, in place of the engine's own loop over its list: the same contacts, to the last bit.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace pywet {

// Replaces the engine's loop by the batches; returns false and changes nothing if its contact model is not supported.
// `forgets`: the spring of a pair that has parted is taken away at once, and not when the lists are made anew.
bool batch_contacts(LAMMPS_NS::LAMMPS *lmp, bool forgets);

// Whether the engine's contact model attracts by itself; -1: its pair style is none of spheres.
int cohesion(LAMMPS_NS::LAMMPS *lmp);

}  // namespace pywet
