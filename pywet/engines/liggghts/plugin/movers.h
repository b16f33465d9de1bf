// Vibration of a mesh along several axes in one pass over its triangles, in place of the engine's pass for each axis.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace pywet {

// Replaces the movers of all meshes that `fix move/mesh … viblin` alone moves; results are bitwise identical.
void move_together(LAMMPS_NS::LAMMPS *lmp);

}  // namespace pywet
