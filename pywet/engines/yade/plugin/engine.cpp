// Interface of the plugin in engines/liggghts to YADE: one process; walls at rest, vibrating, sliding or rotating.
// All other sources are compiled unchanged. Debian's package has no headers of YADE: positions and forces are read and written
// at the addresses found by memory.py, and containers grow by a function of YADE's library.
#include "engine.h"

#include <mpi.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "host.h"

namespace Eigen {
template <class Number, int, int, int, int, int>
class Matrix;
}
namespace yade {
class ForceContainer {
 public:
  void addForce(int body, const Eigen::Matrix<double, 3, 1, 0, 3, 1> &force);  // allocates the entry, and marks the sum of forces as outdated
};
}  // namespace yade

namespace LAMMPS_NS {

template <class T>
T get(const char *object, int64_t bytes) {
  T value;
  // cppcheck-suppress pointerSize; members are read by their place in memory, among them pointers, whose size is meant
  std::memcpy(&value, object + bytes, sizeof(T));
  return value;
}

// cppcheck-suppress invalidPointerCast; likewise
inline double *numbers(const char *object, int64_t bytes) { return reinterpret_cast<double *>(const_cast<char *>(object) + bytes); }

// The part of the engine's interface that the plugin uses.
class LAMMPS {
 public:
  pywet::Given given;
  pywet::Callback callback = nullptr;
  std::vector<double *> x, v, omega, f, torque, liquid;
  std::vector<double> mass, taken, places, speeds, spins;  // contiguous vectors, as the plugin reads them
  std::vector<int> tag, mask, local_of_body, local_of_tag;
  std::vector<pywet::Vec> wall_start;                   // position of the body that moves with a wall, and its axes
  std::vector<pywet::Turn> wall_turned;
  bool sorted = true;                                   // whether YADE has searched for neighbours in this step
  FILE *trajectory = nullptr, *states = nullptr;

  explicit LAMMPS(const pywet::Given &g) : given(g) {
    const size_t n = g.spheres;
    for (auto *column : {&x, &v, &omega, &f, &torque, &liquid}) column->resize(n);
    mass.assign(g.mass, g.mass + n);
    tag.assign(g.tag, g.tag + n);
    taken.assign(n * pywet::NUMBERS_TAKEN, 0.0);
    for (auto *copy : {&places, &speeds, &spins}) copy->resize(3 * n);
    local_of_body.assign(g.bodies, -1);
    for (size_t a = 0; a < n; a++) {
      mask.push_back(g.driven[a] ? 0 : 1);
      local_of_body[a] = int(a);
      if (tag[a] >= int(local_of_tag.size())) local_of_tag.resize(tag[a] + 1, -1);
      local_of_tag[tag[a]] = int(a);
      x[a] = &places[3 * a];
      v[a] = &speeds[3 * a];
      omega[a] = &spins[3 * a];
      liquid[a] = &taken[a * pywet::NUMBERS_TAKEN];
    }
    for (int64_t m = 0; m < g.walls; m++) {
      wall_start.push_back(g.wall_state[m] ? pywet::Vec(numbers(g.wall_state[m], g.at.position)) : pywet::Vec());
      wall_turned.push_back(g.wall_state[m] ? turned(g.wall_state[m]) : pywet::Turn());
    }
  }

  // Rotation from a quaternion x, y, z, w.
  pywet::Turn turned(const char *state) const {
    const double *q = numbers(state, given.at.orientation), x = q[0], y = q[1], z = q[2], w = q[3];
    pywet::Turn turn;
    turn.x = pywet::Vec(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w));
    turn.y = pywet::Vec(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w));
    turn.z = pywet::Vec(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y));
    return turn;
  }

  // Positions and velocities of this step, and the forces and torques of YADE's only thread, in which the spheres come first.
  void look() {
    for (size_t a = 0; a < x.size(); a++) {
      std::memcpy(x[a], given.state[a] + given.at.position, 3 * sizeof(double));
      std::memcpy(v[a], given.state[a] + given.at.velocity, 3 * sizeof(double));
      std::memcpy(omega[a], given.state[a] + given.at.spin, 3 * sizeof(double));
    }
    yade::ForceContainer *forces = reinterpret_cast<yade::ForceContainer *>(const_cast<char *>(given.scene) + given.at.forces);
    const double nothing[3] = {0, 0, 0};
    forces->addForce(int(given.bodies) - 1, reinterpret_cast<const Eigen::Matrix<double, 3, 1, 0, 3, 1> &>(nothing));
    double *pushed = get<double *>(get<const char *>(given.scene, given.at.forces), 0);
    double *twisted = get<double *>(get<const char *>(given.scene, given.at.torques), 0);
    for (size_t a = 0; a < f.size(); a++) {
      f[a] = pushed + 3 * a;
      torque[a] = twisted + 3 * a;
    }
  }

  // Calls work(interaction, local indices, -1: a wall) for every pair of bodies whose boxes overlap.
  template <class Work>
  void each(Work work) const {
    const char *begin = get<const char *>(given.interactions, given.at.listed);
    const char *end = get<const char *>(given.interactions, given.at.listed + int64_t(sizeof(void *)));
    for (; begin < end; begin += 2 * sizeof(void *)) {  // shared pointers
      const char *pair = get<const char *>(begin, 0);
      work(pair, local_of_body[get<int32_t>(pair, given.at.bodies)], local_of_body[get<int32_t>(pair, given.at.bodies + 4)]);
    }
  }

  // Weight is an explicit force, so that energies and semi-implicit drag include it: YADE's integrator, which would add it afterwards, has none.
  void weigh() {
    for (size_t a = 0; a < f.size(); a++) pywet::accumulate(f[a], mass[a] * pywet::Vec(given.gravity));
  }

  // Rolling resistance as a constant torque against the rotation, in the contacts that YADE has just computed.
  void roll() {
    each([&](const char *pair, int a, int b) {
      const char *geometry = get<const char *>(pair, given.at.geometry), *physics = get<const char *>(pair, given.at.physics);
      if (!geometry || !physics || (a < 0 && b < 0)) return;
      const double overlap = get<double>(geometry, given.at.depth);
      if (!(overlap > 0)) return;
      if (a < 0) std::swap(a, b);
      const pywet::Vec n(numbers(geometry, given.at.normal));
      const pywet::Vec rolls = b < 0 ? pywet::Vec(omega[a]) : pywet::Vec(omega[a]) - pywet::Vec(omega[b]);
      const double speed = pywet::norm(rolls);
      if (!(speed > 0)) return;
      const double torque_over_overlap = given.rolling[given.kind[a] * (given.types + 1) + (b < 0 ? 0 : given.kind[b])];
      pywet::Vec against = (torque_over_overlap * overlap / speed) * rolls;
      against = against - pywet::dot(against, n) * n;
      pywet::accumulate(torque[a], -1.0 * against);
      if (b >= 0) pywet::accumulate(torque[b], against);
    });
  }

  // Velocities at the end of the step, half a step after YADE's; `half`: share of a kick that is applied.
  pywet::Vec kicked(int a, double half) const {
    if (!mask[a]) return pywet::Vec(v[a]);
    return pywet::Vec(v[a]) + (half * given.dt / mass[a]) * pywet::Vec(f[a]);
  }
  pywet::Vec spun(int a, double half) const {
    const double r = given.radius[a];
    return mask[a] ? pywet::Vec(omega[a]) + (half * given.dt / (0.4 * mass[a] * r * r)) * pywet::Vec(torque[a]) : pywet::Vec(omega[a]);
  }

  // In the format of the engine's text dumps; `forces`: force and torque in place of the type.
  void frame(FILE *file, int64_t step, bool forces) const {
    fprintf(file, "ITEM: TIMESTEP\n%lld\nITEM: NUMBER OF ATOMS\n%zu\nITEM: BOX BOUNDS ff ff ff\n", (long long)step, x.size());
    for (int k = 0; k < 3; k++) fprintf(file, "%.17g %.17g\n", given.low[k], given.high[k]);
    fprintf(file, "ITEM: ATOMS id%s x y z vx vy vz omegax omegay omegaz%s\n", forces ? "" : " type", forces ? " fx fy fz tqx tqy tqz" : "");
    const double half = step == 0 ? 0.0 : 0.5;          // the first velocities are those of the start itself
    auto put = [file](const pywet::Vec &u) { fprintf(file, " %.17g %.17g %.17g", u.x, u.y, u.z); };
    for (size_t a = 0; a < x.size(); a++) {
      fprintf(file, "%d", tag[a]);
      if (!forces) fprintf(file, " %d", given.kind[a]);
      put(pywet::Vec(x[a]));
      put(kicked(int(a), half));
      put(spun(int(a), half));
      if (forces) put(pywet::Vec(f[a]));
      if (forces) put(pywet::Vec(torque[a]));
      fputc('\n', file);
    }
  }

  // The velocities of the leapfrog scheme belong to half a step before the start.
  void take_back() {
    for (size_t a = 0; a < x.size(); a++) {
      const pywet::Vec u = kicked(int(a), -0.5), w = spun(int(a), -0.5);
      pywet::store(u, numbers(given.state[a], given.at.velocity));
      pywet::store(w, numbers(given.state[a], given.at.spin));
    }
  }
};

}  // namespace LAMMPS_NS

namespace pywet {

void hook(LAMMPS_NS::LAMMPS *host, const char *, Callback callback) { host->callback = callback; }

MPI_Comm processes(const LAMMPS_NS::LAMMPS *) {
  int started = 0;
  MPI_Initialized(&started);
  if (!started) MPI_Init(nullptr, nullptr);
  return MPI_COMM_WORLD;
}

// The plugin has printed the reason.
void end(LAMMPS_NS::LAMMPS *, const char *, bool) { std::_Exit(1); }

void Engine::attach(LAMMPS_NS::LAMMPS *host, const Walls &walls, bool presses) {
  lmp_ = host;
  if (presses) throw std::runtime_error("analytic wires were given; expected none in YADE");
  if (int64_t(walls.meshes.size()) != host->given.walls && !walls.meshes.empty())
    throw std::runtime_error("the plugin has " + std::to_string(walls.meshes.size()) + " walls and YADE " + std::to_string(host->given.walls));
  at.free_group = 1;
  skin = host->given.skin;
  thickest_film = host->given.thickest_film;
}

int Engine::local(int id) const { return lmp_->local_of_tag[id]; }

void Engine::update_ghosts() const {}  // a single process in a box with walls has none

void Engine::find_neighbours(Communicator &ranks) {
  for (int axis : {0, 1}) ranks.neighbour[axis][0] = ranks.neighbour[axis][1] = MPI_PROC_NULL;
}

void Engine::keep_skin() const {}  // YADE's bounding boxes exceed the films by the displacement they allow

double Engine::mesh_way() const { return 0.5 * skin; }

void Engine::look() {
  lmp_->look();
  at.x = lmp_->x.data(); at.v = lmp_->v.data(); at.omega = lmp_->omega.data();
  at.f = lmp_->f.data(); at.torque = lmp_->torque.data();
  at.mass = lmp_->mass.data();
  at.liquid = lmp_->liquid.data();
  at.tag = lmp_->tag.data(); at.mask = lmp_->mask.data();
  at.nlocal = at.nall = int(lmp_->x.size());
  at.dt = lmp_->given.dt;
}

bool Engine::lists_are_new(int64_t) const { return lmp_->sorted; }

// The power of a wall's dry contacts is not known (driver.py refuses what would need it).
double Engine::read_meshes(Walls &walls, const Communicator &, bool, bool) const {
  const Given &given = lmp_->given;
  for (size_t m = 0; m < walls.meshes.size(); m++) {
    const char *state = given.wall_state[m];
    if (!state) continue;
    Mesh &mesh = walls.meshes[m];
    const Vec place(LAMMPS_NS::numbers(state, given.at.position)), velocity(LAMMPS_NS::numbers(state, given.at.velocity));
    mesh.turns = given.wall_turns[m] != 0;
    if (!mesh.turns) {
      mesh.shift = place - lmp_->wall_start[m];
      mesh.velocity = velocity;
      continue;
    }
    const Turn now = lmp_->turned(state), &start = lmp_->wall_turned[m];
    auto row = [&](const Vec &r) { return Vec(dot(r, start.x), dot(r, start.y), dot(r, start.z)); };  // now times the transpose of start
    mesh.turn.x = row(now.x); mesh.turn.y = row(now.y); mesh.turn.z = row(now.z);
    mesh.shift = place - mesh.turn(lmp_->wall_start[m]);
    mesh.spin = Vec(LAMMPS_NS::numbers(state, given.at.spin));
    mesh.velocity = velocity + cross(mesh.spin, mesh.shift - place);
  }
  return 0;
}

std::vector<std::pair<int, int> > Engine::neighbours() const {
  std::vector<std::pair<int, int> > pairs;
  lmp_->each([&](const char *, int a, int b) {
    if (a >= 0 && b >= 0) pairs.push_back({a, b});
  });
  return pairs;
}

void Engine::shorten_lists() {}  // YADE maintains its own lists
void Engine::create(const std::vector<Coming> &, const Spheres &, const Communicator &, double) {}  // no run here has checkpoints

void Engine::forget_springs() const {}  // done by its contacts

Vec Engine::press(int, double, const Vec &, double, const Vec &, double *) const { return Vec(); }

void Engine::check_box(const Spheres &, const Communicator &, int64_t step) const {
  const Given &given = lmp_->given;
  for (int a = 0; a < at.nlocal; a++)
    for (int k = 0; k < 3; k++)
      if (!(at.x[a][k] > given.low[k] && at.x[a][k] < given.high[k]))
        throw Stop("sphere " + std::to_string(at.tag[a]) + " left the simulated box before step " + std::to_string(step) +
                   "; expected walls or a tray that keep it, or a smaller time step");
}

}  // namespace pywet

#define EXPORT extern "C" __attribute__((visibility("default")))

EXPORT void *pywet_yade_open(const pywet::Given *given) {
  LAMMPS_NS::LAMMPS *host = new LAMMPS_NS::LAMMPS(*given);
  host->trajectory = fopen("trajectory.txt", "w");
  return host;
}

// Call-back between YADE's contacts and its integration of step n; `sorted`: it has searched for neighbours.
EXPORT void pywet_yade_step(void *engine, int64_t n, int sorted) {
  LAMMPS_NS::LAMMPS &host = *static_cast<LAMMPS_NS::LAMMPS *>(engine);
  host.sorted = sorted != 0;
  host.look();
  host.weigh();
  if (host.given.rolling) host.roll();
  host.callback(nullptr, n, 0, nullptr, nullptr, nullptr);
  if (n % host.given.every == 0) host.frame(host.trajectory, n, false);
  if (host.given.recorded[n]) {
    if (!host.states) host.states = fopen("states.txt", "w");
    host.frame(host.states, n, true);
  }
  if (n == 0) host.take_back();
}

EXPORT void pywet_yade_close(void *engine) {
  LAMMPS_NS::LAMMPS *host = static_cast<LAMMPS_NS::LAMMPS *>(engine);
  for (FILE *file : {host->trajectory, host->states})
    if (file) fclose(file);
  delete host;
}
