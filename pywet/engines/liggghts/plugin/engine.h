// Interface to the engine: arrays, neighbour lists, motion of the meshes, its dry contact with a wall.
#pragma once
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "communicator.h"
#include "spheres.h"
#include "walls.h"

namespace LAMMPS_NS {
class LAMMPS;
class FixMeshSurface;
class FixPropertyAtom;
class FixWallGran;
class TriMesh;
}  // namespace LAMMPS_NS

namespace pywet {

struct Coming;

// The program: its call-back in every step, its processes, and termination by an error of all ranks or of one.
typedef void (*Callback)(void *, int64_t step, int n, int *, double **, double **extra);
void hook(LAMMPS_NS::LAMMPS *lmp, const char *fix_external, Callback callback);
MPI_Comm processes(const LAMMPS_NS::LAMMPS *lmp);
[[noreturn]] void end(LAMMPS_NS::LAMMPS *lmp, const char *why, bool together);

const double INF = std::numeric_limits<double>::infinity();

// Data of a sphere that migrate with it between ranks, in the deck's fix property/atom `p_liquid`, which has as many numbers: its film
// [m3], at the start and now; the step at which it enters; its liquid [m3], now and as included in its present mass; impulse of its
// bridges since the last output [N s], three components.
enum { FILM, FIRST, ENTERS, LOAD, WEIGHED, IMPULSE, NUMBERS_TAKEN = IMPULSE + 3 };

// State of the engine in this step on this rank: arrays over owned spheres (first nlocal) and ghosts.
struct View {
  double **x = nullptr, **v = nullptr, **omega = nullptr, **f = nullptr, **torque = nullptr;
  double *mass = nullptr;
  double **liquid = nullptr;
  double *radius = nullptr;
  int *tag = nullptr, *mask = nullptr, *type = nullptr;
  int nlocal = 0, nall = 0, free_group = 0;
  double dt = 0;
  Images images;                                        // periodic images of the box
  // Distance vector of two spheres, by the nearest images of both: a ghost represents its sphere wherever it is.
  Vec apart(int a, int b) const { return images.nearest(Vec(x[a]) - Vec(x[b])); }
  double *impulse(int a) const { return liquid[0] + size_t(NUMBERS_TAKEN) * a + IMPULSE; }  // the engine's vectors are contiguous
  bool free(int a) const { return mask[a] & free_group; }  // moved by forces, not at a prescribed velocity
  bool owned(int a) const { return a >= 0 && a < nlocal; }
};

// State of an engine mesh in this step.
struct MeshNow {
  size_t mesh;
  LAMMPS_NS::TriMesh *triangles;
  double ***velocities;                                 // velocities of the corners; null if the mesh has never moved
  bool moves;                                           // whether a mover acts on it
};

// Contact of a sphere with a triangle: overlap, vector from the closest point to the centre, weights of the corners at that point and its
// velocity, whether the contact is with the face and not with an edge or a corner.
struct Meeting {
  double overlap, share[3];
  Vec from_wall, velocity;
  bool face;
  Vec between(const Vec &a, const Vec &b, const Vec &c) const { return share[0] * a + share[1] * b + share[2] * c; }
};

class Engine {
 public:
  View at;
  double thickest_film = 0;                             // thickest film that the neighbour list covers, relative to the sphere's radius
  double skin = 0;                                      // lists are rebuilt when a sphere has moved by half of it

  // Finds the meshes of the walls; `presses`: the engine's dry contact with walls will be used.
  void attach(LAMMPS_NS::LAMMPS *lmp, const Walls &walls, bool presses);
  void look();

  int local(int id) const;                              // local index of a sphere: owned before ghost; -1: not on this rank
  void update_ghosts() const;                             // sends the migrating data of spheres to their ghosts; collective
  void find_neighbours(Communicator &ranks);                   // also determines which of this rank's spheres are ghosts elsewhere
  bool elsewhere(int a) const { return !at.owned(a) || (size_t(a) < sent_.size() && sent_[a]); }
  void keep_skin() const;                               // sets the skin again, which the engine resets at the start of each run
  double mesh_way() const;                              // displacement of a mesh after which lists are rebuilt as well
  bool lists_are_new(int64_t step) const;
  std::vector<std::pair<int, int> > neighbours() const;
  void shorten_lists();                                 // removes pairs that cannot touch before the next rebuild
  void move_meshes_together() const;                    // a mesh that vibrates along several axes is moved once in a step
  bool contacts_in_batches();                           // returns false if this engine or its contact model has none
  void forget_springs() const;                          // deletes the springs of listed pairs that no longer touch, if the batches do not
  void check_box(const Spheres &spheres, const Communicator &ranks, int64_t step) const;

  // Creates spheres between two runs, each on one rank; collective. Stops where another sphere is in the place of one.
  void create(const std::vector<Coming> &due, const Spheres &spheres, const Communicator &ranks, double time);

  // Updates the motion of the meshes that move in this step, or of all; returns the power of their dry contacts on the spheres. In the
  // set-up `again` of a further run, before which the engine resets their velocities, those of the last step are retained.
  double read_meshes(Walls &walls, const Communicator &ranks, bool all, bool again) const;

  // The engine's own dry contact of sphere a with a wall whose closest point is at x - d; returns the force on the sphere.
  Vec press(int a, double radius, const Vec &d, double overlap, const Vec &wall_velocity, double *spring) const;

  // In a periodic box: call this before the contacts with walls of each step; for walls that continue through its faces it sets the flags of
  // their corners as the engine sets those elsewhere.
  void before_walls(Callback callback) const;
  void join_corners(const Walls &walls) const;

  void before_clear() const;                            // frees what the engine does not free when it is cleared

  // Triangles are numbered as in the engine's mesh on this rank, -1: not here; `meets` returns the engine's contact with one of them.
  bool leaves_faces() const;                            // whether contacts with faces can be made in place of the engine
  std::vector<int> places_of_triangles(size_t m) const;
  MeshNow mesh_now(size_t m) const;
  bool meets(const MeshNow &now, int triangle, int a, Meeting &met) const;
  bool in_one_plane(const MeshNow &now, int one, int two) const;

 private:
  LAMMPS_NS::LAMMPS *lmp_ = nullptr;
  std::vector<LAMMPS_NS::FixMeshSurface *> surfaces_;   // in the order of Walls::meshes
  LAMMPS_NS::FixWallGran *wall_law_ = nullptr;
  LAMMPS_NS::FixPropertyAtom *liquid_ = nullptr;
  struct Run {                                          // consecutive lists in memory
    int *touched;
    double *springs;
    int numbers;                                        // number of values of a spring
    std::vector<std::pair<int, int> > pairs;
  };
  std::vector<Run> runs_;
  bool batches_forget_ = false;                         // whether the batches delete the tangential history of separated pairs
  std::vector<bool> sent_;                              // for each owned sphere: whether it was a ghost of another rank at the last rebuild

  double said(const char *variable) const;              // value of a variable of the deck
  bool read_mesh(size_t m, const Walls &walls, double *out) const;
};

}  // namespace pywet
