// Vibration of a mesh along several axes in one pass over its triangles, in place of the engine's pass for each axis; the bits are the same.
#include "engine.h"

#include <list>
#include <map>
#include <memory>
#include <vector>

// engine headers, in an order that compiles outside the engine's source tree
#include "atom.h"
#include "fix_mesh_surface.h"
#include "fix_move_mesh.h"
#include "lammps.h"
#include "mesh_mover.h"
#include "mesh_mover_linear.h"
#include "modify.h"
#include "neighbor.h"
#include "tri_mesh.h"

namespace pywet {
namespace {

using LAMMPS_NS::FixMesh;
using LAMMPS_NS::FixMoveMesh;
using LAMMPS_NS::MeshMover;
using LAMMPS_NS::TriMesh;
typedef LAMMPS_NS::MeshMoverVibLin Stock;

// An explicit instantiation may name private members.
template <class Key, typename Key::Member MEMBER>
struct Door {
  friend typename Key::Member member(Key) { return MEMBER; }
};
template <class Key, class Type>
struct Of {
  typedef Type Member;
  friend Type member(Key);
};
typedef double Triple[3], Orders[30];
struct Mover : Of<Mover, MeshMover *FixMoveMesh::*> {};
struct Fixes : Of<Fixes, std::list<FixMoveMesh *> FixMesh::*> {};
struct Axis : Of<Axis, Triple Stock::*> {};
struct Count : Of<Count, int Stock::*> {};
struct Frequency : Of<Frequency, Orders Stock::*> {};
struct Amplitude : Of<Amplitude, Orders Stock::*> {};
struct Phase : Of<Phase, Orders Stock::*> {};
template struct Door<Mover, &FixMoveMesh::move_>;
template struct Door<Fixes, &FixMesh::fixMoveMeshes_>;
template struct Door<Axis, &Stock::axis_>;
template struct Door<Count, &Stock::ord>;
template struct Door<Frequency, &Stock::omega>;
template struct Door<Amplitude, &Stock::ampl>;
template struct Door<Phase, &Stock::phi>;

// The arrays of a mesh that its movers change are protected; a derived class can reach them.
struct Arrays : TriMesh {
  static double *corners(TriMesh *mesh) { return (mesh->*(&Arrays::node_)).begin()[0][0]; }
  static double *centres(TriMesh *mesh) { return (mesh->*(&Arrays::center_)).begin()[0]; }
  static LAMMPS_NS::BoundingBox &box(TriMesh *mesh) { return mesh->*(&Arrays::bbox_); }
};

struct Part {                            // motion of a mesh by one mover in this step
  double velocity[3], way[3];
};

// Adds vectors of three components one after the other to each of n points.
void add(double *to, int n, const std::vector<Part> &parts, double (Part::*vector)[3]) {
  for (size_t from = 0; from < parts.size(); from += 3) {
    double a[3], b[3], c[3];             // -0.0 changes no number
    for (int e = 0; e < 3; e++) {
      a[e] = (parts[from].*vector)[e];
      b[e] = from + 1 < parts.size() ? (parts[from + 1].*vector)[e] : -0.0;
      c[e] = from + 2 < parts.size() ? (parts[from + 2].*vector)[e] : -0.0;
    }
    for (int k = 0; k < n; k++)
      for (int e = 0; e < 3; e++) to[3 * k + e] = ((to[3 * k + e] + a[e]) + b[e]) + c[e];
  }
}

// Movers of one mesh, in the order in which they act; the last one moves the mesh.
class Together;
struct Group {
  TriMesh *mesh;
  FixMesh *fix;
  std::vector<Together *> movers;
  std::vector<Part> parts;
  int64_t boxed = -1;                    // last rebuild of the neighbour lists after which the bounding box was computed from the corners

  void move(int64_t rebuilt);
};

class Together : public MeshMover {
 public:
  Together(LAMMPS_NS::LAMMPS *lmp, Stock *stock, FixMoveMesh *fix, const std::shared_ptr<Group> &group)
      : MeshMover(lmp, group->mesh, fix), fix_(fix), stock_(stock), group_(group) {
    isFirst_ = stock->isFirst();
    group_->movers.push_back(this);
  }
  ~Together() override {
    std::vector<Together *> &all = group_->movers;
    for (size_t k = all.size(); k-- > 0;)
      if (all[k] == this) all.erase(all.begin() + k);
  }
  void post_create() override { stock_->post_create(); }
  void pre_delete() override { stock_->pre_delete(); }
  void setup() override {
    stock_->setup();
    group_->boxed = -1;
  }
  void init() override { stock_->init(); }

  // In the order of operations of the engine's mover.
  void initial_integrate(double time, double since_setup, double dt) override {
    if (group_->mesh->is_set_store_vel()) return stock_->initial_integrate(time, since_setup, dt);
    const double *axis = (*stock_).*member(Axis()), *omega = (*stock_).*member(Frequency());
    const double *amplitude = (*stock_).*member(Amplitude()), *phase = (*stock_).*member(Phase());
    double speed = 0;
    for (int k = 0; k < (*stock_).*member(Count()); k++) speed = speed - amplitude[k] * omega[k] * sin(omega[k] * time + phase[k]);
    Part part;
    for (int e = 0; e < 3; e++) {
      part.velocity[e] = speed * axis[e];
      part.way[e] = part.velocity[e] * dt;
    }
    group_->parts.push_back(part);
    if (group_->movers.back() == this) group_->move(neighbor->lastcall);
  }
  FixMoveMesh *fix() const { return fix_; }

 private:
  FixMoveMesh *fix_;
  std::unique_ptr<Stock> stock_;
  std::shared_ptr<Group> group_;
};

// The bounding box is that of the displaced corners: rounding is monotonic.
void Group::move(int64_t rebuilt) {
  const int all = mesh->size();  // with those of other ranks
  if (all) add(Arrays::corners(mesh), 3 * all, parts, &Part::way);
  if (all) add(Arrays::centres(mesh), all, parts, &Part::way);
  auto *velocities = mesh->prop().getElementProperty<LAMMPS_NS::MultiVectorContainer<double, 3, 3> >("v");
  if (all) add(velocities->begin()[0][0], 3 * all, parts, &Part::velocity);
  if (boxed == rebuilt) {
    double bounds[6];
    LAMMPS_NS::BoundingBox &box = Arrays::box(mesh);
    box.getBoxBounds(bounds, bounds + 3);
    add(bounds, 2, parts, &Part::way);
    box = LAMMPS_NS::BoundingBox(bounds[0], bounds[3], bounds[1], bounds[4], bounds[2], bounds[5]);
  } else {
    mesh->updateGlobalBoundingBox();
    boxed = rebuilt;
  }
  const std::list<FixMoveMesh *> &fixes = fix->*member(Fixes());
  for (size_t k = 0; k < parts.size(); k++) {
    mesh->prop().move(parts[k].way);
    bool reached = false;
    for (FixMoveMesh *other : fixes) {
      reached = reached || other == movers[k]->fix();
      if (reached) other->move(parts[k].way);
    }
  }
  parts.clear();
}

}  // namespace

// Meshes that `fix move/mesh … viblin` alone moves, along more than one axis.
void Engine::move_meshes_together() const {
  std::map<FixMesh *, std::vector<FixMoveMesh *> > movers;
  for (int k = 0; k < lmp_->modify->nfix; k++)
    if (auto *fix = dynamic_cast<FixMoveMesh *>(lmp_->modify->fix[k])) movers[fix->fixMesh()].push_back(fix);
  for (const auto &[fix_mesh, fixes] : movers) {
    TriMesh *mesh = dynamic_cast<TriMesh *>(fixes[0]->mesh());
    bool alone = mesh && fixes.size() > 1;
    for (FixMoveMesh *fix : fixes) alone = alone && dynamic_cast<Stock *>(fix->*member(Mover()));
    if (!alone) continue;
    const auto group = std::make_shared<Group>(Group{mesh, fix_mesh, {}, {}});
    for (FixMoveMesh *fix : fixes) {
      MeshMover *&mover = fix->*member(Mover());
      mover = new Together(lmp_, static_cast<Stock *>(mover), fix, group);  // the fix deletes it
    }
  }
}

}  // namespace pywet
