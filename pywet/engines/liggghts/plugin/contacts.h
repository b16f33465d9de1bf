// Contacts of spheres in batches, in place of the engine's own loop over its list: the same contacts, to the last bit.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace pywet {

// Puts the batches in place of the engine's loop; false where its contact model is none that they know, and nothing is done.
// `forgets`: the spring of a pair that has parted is taken away at once, and not when the lists are made anew.
bool batch_contacts(LAMMPS_NS::LAMMPS *lmp, bool forgets);

// Whether the engine's contact model attracts by itself; -1: its pair style is none of spheres.
int cohesion(LAMMPS_NS::LAMMPS *lmp);

}  // namespace pywet
