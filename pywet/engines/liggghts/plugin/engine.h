// All that is asked of the engine: arrays, neighbour lists, motion of the meshes, its dry contact with a wall.
#pragma once
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "ranks.h"
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

// The program itself: what it calls in every step, the processes it runs in, its end by an error that all ranks know or one.
typedef void (*Callback)(void *, int64_t step, int n, int *, double **, double **extra);
void hook(LAMMPS_NS::LAMMPS *lmp, const char *fix_external, Callback callback);
MPI_Comm processes(const LAMMPS_NS::LAMMPS *lmp);
[[noreturn]] void end(LAMMPS_NS::LAMMPS *lmp, const char *why, bool together);

const double INF = std::numeric_limits<double>::infinity();

// What a sphere takes along from rank to rank, in the deck's fix property/atom named `p_liquid`, which has as many numbers: its film
// [m3], at the start and now; the step at which it enters; liquid that it carries [m3], now and in its present mass; impulse of its
// bridges since the last output [N s], three components.
enum { FILM, FIRST, ENTERS, LOAD, WEIGHED, IMPULSE, NUMBERS_TAKEN = IMPULSE + 3 };

// What the engine holds in this step on this rank: arrays over owned spheres (first nlocal) and ghosts.
struct View {
  double **x = nullptr, **v = nullptr, **omega = nullptr, **f = nullptr, **torque = nullptr;
  double *mass = nullptr;
  double **liquid = nullptr;
  double *radius = nullptr;
  int *tag = nullptr, *mask = nullptr, *type = nullptr;
  int nlocal = 0, nall = 0, free_group = 0;
  double dt = 0;
  Images images;                                        // of the box
  // How far two of them are apart, the nearest copies of both: a ghost stands for its sphere wherever it is.
  Vec apart(int a, int b) const { return images.nearest(Vec(x[a]) - Vec(x[b])); }
  bool free(int a) const { return mask[a] & free_group; }  // moved by its forces, not driven
  bool owned(int a) const { return a >= 0 && a < nlocal; }
};

// A mesh of the engine in this step.
struct MeshNow {
  size_t mesh;
  LAMMPS_NS::TriMesh *triangles;
  double ***velocities;                                 // of the corners; none: it never moved
  bool moves;                                           // something moves it
};

// A sphere in touch with a triangle: overlap, the way from the closest point to its centre, that point's shares of the corners and its
// velocity, whether the face is touched and not an edge or a corner.
struct Meeting {
  double overlap, share[3];
  Vec from_wall, velocity;
  bool face;
  Vec between(const Vec &a, const Vec &b, const Vec &c) const { return share[0] * a + share[1] * b + share[2] * c; }
};

class Engine {
 public:
  View at;
  double thickest_film = 0;                             // that the neighbour list sees, of the sphere's radius
  double skin = 0;                                      // lists are made anew when a sphere has moved by half of it

  // Finds the meshes of the walls; `presses`: its dry contact with walls will be asked for.
  void attach(LAMMPS_NS::LAMMPS *lmp, const Walls &walls, bool presses);
  void look();

  int local(int id) const;                              // index of a sphere on this rank, its own before a ghost, -1: not here
  void tell_ghosts() const;                             // what their spheres take along; every rank takes part
  void find_neighbours(Communicator &ranks);                   // and whom of this rank's spheres another one holds too
  bool elsewhere(int a) const { return !at.owned(a) || (size_t(a) < sent_.size() && sent_[a]); }
  void keep_skin() const;                               // the engine forgets it at the start of each run
  double mesh_way() const;                              // of a mesh, after which they are rebuilt too
  bool lists_are_new(int64_t step) const;
  std::vector<std::pair<int, int> > neighbours() const;
  void shorten_lists();                                 // to the pairs that can touch before they are made anew
  bool contacts_in_batches(bool forgets);               // false: this engine or its contact model has none
  void forget_springs() const;                          // of listed pairs that no longer touch, where no batches do so
  void check_box(const Spheres &spheres, const Communicator &ranks, int64_t step) const;

  // Motion of the meshes that move in this step, or of all; returns the power of their dry contacts on the spheres.
  double read_meshes(Walls &walls, const Communicator &ranks, bool all) const;

  // The engine's own dry contact of sphere a with a wall whose closest point is at x - d; returns the force on the sphere.
  Vec press(int a, double radius, const Vec &d, double overlap, const Vec &wall_velocity, double *spring) const;

  // In a box that repeats: call this before the contacts with walls of each step; of walls that continue there, have their corners
  // as the engine has those elsewhere.
  void before_walls(Callback callback) const;
  void join_corners(const Walls &walls) const;

  void before_clear() const;                            // frees what the engine does not where it is emptied

  // Triangles by their numbers in the engine's mesh on this rank, -1: not here; of a contact with one of them what the engine says.
  bool leaves_faces() const;                            // contacts with faces can be made for it
  std::vector<int> places_of_triangles(size_t m) const;
  MeshNow mesh_now(size_t m) const;
  bool meets(const MeshNow &now, int triangle, int a, Meeting &met) const;
  bool in_one_plane(const MeshNow &now, int one, int two) const;

 private:
  LAMMPS_NS::LAMMPS *lmp_ = nullptr;
  std::vector<LAMMPS_NS::FixMeshSurface *> surfaces_;   // in the order of Walls::meshes
  LAMMPS_NS::FixWallGran *wall_law_ = nullptr;
  LAMMPS_NS::FixPropertyAtom *liquid_ = nullptr;
  struct Run {                                          // of lists one after the other in memory
    int *touched;
    double *springs;
    int numbers;                                        // of a spring
    std::vector<std::pair<int, int> > pairs;
  };
  std::vector<Run> runs_;
  bool batches_forget_ = false;                         // tangential history of pairs that have separated
  std::vector<bool> sent_;                              // of the owned spheres: ghosts of another rank since the last lists

  double said(const char *variable) const;              // by the deck
  bool read_mesh(size_t m, const Walls &walls, double *out) const;
};

}  // namespace pywet
