// The engine's meshes as the contacts with faces ask for them; beside engine.cpp and contacts.cpp the last file with its headers.
#include "engine.h"

// engine headers, in the order in which they compile outside the engine's own tree
#include "mpi.h"
#include "fix_insert_stream.h"
#include "global_properties.h"
#include "atom.h"
#include "fix_mesh_surface.h"
#include "lammps.h"
#include "tri_mesh.h"

namespace pywet {

bool Engine::leaves_faces() const { return true; }

std::vector<int> Engine::places_of_triangles(size_t m) const {
  LAMMPS_NS::TriMesh *mesh = surfaces_[m]->triMesh();
  std::vector<int> places(mesh->sizeGlobal(), -1);
  for (int k = mesh->sizeLocal() + mesh->sizeGhost(); k-- > 0;) places[mesh->id(k)] = k;
  return places;
}

MeshNow Engine::mesh_now(size_t m) const {
  typedef LAMMPS_NS::MultiVectorContainer<double, 3, 3> Corners;
  LAMMPS_NS::TriMesh *mesh = surfaces_[m]->triMesh();
  Corners *velocities = mesh->prop().getElementProperty<Corners>("v");
  return MeshNow{m, mesh, velocities ? velocities->begin() : nullptr, mesh->isMoving()};
}

// In the order of operations of the engine's own loop over its lists.
bool Engine::meets(const MeshNow &now, int triangle, int a, Meeting &met) const {
  double delta[3] = {};  // the engine writes all of it
  int where = 0;
  const double gap = now.triangles->resolveTriSphereContactBary(a, triangle, lmp_->atom->radius[a], at.x[a], delta, met.share, where, true);
  if (!(gap <= 0)) return false;
  met.overlap = -gap;
  met.from_wall = Vec(-delta[0], -delta[1], -delta[2]);
  met.face = where == 7;
  double **corner = now.velocities ? now.velocities[triangle] : nullptr;
  met.velocity = corner ? met.between(Vec(corner[0]), Vec(corner[1]), Vec(corner[2])) : Vec();
  return true;
}

bool Engine::in_one_plane(const MeshNow &now, int one, int two) const {
  return now.triangles->map(one, 0) >= 0 && now.triangles->areCoplanarNodeNeighs(one, two);
}

}  // namespace pywet
