// Fix style `fix ID all pywet WORDS` for users' scripts: the engine reads its script, and this style sets the plugin up at its line.
// Syntax and admissible values are checked in pywet.cases.script.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>
#include <string>

#include "contacts.h"
#include "engine.h"
#include "script.h"
#include "turnover.h"

// engine headers, in the order that compiles outside the engine's source tree
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "fix_external.h"
#include "fix_gravity.h"
#include "fix_insert_stream.h"
#include "fix_mesh_surface.h"
#include "force.h"
#include "global_properties.h"
#include "lammps.h"
#include "memory.h"
#include "modify.h"
#include "mpi.h"
#include "neighbor.h"
#include "properties.h"
#include "tri_mesh.h"
#include "update.h"

// see engine.cpp
#define CONTACT_MODEL_CONSTANTS_H_
namespace LIGGGHTS {
namespace ContactModels {
enum { NORMAL_OFF, TANGENTIAL_OFF, COHESION_OFF, ROLLING_OFF };
}
}  // namespace LIGGGHTS
#include "fix_wall_gran.h"

namespace pywet {
namespace {

using namespace LAMMPS_NS;

// Call-back into Python when the line is read, before every run, and when the first run begins; an error there ends the program.
typedef void (*Asked)(const char *when);

Asked asked = nullptr;
LAMMPS *lmp_of_script = nullptr;

typedef std::map<std::string, Fix *(*)(LAMMPS *, int, char **)> Styles;
template <Styles *Modify::*MEMBER>
struct Door {
  friend Styles *styles_of(Modify &modify) { return modify.*MEMBER; }
};
Styles *styles_of(Modify &modify);

class FixWet;
FixWet *wet = nullptr;
std::string words_of_line;              // one in each line of text

class FixWet : public FixExternal {
 public:
  int64_t last = -1;                    // step of the latest forces
  std::vector<double> restored;         // values from a restart file

  FixWet(LAMMPS *lmp, int same, char **as_external) : FixExternal(lmp, same, as_external) {
    restart_global = 1;
    peratom_flag = vector_flag = peratom_freq = global_freq = 1;
    size_peratom_cols = OF_SPHERE;
    size_vector = ALL;
    extvector = 0;
    FixWet::grow_arrays(atom->nmax);
  }
  ~FixWet() {
    memory->destroy(values_);
    if (wet == this) wet = nullptr;
  }
  void grow_arrays(int n) override {
    FixExternal::grow_arrays(n);
    memory->grow(values_, n, OF_SPHERE, "pywet:values");
    array_atom = values_;
  }
  double compute_vector(int k) override {
    if (last < 0) return 0;
    if (summed_ != last) copy_sums(sums_);
    summed_ = last;
    return sums_[k];
  }
  void post_create() override {
    const char *held[8 + NUMBERS_TAKEN] = {"p_liquid", "all", "property/atom", "pywet_liquid", "vector", "yes", "yes", "no"};
    std::fill_n(held + 8, int(NUMBERS_TAKEN), "0.");  // also for spheres that are created later
    modify->add_fix(8 + NUMBERS_TAKEN, const_cast<char **>(held));
    asked("line");
  }
  void init() override {
    asked("run");
    if (last >= 0) FixExternal::init();
  }
  void setup(int flags) override {
    if (last < 0) asked("begin");         // meshes and inserted spheres exist now
    post_force(flags);
  }
  // The engine passes what follows the size, without the size.
  void write_restart(FILE *file) override {
    std::vector<double> state(1, 0.0);
    if (last >= 0) {
      const std::vector<double> all = state_of_script();
      state[0] = double(all.size());
      state.insert(state.end(), all.begin(), all.end());
    }
    const int size = int(state.size() * sizeof(double));
    if (comm->me != 0) return;
    fwrite(&size, sizeof(int), 1, file);
    fwrite(state.data(), sizeof(double), state.size(), file);
  }
  void restart(char *state) override {
    double count;
    std::memcpy(&count, state, sizeof count);
    restored.resize(size_t(count));
    std::memcpy(restored.data(), state + sizeof count, sizeof(double) * restored.size());
  }
  void post_force(int flags) override {
    last = update->ntimestep;
    const int n = atom->nlocal;
    for (int a = 0; a < n; a++) std::copy(atom->f[a], atom->f[a] + 3, values_[a] + 2);
    FixExternal::post_force(flags);
    for (int a = 0; a < n; a++)
      for (int k = 0; k < 3; k++) values_[a][2 + k] = atom->f[a][k] - values_[a][2 + k];
    copy_sphere_values(values_, n);
  }

 private:
  double **values_ = nullptr;             // values of each sphere, see script.h
  double sums_[ALL] = {};
  int64_t summed_ = -1;                 // step of these sums
};

LAMMPS_NS::FixMeshSurface *mesh_of(const char *id) {
  return dynamic_cast<LAMMPS_NS::FixMeshSurface *>(lmp_of_script->modify->find_fix_id(id));
}

// For a wall its meshes (none: a primitive wall), for a mesh the number of its triangles and its index.
void say_walls(std::ostream &out, LAMMPS_NS::Fix *fix) {
  if (LAMMPS_NS::FixWallGran *wall = dynamic_cast<LAMMPS_NS::FixWallGran *>(fix)) {
    out << ",\"meshes\":[";
    for (int k = 0; wall->is_mesh_wall() && k < wall->n_meshes(); k++) out << (k ? ",\"" : "\"") << wall->mesh_list()[k]->id << "\"";
    out << "],\"cohesive\":" << !wall->contact_match("cohesion", "off");
  }
  if (LAMMPS_NS::FixMeshSurface *mesh = dynamic_cast<LAMMPS_NS::FixMeshSurface *>(fix))
    out << ",\"triangles\":" << mesh->triMesh()->sizeGlobal() << ",\"belt\":" << mesh->surfaceVel() << ",\"is\":\"" << mesh << "\"";
}

// Sum of all gravity fixes [m/s2], and whether it is constant and acts on all spheres.
void say_gravity(std::ostream &out) {
  struct Steady : LAMMPS_NS::FixGravity {
    static bool is(LAMMPS_NS::FixGravity *fix) { return fix->igroup == 0 && fix->*(&Steady::varflag) == 0; }
  };
  double all[3] = {};
  bool steady = true;
  for (int k = 0; k < lmp_of_script->modify->nfix; k++) {
    LAMMPS_NS::FixGravity *gravity = dynamic_cast<LAMMPS_NS::FixGravity *>(lmp_of_script->modify->fix[k]);
    if (!gravity) continue;
    double one[3];
    gravity->get_gravity(one);
    for (int e = 0; e < 3; e++) all[e] += one[e];
    steady = steady && Steady::is(gravity);
  }
  out << ",\"steady_gravity\":" << steady << ",\"gravity\":[" << all[0] << "," << all[1] << "," << all[2] << "]";
}

// Periodic lengths along x, y, z [m], 0 if not periodic.
std::string periodic_lengths() {
  const LAMMPS_NS::Domain &box = *lmp_of_script->domain;
  std::ostringstream out;
  out.precision(17);
  for (int k = 0; k < 3; k++) out << (k ? "," : "[") << (box.periodicity[k] ? box.prd[k] : 0.0);
  return out.str() + "]";
}

std::vector<Newcomer> spheres_now() {
  const LAMMPS_NS::Atom &atom = *lmp_of_script->atom;
  std::vector<Newcomer> mine(atom.nlocal);
  for (int a = 0; a < atom.nlocal; a++) {
    mine[a] = Newcomer{atom.tag[a], atom.type[a], atom.radius[a], atom.rmass[a], {}};
    store(Vec(atom.x[a]), mine[a].x);
  }
  Communicator ranks;
  ranks.join(lmp_of_script->world);
  std::vector<Newcomer> all = ranks.gathered(mine);
  std::sort(all.begin(), all.end(), [](const Newcomer &p, const Newcomer &q) { return p.id < q.id; });
  return all;
}

Fix *made(LAMMPS *lmp, int n, char **words) {
  words_of_line = words[0];
  for (int k = 1; k < n; k++) words_of_line += std::string("\n") + words[k];
  const char *same[6] = {words[0], words[1], "external", "pf/callback", "1", "1"};
  return wet = new FixWet(lmp, 6, const_cast<char **>(same));
}

template struct Door<&Modify::fix_map>;

}  // namespace
}  // namespace pywet

#define EXPORT extern "C" __attribute__((visibility("default")))

// Registers the style with the engine.
EXPORT void pywet_know_script(void *lmp, void (*ask)(const char *)) {
  using namespace pywet;
  lmp_of_script = static_cast<LAMMPS_NS::LAMMPS *>(lmp);
  asked = ask;
  (*styles_of(*lmp_of_script->modify))["pywet"] = made;
}

// Words of the latest line of fix pywet after `fix`, as the engine read them; separated by line breaks.
EXPORT const char *pywet_script_words() { return pywet::words_of_line.c_str(); }

// Present state of the engine as JSON; names are those of its script.
EXPORT const char *pywet_script_state() {
  using namespace pywet;
  static std::string text;
  LAMMPS_NS::LAMMPS &lmp = *lmp_of_script;
  const LAMMPS_NS::Neighbor &lists = *lmp.neighbor;
  LAMMPS_NS::Properties *properties = lmp.atom->get_properties();
  std::ostringstream out;
  out.precision(17);
  out << "{\"ranks\":" << lmp.comm->nprocs << ",\"step\":" << lmp.update->ntimestep << ",\"last\":" << (wet ? wet->last : -1)
      << ",\"restored\":" << (wet ? wet->restored.size() : 0)
      << ",\"time_step\":" << lmp.update->dt << ",\"spheres\":" << lmp.atom->natoms << ",\"map\":" << lmp.atom->map_style
      << ",\"newton\":" << lmp.force->newton << ",\"delay\":" << lists.delay << ",\"every\":" << lists.every
      << ",\"check\":" << lists.dist_check << ",\"contact_distance_factor\":" << lists.contactDistanceFactor
      << ",\"skin\":" << lists.skin << ",\"least_radius\":" << properties->min_radius() << ",\"largest_radius\":"
      << properties->max_radius() << ",\"layers\":" << lmp.comm->procgrid[2] << ",\"ghost_velocity\":" << lmp.comm->ghost_velocity
      << ",\"periodic\":" << periodic_lengths() << ",\"tilted\":" << lmp.domain->triclinic << ",\"reach\":" << lists.cutneighmax
      << ",\"coarsegraining\":" << lmp.force->cg_active() << ",\"units\":\"" << lmp.update->unit_style << "\",\"granular\":"
      << (lmp.atom->radius_flag && lmp.atom->rmass_flag) << ",\"cohesion\":" << int(cohesion(&lmp));
  say_gravity(out);
  out << ",\"fixes\":[";
  for (int k = 0, own = lmp.modify->nfix; k < lmp.modify->nfix; k++) {
    LAMMPS_NS::Fix *fix = lmp.modify->fix[k];
    if (fix == wet) own = k;
    const bool acts = lmp.modify->fmask[k] & LAMMPS_NS::FixConst::POST_FORCE, later = acts && k > own;
    out << (k ? "," : "") << "{\"id\":\"" << fix->id << "\",\"style\":\"" << (fix == wet ? "pywet" : fix->style) << "\",\"all\":" << (fix->igroup == 0)
        << ",\"later\":" << later << ",\"acts\":" << acts;
    say_walls(out, fix);
    out << "}";
  }
  out << "]}";
  text = out.str();
  return text.c_str();
}

// Values of the restart file about the liquid, as many as the state declares.
EXPORT void pywet_script_restored(double *numbers) {
  std::copy(pywet::wet->restored.begin(), pywet::wet->restored.end(), numbers);
}

// Values of all spheres, as many as the state declares, sorted by id.
EXPORT void pywet_script_spheres(void *all) {
  const std::vector<pywet::Newcomer> now = pywet::spheres_now();
  std::copy(now.begin(), now.end(), static_cast<pywet::Newcomer *>(all));
}

// Present corners of a mesh's triangles, 9 numbers each, sorted by number; collective.
EXPORT void pywet_script_triangles(const char *id, double *corners) {
  using namespace pywet;
  LAMMPS_NS::TriMesh *mesh = mesh_of(id)->triMesh();
  std::vector<double> mine(9 * size_t(mesh->sizeGlobal()), -INF);
  for (int k = 0; k < mesh->sizeLocal(); k++)
    for (int corner = 0; corner < 3; corner++) mesh->node(k, corner, &mine[9 * size_t(mesh->id(k)) + 3 * corner]);
  MPI_Allreduce(mine.data(), corners, int(mine.size()), MPI_DOUBLE, MPI_MAX, lmp_of_script->world);
}
