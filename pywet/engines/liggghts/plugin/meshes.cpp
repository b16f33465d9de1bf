// Access to the engine's meshes for contacts with faces, and memory that the engine does not free; with engine.cpp and contacts.cpp the
// only files that include its headers.
#include "engine.h"

#include <algorithm>

// engine headers, in the order that compiles outside the engine's source tree
#include "atom.h"
#include "domain.h"
#include "dump.h"
#include "fix_external.h"
#include "fix_insert_stream.h"
#include "fix_mesh_surface.h"
#include "global_properties.h"
#include "lammps.h"
#include "modify.h"
#include "mpi.h"
#include "output.h"
#include "sort_buffer.h"
#include "tri_mesh.h"

namespace pywet {

static const double ONE_PLACE = 2e-8;          // [m]: the engine merges nodes that are closer
static const double STRAIGHT = 1.0 - 1e-5;     // cosine above which the engine treats two edges as one line, two triangles as one plane

// Which corners of a wall that continues through a face of the box count as corners, by triangle and corner: of those at one point on both
// faces the last one, unless two of their edges are collinear.
static std::vector<std::pair<std::pair<int, int>, bool> > corners_at_faces(const Triangle *triangles, int count, const Images &images,
                                                                           const double *low, const double *high) {
  struct End {
    int triangle, corner;
    Vec at;
    bool on[2];                                // the low and the high face
  };
  std::vector<End> ends;
  for (int t = 0; t < count; t++) {
    const Vec nodes[3] = {triangles[t].a, triangles[t].b, triangles[t].c};
    for (int k = 0; k < 3; k++) {
      End end{t, k, nodes[k], {false, false}};
      double x[3];
      store(nodes[k], x);
      for (int axis = 0; axis < 3; axis++) {
        end.on[0] |= images.along[axis] && std::fabs(x[axis] - low[axis]) < ONE_PLACE;
        end.on[1] |= images.along[axis] && std::fabs(x[axis] - high[axis]) < ONE_PLACE;
      }
      if (end.on[0] || end.on[1]) ends.push_back(end);
    }
  }
  std::vector<std::pair<std::pair<int, int>, bool> > found;
  for (const End &one : ends) {
    std::vector<Vec> edges, normals;
    std::pair<int, int> last{-1, -1};
    bool on[2] = {false, false};
    for (const End &other : ends) {
      if (norm(images.nearest(other.at - one.at)) > ONE_PLACE) continue;
      const Triangle &t = triangles[other.triangle];
      const Vec nodes[3] = {t.a, t.b, t.c}, n = cross(t.b - t.a, t.c - t.a);
      normals.push_back((1.0 / norm(n)) * n);
      for (int k : {1, 2}) {
        const Vec edge = nodes[(other.corner + k) % 3] - other.at;
        edges.push_back((1.0 / norm(edge)) * edge);
      }
      last = std::max(last, {other.triangle, other.corner});
      for (int f : {0, 1}) on[f] |= other.on[f];
    }
    if (!on[0] || !on[1]) continue;            // the wall does not continue
    bool flat = true, straight = false;
    for (const Vec &n : normals) flat &= std::fabs(dot(n, normals[0])) > STRAIGHT;
    for (const Vec &a : edges)
      for (const Vec &b : edges) straight |= dot(a, b) < -STRAIGHT;
    const std::pair<int, int> self{one.triangle, one.corner};
    found.push_back({self, self == last && !flat && !straight});
  }
  return found;
}

// The engine's flags of triangles are protected; a derived class can write them.
struct Flags : LAMMPS_NS::TriMesh {
  static bool *corners(LAMMPS_NS::TriMesh *mesh, int k) {
    bool *(LAMMPS_NS::SurfaceMeshBase::*of)(int) = &Flags::cornerActive;
    return (mesh->*of)(k);
  }
};

// The engine finds the triangles around a corner by their numbers and skips periodic images of those already found: where a wall
// continues through a face it would treat the nodes there as corners, which would add forces to those of the wall's faces.
void Engine::join_corners(const Walls &walls) const {
  const LAMMPS_NS::Domain &box = *lmp_->domain;
  for (size_t m = 0; m < walls.meshes.size(); m++) {
    const Mesh &mesh = walls.meshes[m];
    if (!mesh.whole()) continue;
    LAMMPS_NS::TriMesh *triangles = surfaces_[m]->triMesh();
    std::vector<std::vector<int> > places(mesh.count);
    for (int k = 0; k < triangles->sizeLocal() + triangles->sizeGhost(); k++) places[triangles->id(k)].push_back(k);
    for (const auto &[corner, active] : corners_at_faces(&walls.triangles[mesh.first], mesh.count, at.images, box.boxlo, box.boxhi))
      for (int k : places[corner.first]) Flags::corners(triangles, k)[corner.second] = active;
  }
}

void Engine::before_walls(Callback callback) const {
  auto *fix = dynamic_cast<LAMMPS_NS::FixExternal *>(lmp_->modify->find_fix_id("p_corners"));
  if (fix) fix->set_callback(callback, nullptr);
}

// A dump does not free its sort buffer, some hundred bytes for each sphere.
void Engine::before_clear() const {
  struct Buffers : LAMMPS_NS::Dump {
    static LAMMPS_NS::SortBuffer *&of(LAMMPS_NS::Dump *dump) { return dump->*(&Buffers::sortBuffer); }
  };
  for (int k = 0; k < lmp_->output->ndump; k++) {
    delete Buffers::of(lmp_->output->dump[k]);
    Buffers::of(lmp_->output->dump[k]) = nullptr;
  }
}

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

// In the order of operations of the engine's own loop.
bool Engine::meets(const MeshNow &now, int triangle, int a, Meeting &met) const {
  double delta[3] = {};  // the engine sets all components
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
