// LAMMPS and YADE compute their contacts themselves.
#include "engine.h"

namespace pywet {

void Engine::join_corners(const Walls &) const {}

void Engine::before_walls(Callback) const {}

void Engine::before_clear() const {}

bool Engine::leaves_faces() const { return false; }

std::vector<int> Engine::places_of_triangles(size_t) const { return {}; }

MeshNow Engine::mesh_now(size_t m) const { return MeshNow{m, nullptr, nullptr, false}; }

bool Engine::meets(const MeshNow &, int, int, Meeting &) const { return false; }

bool Engine::in_one_plane(const MeshNow &, int, int) const { return false; }

}  // namespace pywet
