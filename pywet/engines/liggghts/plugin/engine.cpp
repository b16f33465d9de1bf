// The engine's headers are included here and in contacts.cpp and meshes.cpp only; for LAMMPS see engines/lammps/plugin.
#include "engine.h"

#include "contacts.h"
#include "insertion.h"
#include "records.h"

#include <algorithm>
#include <cmath>

// engine headers, in the order that compiles outside the engine's source tree
#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix_external.h"
#include "fix_insert_stream.h"
#include "fix_mesh_surface.h"
#include "fix_property_atom.h"
#include "force.h"
#include "global_properties.h"
#include "input.h"
#include "lammps.h"
#include "mesh_module_stress.h"
#include "modify.h"
#include "mpi.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair.h"
#include "tri_mesh.h"
#include "update.h"
#include "variable.h"

// The engine's package lacks the lists of contact models that this header includes; they are not needed to call a model.
#define CONTACT_MODEL_CONSTANTS_H_
namespace LIGGGHTS {
namespace ContactModels {
enum { NORMAL_OFF, TANGENTIAL_OFF, COHESION_OFF, ROLLING_OFF };
}
}  // namespace LIGGGHTS
#include "fix_wall_gran.h"

namespace pywet {

void hook(LAMMPS_NS::LAMMPS *lmp, const char *fix_external, Callback callback) {
  LAMMPS_NS::FixExternal *fix = dynamic_cast<LAMMPS_NS::FixExternal *>(lmp->modify->find_fix_id(fix_external));
  if (!fix) throw std::runtime_error(std::string("the deck has no fix external named ") + fix_external);
  fix->set_callback(callback, nullptr);
}

MPI_Comm processes(const LAMMPS_NS::LAMMPS *lmp) { return lmp->world; }

void end(LAMMPS_NS::LAMMPS *lmp, const char *why, bool together) {
  if (together) lmp->error->all(FLERR, why);
  lmp->error->one(FLERR, why);
  throw std::runtime_error(why);  // not reached
}

void Engine::attach(LAMMPS_NS::LAMMPS *lmp, const Walls &walls, bool presses) {
  lmp_ = lmp;
  LAMMPS_NS::Fix *integrate = lmp->modify->find_fix_id("integrate");
  if (!integrate) integrate = lmp->modify->find_fix_style("nve/sphere", 0);  // in a user's script
  if (!integrate) throw std::runtime_error("the deck has no fix named integrate and none of style nve/sphere");
  at.free_group = integrate->groupbit;
  liquid_ = dynamic_cast<LAMMPS_NS::FixPropertyAtom *>(lmp->modify->find_fix_id("p_liquid"));
  if (!liquid_ || liquid_->get_nvalues() != NUMBERS_TAKEN)
    throw std::runtime_error("the deck has no fix property/atom named p_liquid with " + std::to_string(NUMBERS_TAKEN) + " numbers");
  if (skin <= 0) {
    skin = said("skin");
    thickest_film = said("thickest_film");
  }
  for (const Mesh &mesh : walls.meshes) {
    LAMMPS_NS::Fix *fix = lmp->modify->find_fix_id(mesh.name.c_str());
    LAMMPS_NS::FixMeshSurface *surface = dynamic_cast<LAMMPS_NS::FixMeshSurface *>(fix);
    if (!surface) throw std::runtime_error("the deck has no fix mesh/surface named " + mesh.name);
    surfaces_.push_back(surface);
  }
  if (!presses) return;
  wall_law_ = dynamic_cast<LAMMPS_NS::FixWallGran *>(lmp->modify->find_fix_id("walls"));
  if (!wall_law_ || wall_law_->dnum() > 3)
    throw std::runtime_error("the deck has no fix wall/gran named walls whose springs are those of one contact");
}

double Engine::said(const char *variable) const {
  LAMMPS_NS::Variable *variables = lmp_->input->variable;
  const int k = variables->find(const_cast<char *>(variable));
  if (k < 0) throw std::runtime_error(std::string("the deck has no variable ") + variable);
  return variables->compute_equal(k);
}

int Engine::local(int id) const { return lmp_->atom->map(id); }

void Engine::update_ghosts() const { liquid_->do_forward_comm(); }

// The engine's lists of spheres that are ghosts elsewhere are protected; a derived class can read them.
struct Sent : LAMMPS_NS::Comm {
  static void mark(LAMMPS_NS::Comm *comm, std::vector<bool> &owned) {
    for (int swap = 0; swap < comm->*(&Sent::nswap); swap++)
      for (int k = 0; k < (comm->*(&Sent::sendnum))[swap]; k++) {
        const size_t a = (comm->*(&Sent::sendlist))[swap][k];
        if (a < owned.size()) owned[a] = true;  // otherwise a ghost that is forwarded
      }
  }
};

// One end of a pair is on this rank or within a ghost cut-off, and its owner is within another cut-off. All columns have the same width.
void Engine::find_neighbours(Communicator &ranks) {
  LAMMPS_NS::Comm *comm = lmp_->comm;
  sent_.assign(at.nlocal, false);
  Sent::mark(comm, sent_);
  for (int axis : {0, 1}) {
    const int here = comm->myloc[axis], columns = comm->procgrid[axis];
    const bool ring = at.images.along[axis];
    ranks.neighbour[axis][0] = here > 0 || ring ? comm->procneigh[axis][0] : MPI_PROC_NULL;
    ranks.neighbour[axis][1] = here + 1 < columns || ring ? comm->procneigh[axis][1] : MPI_PROC_NULL;
    const int hops = std::min(columns - 1, 1 + int(2 * comm->cutghost[axis] * columns / lmp_->domain->prd[axis]));
    ranks.hops[axis][0] = hops;
    ranks.hops[axis][1] = ring ? std::min(hops, columns - 1 - hops) : hops;  // no rank is counted twice
  }
}

// The engine treats everything a list covers beyond touch as skin; part of that is for films and must not be used up by displacements.
void Engine::keep_skin() const {
  struct Lists : LAMMPS_NS::Neighbor {
    static double &trigger(LAMMPS_NS::Neighbor *lists) { return lists->*(&Lists::triggersq); }
  };
  Lists::trigger(lmp_->neighbor) = 0.25 * skin * skin;
}

double Engine::mesh_way() const { return 0.5 * lmp_->neighbor->skin; }

void Engine::look() {
  LAMMPS_NS::Atom *atom = lmp_->atom;
  at.x = atom->x; at.v = atom->v; at.omega = atom->omega;
  at.f = atom->f; at.torque = atom->torque;
  at.mass = atom->rmass;
  at.liquid = liquid_->array_atom;
  at.tag = atom->tag; at.mask = atom->mask; at.type = atom->type;
  at.radius = atom->radius;
  at.nlocal = atom->nlocal;
  at.nall = atom->nlocal + atom->nghost;
  at.dt = lmp_->update->dt;
  const LAMMPS_NS::Domain &box = *lmp_->domain;
  for (int axis = 0; axis < 3; axis++) {
    at.images.along[axis] = box.periodicity[axis] != 0;
    at.images.length[axis] = at.images.along[axis] ? box.prd[axis] : 0;
    at.images.any = at.images.any || at.images.along[axis];
  }
}

bool Engine::lists_are_new(int64_t step) const { return lmp_->neighbor->ago == 0 || lmp_->neighbor->lastcall == step; }

// ---- meshes ---------------------------------------------------------------------------------------------------------------

static const int NUMBERS = 24;  // shift, velocity, turn, spin, force, torque

// State of a mesh as far as this rank holds it; false if it holds no triangle of it.
bool Engine::read_mesh(size_t m, const Walls &walls, double *out) const {
  const Mesh &mesh = walls.meshes[m];
  LAMMPS_NS::TriMesh *tri = surfaces_[m]->triMesh();
  if (tri->sizeGlobal() != mesh.count)
    throw std::runtime_error("mesh " + mesh.name + " has " + std::to_string(tri->sizeGlobal()) +
                             " triangles in the engine, expected " + std::to_string(mesh.count));
  if (tri->sizeLocal() == 0) return false;
  const Triangle &rest = walls.triangles[mesh.first + tri->id(0)];
  double node[3][3];
  for (int k = 0; k < 3; k++) tri->node(0, k, node[k]);
  const Triangle now{Vec(node[0]), Vec(node[1]), Vec(node[2])};
  LAMMPS_NS::MultiVectorContainer<double, 3, 3> *v =
      tri->prop().getElementProperty<LAMMPS_NS::MultiVectorContainer<double, 3, 3> >("v");
  Vec shift = at.images.nearest(now.a - rest.a), velocity, spin;  // the engine wraps each triangle by the position of its centre
  if (v) velocity = Vec((*v)(0)[0]);
  Turn turn;
  if (mesh.turns) {
    turn = turn_between(rest, now);
    shift = at.images.nearest(now.a - turn(rest.a));
    if (v) spin = spin_of(now, Vec((*v)(0)[0]), Vec((*v)(0)[1]), Vec((*v)(0)[2]));
    velocity = velocity - cross(spin, at.images.any ? turn(rest.a) : now.a - shift);
  }
  const Vec parts[6] = {shift, velocity, turn.x, turn.y, turn.z, spin};
  for (int k = 0; k < 6; k++) store(parts[k], out + 3 * k);
  return true;
}

// With `all` for all meshes: this also gives the pose of a mesh whose mover has been removed.
double Engine::read_meshes(Walls &walls, const Communicator &ranks, bool all, bool again) const {
  std::vector<size_t> which;
  for (size_t m = 0; m < walls.meshes.size(); m++) {
    const bool moving = surfaces_[m]->triMesh()->isMoving();
    if (all) walls.meshes[m].turns = walls.meshes[m].turns || surfaces_[m]->triMesh()->isRotating();
    if (all || moving) which.push_back(m);
  }
  std::vector<double> mine(NUMBERS * which.size(), -INF), found;
  for (size_t k = 0; k < which.size(); k++) read_mesh(which[k], walls, &mine[NUMBERS * k]);
  if (!ranks.alone() && !which.empty()) {
    found.resize(mine.size());
    MPI_Allreduce(mine.data(), found.data(), int(mine.size()), MPI_DOUBLE, MPI_MAX, ranks.all);
  } else {
    found = mine;
  }
  double power = 0;
  for (size_t k = 0; k < which.size(); k++) {
    Mesh &mesh = walls.meshes[which[k]];
    const double *p = &found[NUMBERS * k];
    mesh.shift = Vec(p);
    mesh.turn.x = Vec(p + 6); mesh.turn.y = Vec(p + 9); mesh.turn.z = Vec(p + 12);
    if (!again || !surfaces_[which[k]]->triMesh()->isMoving()) mesh.velocity = Vec(p + 3), mesh.spin = Vec(p + 15);
    LAMMPS_NS::MeshModuleStress *stress =
        dynamic_cast<LAMMPS_NS::MeshModuleStress *>(surfaces_[which[k]]->get_module("stress"));
    if (!stress) continue;  // force and torque of this rank's spheres on the mesh, about the point at y = 0
    const Vec force(stress->f_total_ptr());
    double about[3];
    surfaces_[which[k]]->triMesh()->prop().getGlobalProperty<LAMMPS_NS::VectorContainer<double, 3> >("p_ref")->get(0, about);
    const Vec torque = Vec(stress->torque_total_ptr()) + cross(Vec(about) - mesh.shift, force);
    power -= dot(force, mesh.velocity) + (mesh.turns ? dot(torque, mesh.spin) : 0.0);
  }
  return power;
}

// ---- spheres --------------------------------------------------------------------------------------------------------------

std::vector<std::pair<int, int> > Engine::neighbours() const {
  const LAMMPS_NS::NeighList *list = lmp_->force->pair->list;
  std::vector<std::pair<int, int> > pairs;
  for (int q = 0; q < list->inum; q++) {
    const int a = list->ilist[q];
    for (int k = 0; k < list->numneigh[a]; k++) pairs.push_back({a, list->firstneigh[a][k] & NEIGHMASK});
  }
  return pairs;
}

// Pairs closer than touch plus the part of the skin that displacements may use up are the only ones that can touch before the next
// rebuild; the others are needed only for near pairs and would cost time in every step. The order of the others is unchanged, and
// consecutive lists remain consecutive in memory.
void Engine::shorten_lists() {
  LAMMPS_NS::NeighList *list = lmp_->force->pair->list;
  LAMMPS_NS::NeighList *history = list->listgranhistory;
  const double *radius = lmp_->atom->radius;
  const int *end = nullptr;                             // end of the previous list as the engine made it
  int *to = nullptr, *touch = nullptr;
  double *springs = nullptr;
  runs_.clear();
  for (int q = 0; q < list->inum; q++) {
    const int a = list->ilist[q], count = list->numneigh[a];
    const int *partner = list->firstneigh[a], *touched = history ? history->firstneigh[a] : nullptr;
    const double *sprung = history ? history->firstdouble[a] : nullptr;
    if (partner != end) {
      to = list->firstneigh[a];
      if (history) {
        touch = history->firstneigh[a];
        springs = history->firstdouble[a];
        if (!batches_forget_) runs_.push_back(Run{touch, springs, history->dnum, {}});
      }
    }
    end = partner + count;
    list->firstneigh[a] = to;
    if (history) history->firstneigh[a] = touch, history->firstdouble[a] = springs;
    for (int k = 0; k < count; k++) {
      const int b = partner[k] & NEIGHMASK;  // NOLINT(clang-analyzer-core.NullDereference): there are `count` of them
      const double radii = radius[a] + radius[b], reach = radii + skin;
      const Vec apart = Vec(at.x[a]) - Vec(at.x[b]);
      const double square = dot(apart, apart);
      if (square > reach * reach) continue;
      *to++ = partner[k];
      if (!history) continue;
      const bool parted = square >= radii * radii && touched[k];
      *touch++ = parted ? 0 : touched[k];
      const double *spring = sprung + history->dnum * k;
      springs = parted ? std::fill_n(springs, history->dnum, 0.0) : std::copy(spring, spring + history->dnum, springs);
      if (!batches_forget_) runs_.back().pairs.push_back({a, b});
    }
    list->numneigh[a] = int(to - list->firstneigh[a]);
  }
}

bool Engine::contacts_in_batches() {
  batches_forget_ = batch_contacts(lmp_);
  return batches_forget_;
}

// The engine deletes only the springs of pairs within its contact distance, each at nearly the cost of a contact.
void Engine::forget_springs() const {
  const double *radius = lmp_->atom->radius;
  for (const Run &run : runs_)
    for (size_t k = 0; k < run.pairs.size(); k++) {
      if (!run.touched[k]) continue;
      const auto &[a, b] = run.pairs[k];
      const double touch = radius[a] + radius[b];
      const Vec apart = Vec(at.x[a]) - Vec(at.x[b]);
      if (dot(apart, apart) < touch * touch) continue;
      run.touched[k] = 0;
      std::fill_n(run.springs + run.numbers * k, run.numbers, 0.0);
    }
}

// The flags of this step are those with which the engine has just computed the contacts with its other walls.
Vec Engine::press(int a, double radius, const Vec &d, double overlap, const Vec &wall_velocity, double *spring) const {
  struct Law : LAMMPS_NS::FixWallGran {
    static LIGGGHTS::Walls::IGranularWall *of(LAMMPS_NS::FixWallGran *fix) { return fix->*(&Law::impl); }
  };
  LIGGGHTS::ContactModels::SurfacesIntersectData contact;
  double velocity[3];
  store(wall_velocity, velocity);
  store(d, contact.delta);
  contact.i = a;
  contact.is_wall = true;
  contact.radi = radius;
  contact.deltan = overlap;
  contact.contact_history = spring;
  const Vec before(at.f[a]);
  Law::of(wall_law_)->compute_force(wall_law_, contact, true, velocity);
  return Vec(at.f[a]) - before;
}

// As the engine's own insertion; the state of the checkpoint holds their liquid already.
void Engine::create(const std::vector<Coming> &due, const Spheres &spheres, const Communicator &ranks, double time) {
  LAMMPS_NS::Atom *atom = lmp_->atom;
  look();
  std::vector<std::array<int, 2> > taken;
  for (const Coming &c : due)
    for (int a = 0; a < at.nlocal; a++)
      if (norm(at.images.nearest(Vec(at.x[a]) - c.at(time))) < at.radius[a] + spheres.type_radius[c.type - 1]) taken.push_back({c.id, at.tag[a]});
  taken = ranks.gathered(taken);
  if (!taken.empty())
    throw std::runtime_error("sphere " + std::to_string(taken[0][1]) + " is at " + number(time) + " s in the path of sphere " +
                             std::to_string(taken[0][0]) + ", which is to be inserted; expected a free path: move the region away from the bed, " +
                             "raise its velocity_m_per_s or lower the rate");
  // The engine saves a tangential spring with the number of its partner, which may be one of the ghosts that are overwritten here.
  LAMMPS_NS::Fix *springs = lmp_->modify->find_fix_style_strict("contacthistory", 0);
  if (springs && !due.empty()) springs->setup_pre_exchange();
  atom->nghost = 0;                                     // ghosts follow the owned spheres, where the new ones come
  atom->avec->clear_bonus();
  for (const Coming &c : due) {
    double x[3];
    store(c.at(time), x);
    if (!lmp_->domain->is_in_subdomain(x)) continue;
    atom->avec->create_atom(c.type, x);
    const int a = atom->nlocal - 1;
    const double radius = spheres.type_radius[c.type - 1];
    atom->tag[a] = c.id;
    atom->mask[a] = 1;
    std::copy(c.v, c.v + 3, atom->v[a]);
    atom->radius[a] = radius;
    atom->density[a] = c.density;
    atom->rmass[a] = 4.0 * M_PI / 3.0 * radius * radius * radius * c.density;
    for (int k = 0; k < lmp_->modify->nfix; k++)
      if (LAMMPS_NS::Fix *fix = lmp_->modify->fix[k]; fix->create_attribute) {
        fix->pre_set_arrays();
        fix->set_arrays(a);
      }
  }
  int64_t here = atom->nlocal, all = here;
  MPI_Allreduce(&here, &all, 1, MPI_INT64_T, MPI_SUM, ranks.all);
  if (all != int64_t(atom->natoms) + int64_t(due.size()))
    throw std::runtime_error(std::to_string(due.size()) + " spheres were to be created and " + std::to_string(all - int64_t(atom->natoms)) +
                             " were; expected the places of all in the simulated box");
  atom->natoms = all;
  atom->map_init();
  atom->map_set();
}

// The engine deletes a sphere outside the box when it rebuilds its lists: here its id is still known.
void Engine::check_box(const Spheres &spheres, const Communicator &ranks, int64_t step) const {
  int here = at.nlocal, all = here;
  if (!ranks.alone()) MPI_Allreduce(&here, &all, 1, MPI_INT, MPI_SUM, ranks.all);
  const int64_t expected = spheres.count - int64_t(spheres.retired.size());
  if (all == expected) return;
  std::vector<int> mine(spheres.ids(), 0), seen(spheres.ids(), 0);
  for (int a = 0; a < at.nlocal; a++) mine[at.tag[a]] = 1;
  MPI_Allreduce(mine.data(), seen.data(), int(mine.size()), MPI_INT, MPI_MAX, ranks.all);
  for (size_t id = 1; id < seen.size(); id++)
    if (spheres.exists(id) && !seen[id] && !spheres.is_retired(int64_t(id)))
      throw Stop("sphere " + std::to_string(id) + " left the simulated box before step " + std::to_string(step) + " (" +
                 std::to_string(expected - all) + " lost in all); expected walls or a tray that keep it, or a smaller time step");
}

}  // namespace pywet
