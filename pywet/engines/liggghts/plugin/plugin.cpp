// The plugin's C interface: called through ctypes by pywet.engines.liggghts.worker before and after the deck is read.
#include <cstring>
#include <exception>
#include <memory>

#include "script.h"
#include "step.h"

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

std::unique_ptr<pywet::Plugin> state;
LAMMPS_NS::LAMMPS *engine = nullptr;
std::string message;

// Flushes the logs and prints the reason; MPI_Abort discards what the engine has buffered.
void stop(const char *why) {
  try {
    state->logs.flush();
  } catch (const std::exception &) {
  }
  state->logs.stop(why);
  fprintf(stderr, "ERROR: %s\n", why);
  fflush(nullptr);
}

// The fix adds `extra` to the forces after the call and never sets it: it is set to zero here; bridges act on f and torque.
void callback(void *, int64_t step, int n, int *, double **, double **extra) {
  if (n > 0) std::memset(extra[0], 0, sizeof(double) * 3 * n);
  try {
    state->step(step);
  } catch (const pywet::Stop &e) {  // thrown on all ranks, with the same message
    stop(e.what());
    pywet::end(engine, e.what(), true);
  } catch (const std::exception &e) {
    stop(e.what());
    pywet::end(engine, e.what(), false);
  }
}

template <class Work>
const char *guarded(Work work) {
  try {
    work();
    return nullptr;
  } catch (const std::exception &e) {
    message = e.what();
    return message.c_str();
  }
}

template <class Function>
void assign(Function &slot, void *address) {
  slot = reinterpret_cast<Function>(address);
}

// Before the first contacts: from then on the engine's triangles carry their flags.
void join(void *, int64_t, int n, int *, double **, double **extra) {
  if (n > 0) std::memset(extra[0], 0, sizeof(double) * 3 * n);
  if (!state->joined) state->world.engine.join_corners(state->world.walls);
  state->joined = true;
}

}  // namespace

// Values that a user's script can print for each sphere and in total, see script.cpp.
namespace pywet {

void copy_sphere_values(double **rows, int n) {
  for (int a = 0; a < n; a++) rows[a][0] = state->films.volume(a), rows[a][1] = 0;
  for (const Bridge &b : state->standing.bridges)
    for (int a : {b.a, b.kind == SPHERE ? b.b : -1})
      if (a >= 0 && a < n) rows[a][1] += 1;
}

std::vector<double> state_of_script() { return state->turnover.serialized(); }

void copy_sums(double (&sums)[ALL]) {
  const SimulationState &world = state->world;
  const Ledger l = state->logs.counted();
  double stored[1] = {};
  for (size_t k = 0; k < state->standing.bridges.size(); k++)
    if (const Bridge &b = state->standing.bridges[k]; b.mine) stored[0] += state->energy.stored(k, state->standing.geometry(b).separation);
  world.ranks.add_up(stored);
  const double values[ALL] = {l.initial, l.films, l.bridges, l.walls, l.retired, double(l.bridge_count), double(l.formations),
                              double(l.ruptures), stored[0]};
  std::copy(values, values + ALL, sums);
  MPI_Bcast(sums, ALL, MPI_DOUBLE, 0, world.ranks.all);
}

}  // namespace pywet

EXPORT const char *pywet_version() { return PYWET_ENGINE_VERSION; }

EXPORT void pywet_create(double surface_tension, double viscosity) {
  state.reset(new pywet::Plugin());
  state->world.laws.surface_tension = surface_tension;
  state->world.laws.viscosity = viscosity;
}

EXPORT void pywet_add_type(double radius, double contact_angle) {
  state->world.spheres.type_radius.push_back(radius);
  state->world.spheres.type_angle.push_back(contact_angle);
}

EXPORT void pywet_add_force_laws(void *address, int first, int count) {
  pywet::ForceLaws laws = {nullptr, first, count};
  assign(laws.loop, address);
  state->world.laws.forces.push_back(laws);
}

EXPORT const char *pywet_set_law(const char *slot, void *address) {
  return guarded([&] {
    pywet::Laws &l = state->world.laws;
    const std::string s = slot;
    if (s == "rupture") assign(l.rupture, address);
    else if (s == "dynamic_rupture") assign(l.dynamic_rupture, address);
    else if (s == "from_sphere") assign(l.from_sphere, address);
    else if (s == "from_sphere_at_wire") assign(l.from_sphere_at_wire, address);
    else if (s == "from_wall") assign(l.from_wall, address);
    else if (s == "from_wire") assign(l.from_wire, address);
    else if (s == "shed_drop") assign(l.shed_drop, address);
    else if (s == "shed_time") assign(l.shed_time, address);
    else throw std::runtime_error("the plugin has no law slot named " + s);
  });
}

// Size of the precomputed data of the capillary law for a bridge: `lines` lines of 64 bytes.
EXPORT void pywet_set_preparation(void *address, int lines) {
  assign(state->world.laws.prepare, address);
  state->world.laws.lines = lines;
}

EXPORT void pywet_set_transfer(int kind, int type_i, int other, const double *nodes, const double *values, int n) {
  state->world.transfer.set(kind, type_i, other, nodes, values, n);
}

// nodes: 9 numbers for each triangle, in file order; part: index within this mesh; half_width: infinity for a large wall;
// count: number of triangles that the engine holds, the first ones. Without parts the mesh has no films.
EXPORT const char *pywet_add_mesh(const char *name, int n, const double *nodes, const int *part, int parts,
                                  const double *half_width, const int *group, double contact_angle, int count) {
  return guarded([&] {
    pywet::Walls &w = state->world.walls;
    const int first_part = int(w.parts.size());
    pywet::Mesh mesh;
    mesh.name = name;
    mesh.first = int(w.triangles.size());
    mesh.count = count;
    mesh.triangles = n;
    for (int p = 0; p < parts; p++) {
      pywet::Part q;
      q.mesh = int(w.meshes.size());
      q.half_width = half_width[p];
      q.group = group[p];
      q.contact_angle = contact_angle;
      w.parts.push_back(q);
    }
    for (int k = 0; k < n; k++) {
      const double *p = nodes + 9 * k;
      if (parts > 0) w.parts.at(first_part + part[k]).triangles.push_back(int(w.triangles.size()));
      w.triangles.push_back(pywet::Triangle{pywet::Vec(p), pywet::Vec(p + 3), pywet::Vec(p + 6)});
      for (int corner = 0; corner < 3; corner++) mesh.extent.widen(pywet::Vec(p + 3 * corner));
    }
    w.meshes.push_back(mesh);
  });
}

// Area over which liquid spreads on walls: 0 a triangle, 1 a part, 2 a mesh.
EXPORT void pywet_set_wall_film(int of) { state->world.walls.film = pywet::WallFilm(of); }

// Adds an analytic wire of the last mesh; wall, triangle: identify it in logs; section: n corners, see analytic_wire.h.
EXPORT void pywet_add_analytic_wire(int wall, int triangle, int axis, double low, double high, int n, const double *section) {
  state->wires.parts.push_back(pywet::AnalyticWire(int(state->world.walls.meshes.size()) - 1, wall, triangle, axis, low, high, n, section));
}

EXPORT void pywet_set_spheres(int n, const int *id, const int *type, const double *film) {
  int largest = 0;
  for (int k = 0; k < n; k++) largest = std::max(largest, id[k]);
  state->world.spheres.type_of.assign(largest + 1, 0);
  state->world.spheres.count = n;
  state->films.given.assign(largest + 1, pywet::Given());
  for (int k = 0; k < n; k++) {
    state->world.spheres.type_of[id[k]] = type[k];
    state->films.given[id[k]].film = film[k];
  }
}

// First step at which each sphere has weight, for the spheres of pywet_set_spheres.
EXPORT void pywet_set_feed(int n, const int *id, const int64_t *enters) {
  pywet::Insertion &feed = state->world.feed;
  for (int k = 0; k < n; k++) {
    state->films.given[id[k]].enters = enters[k];
    feed.last = std::max(feed.last, enters[k]);
  }
}

// Spheres of pywet_set_spheres that the engine does not hold yet.
EXPORT void pywet_set_coming(int n, const pywet::Coming *coming) {
  state->world.feed.coming.assign(coming, coming + n);
  for (const pywet::Coming &c : state->world.feed.coming) state->world.spheres.type_of[c.id] = 0;
  state->world.spheres.count -= n;
}

// Call at a checkpoint, before the engine's restart file is written: creates the spheres that are due.
EXPORT const char *pywet_create_due() {
  return guarded([&] { state->create(); });
}

EXPORT void pywet_set_output(int n, const int64_t *steps, int windows, const int64_t *first, const int64_t *last) {
  pywet::StepSchedule &clock = state->world.clock;
  clock.output_steps.assign(steps, steps + n);
  clock.window_first.assign(first, first + windows);
  clock.window_last.assign(last, last + windows);
}

// Outputs of a run of unknown length: first step and interval.
EXPORT void pywet_set_output_every(int64_t steps, int64_t from) {
  state->world.clock.output_every = steps;
  state->world.clock.output_from = from;
}

// The engine reads a user's script: contacts are logged for this many steps from each output on; `enter` returns types and films of
// created spheres.
EXPORT void pywet_set_script(int64_t window_steps, pywet::Enter enter) {
  state->world.rules.scripted = true;
  state->world.clock.window_steps = window_steps;
  state->turnover.enter = enter;
}

// Call after pywet_attach: continues from the `n` numbers of state_of_script.
EXPORT const char *pywet_resume_script(const double *numbers, int n) {
  return guarded([&] { state->turnover.resume(std::vector<double>(numbers, numbers + n)); });
}

// Range of the neighbour list if no deck defines it: displacement of spheres that it covers [m], films relative to the radius.
EXPORT void pywet_set_reach(double skin, double thickest_film) {
  state->world.engine.skin = skin;
  state->world.engine.thickest_film = thickest_film;
}

EXPORT void pywet_set_rules(const double *gravity, double largest_overlap, int semi_implicit, int64_t checkpoint_every,
                            int moist, int energy, int batched, int faces) {
  pywet::Settings &rules = state->world.rules;
  rules.moist = moist != 0;
  rules.batched = batched != 0;
  rules.touches_faces = faces != 0;
  rules.gravity = pywet::Vec(gravity);
  rules.largest_overlap = largest_overlap;
  rules.semi_implicit = semi_implicit != 0;
  rules.energy = moist != 0 && energy != 0;
  state->world.clock.checkpoint_every = checkpoint_every;
}

// Interval in steps between evaluations of bridges, see multiple_time_stepping.cpp; outputs and checkpoints are at such steps.
EXPORT void pywet_set_impulses(int every) { state->world.clock.bridges_every = every; }

// Spheres below this height and slower than this speed are removed at checkpoints.
EXPORT void pywet_set_retirement(double below, double slower) {
  pywet::Settings &rules = state->world.rules;
  rules.retires = true;
  rules.retire_below = below;
  rules.retire_slower = slower;
}

// Spheres whose centre is in this region are removed at checkpoints; least: see Outlet; the wall moves with amplitude, phase, rate.
EXPORT void pywet_add_outlet(const double *low, const double *high, double least, double longest, const double *amplitude,
                             const double *phase, double rate) {
  pywet::Settings &rules = state->world.rules;
  rules.retires = true;
  const pywet::Sway wall = {pywet::Vec(amplitude), pywet::Vec(phase), rate};
  rules.outlets.push_back({pywet::Vec(low), pywet::Vec(high), least, longest, wall});
}

// Density of the liquid, for its weight (then with the dry mass of a sphere of each type) and for drops.
EXPORT void pywet_set_liquid_mass(double density, int weighs, const double *type_mass, int64_t drop_every) {
  pywet::SimulationState &world = state->world;
  world.rules.density = density;
  world.rules.weighs = weighs != 0;
  world.spheres.type_mass.assign(type_mass, type_mass + world.spheres.type_radius.size());
  world.clock.drop_every = drop_every;
}

// Call after pywet_attach: continues from a state file.
EXPORT const char *pywet_resume(const char *state_file) {
  return guarded([&] { state->resume(state_file); });
}

EXPORT const char *pywet_attach(void *lmp, const char *fix_id, const char *directory) {
  return guarded([&] {
    engine = static_cast<LAMMPS_NS::LAMMPS *>(lmp);
    state->attach(engine, directory);
    pywet::hook(engine, fix_id, callback);
    state->world.engine.before_walls(join);
  });
}

// Call before the engine is cleared.
EXPORT void pywet_before_clear() { state->world.engine.before_clear(); }

// Wait for all ranks, so that the file of the first one exists for all.
EXPORT void pywet_wait() { MPI_Barrier(state->world.ranks.all); }

// Numbers of spheres with ghosts, of bridges and of pairs of a sphere and a wall part on this rank, and whether contacts are made in batches;
// on the first rank the maximum over all ranks.
EXPORT void pywet_held(int64_t *most) {
  state->world.engine.look();
  const int64_t here[4] = {state->world.engine.at.nall, int64_t(state->standing.bridges.size()), int64_t(state->near.at_walls()),
                           state->world.rules.batched};
  MPI_Reduce(here, most, 4, MPI_INT64_T, MPI_MAX, 0, state->world.ranks.all);
}

// Closes the logs and ends MPI, which the engine library leaves to its caller.
EXPORT void pywet_finish() {
  state.reset();
  int done = 0;
  MPI_Finalized(&done);
  if (!done) MPI_Finalize();
}
