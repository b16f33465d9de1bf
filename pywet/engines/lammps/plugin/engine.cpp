// Interface of the plugin in engines/liggghts to LAMMPS: walls fixed or rotating, one process, no analytic wires.
// All other sources are compiled unchanged. The package has no header of LAMMPS' fixes: the hook is a function of its C
// library.
#include "engine.h"

#include <cmath>
#include <mpi.h>

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "force.h"
#include "input.h"
#include "lammps.h"
#include "library.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair.h"
#include "region.h"
#include "update.h"
#include "variable.h"

namespace pywet {

bool hook_script(const char *id, Callback callback);   // script.cpp; false if the script has no such line

void hook(LAMMPS_NS::LAMMPS *lmp, const char *fix_external, Callback callback) {
  if (hook_script(fix_external, callback)) return;
  lammps_set_fix_external_callback(lmp, fix_external, callback, lmp);  // a null pointer is not accepted, without an error message
}

MPI_Comm processes(const LAMMPS_NS::LAMMPS *lmp) { return lmp->world; }

void end(LAMMPS_NS::LAMMPS *lmp, const char *why, bool together) {
  if (together) lmp->error->all(FLERR, std::string(why));
  lmp->error->one(FLERR, std::string(why));
}

void Engine::attach(LAMMPS_NS::LAMMPS *lmp, const Walls &, bool presses) {
  lmp_ = lmp;
  LAMMPS_NS::Fix *integrate = lmp->modify->get_fix_by_id("integrate");
  if (const auto movers = lmp->modify->get_fix_by_style("^nve/sphere"); !integrate && !movers.empty())
    integrate = movers[0];              // in a user's script
  if (!integrate) throw std::runtime_error("the deck has no fix named integrate and none of style nve/sphere");
  if (presses) throw std::runtime_error("analytic wires were given; expected none in LAMMPS");
  at.free_group = integrate->groupbit;
  int real, columns;
  if (lmp->atom->find_custom("liquid", real, columns) < 0 || !real || columns != NUMBERS_TAKEN)
    throw std::runtime_error("the deck has no fix property/atom d2_liquid with " + std::to_string(NUMBERS_TAKEN) + " numbers");
  if (skin <= 0) {
    skin = said("skin");
    thickest_film = said("thickest_film");
  }
}

double Engine::said(const char *variable) const {
  const int k = lmp_->input->variable->find(variable);
  if (k < 0) throw std::runtime_error(std::string("the deck has no variable ") + variable);
  return lmp_->input->variable->compute_equal(k);
}

int Engine::local(int id) const { return lmp_->atom->map(id); }

void Engine::update_ghosts() const {}  // a single process needs none, since it owns all spheres

void Engine::find_neighbours(Communicator &ranks) {
  for (int axis : {0, 1}) ranks.neighbour[axis][0] = ranks.neighbour[axis][1] = MPI_PROC_NULL;
}

// The engine treats everything a list covers beyond touch as skin; part of that is for films and must not be used up by displacements.
void Engine::keep_skin() const {
  struct Lists : LAMMPS_NS::Neighbor {
    static double &trigger(LAMMPS_NS::Neighbor *lists) { return lists->*(&Lists::triggersq); }
  };
  Lists::trigger(lmp_->neighbor) = 0.25 * skin * skin;
}

double Engine::mesh_way() const { return 0; }

void Engine::look() {
  LAMMPS_NS::Atom *atom = lmp_->atom;
  at.x = atom->x; at.v = atom->v; at.omega = atom->omega;
  at.f = atom->f; at.torque = atom->torque;
  at.mass = atom->rmass;
  int real, columns;
  at.liquid = atom->darray[atom->find_custom("liquid", real, columns)];
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

static Turn turn_about(const Vec &axis, double angle) {
  auto back = [&](const Vec &a) {
    return std::cos(angle) * a - std::sin(angle) * cross(axis, a) + (1.0 - std::cos(angle)) * dot(axis, a) * axis;
  };
  Turn turn;
  turn.x = back(Vec(1, 0, 0)); turn.y = back(Vec(0, 1, 0)); turn.z = back(Vec(0, 0, 1));
  return turn;
}

// A region's position is updated when it is requested; the power of its contacts is not known (deck.py).
double Engine::read_meshes(Walls &walls, const Communicator &, bool, bool) const {
  struct Turning : LAMMPS_NS::Region {
    static const double *origin(const LAMMPS_NS::Region *r) { return r->*(&Turning::point); }
    static const double *axis(const LAMMPS_NS::Region *r) { return r->*(&Turning::runit); }
  };
  for (Mesh &mesh : walls.meshes) {
    LAMMPS_NS::Region *region = lmp_->domain->get_region_by_id("p_" + mesh.name + "_0");
    if (!region || !region->rotateflag) continue;
    region->prematch();
    region->set_velocity();
    const Vec origin(Turning::origin(region));
    mesh.turns = true;
    mesh.turn = turn_about(Vec(Turning::axis(region)), region->theta);
    mesh.shift = origin - mesh.turn(origin);
    mesh.spin = Vec(region->omega);
    mesh.velocity = cross(mesh.spin, mesh.shift - origin);
  }
  return 0;
}

std::vector<std::pair<int, int> > Engine::neighbours() const {
  const LAMMPS_NS::NeighList *list = lmp_->force->pair->list;
  std::vector<std::pair<int, int> > pairs;
  for (int q = 0; q < list->inum; q++) {
    const int a = list->ilist[q];
    for (int k = 0; k < list->numneigh[a]; k++) pairs.push_back({a, list->firstneigh[a][k] & NEIGHMASK});
  }
  return pairs;
}

void Engine::shorten_lists() {}  // not needed here: it only saves time
void Engine::create(const std::vector<Coming> &, const Spheres &, const Communicator &, double) {}  // no run here has checkpoints

void Engine::forget_springs() const {}  // done by its contacts

Vec Engine::press(int, double, const Vec &, double, const Vec &, double *) const { return Vec(); }

void Engine::check_box(const Spheres &spheres, const Communicator &, int64_t step) const {
  if (at.nlocal == spheres.count) return;
  int id = 1;
  while (id < spheres.count && local(id) >= 0) id++;
  throw Stop("sphere " + std::to_string(id) + " left the simulated box before step " + std::to_string(step) +
             "; expected walls or a tray that keep it, or a smaller time step");
}

}  // namespace pywet
