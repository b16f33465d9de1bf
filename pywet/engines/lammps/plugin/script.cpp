// Fix style `fix ID all pywet WORDS` for users' LAMMPS scripts: the counterpart of engines/liggghts/plugin/script.cpp.
// One process; walls are regions or planes, which stay dry; no restart files.
#include "script.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mpi.h>
#include <sstream>
#include <string>

#include "engine.h"
#include "turnover.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "fix.h"
#include "force.h"
#include "lammps.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "pair.h"
#include "update.h"

namespace pywet {
namespace {

using namespace LAMMPS_NS;

// Call-back into Python when the line is read, before every run, and when the first run begins; an error there ends the program.
typedef void (*Asked)(const char *when);

Asked asked = nullptr;
LAMMPS *lmp_of_script = nullptr;

class FixWet;
FixWet *wet = nullptr;
std::string words_of_line;              // one in each line of text

class FixWet : public Fix {
 public:
  int64_t last = -1;                    // step of the latest forces
  Callback callback = nullptr;

  FixWet(LAMMPS *lmp, int n, char **words) : Fix(lmp, n, words) {
    peratom_flag = vector_flag = 1;
    peratom_freq = global_freq = 1;
    size_peratom_cols = OF_SPHERE;
    size_vector = ALL;
    extvector = 0;
    FixWet::grow_arrays(atom->nmax);
    atom->add_callback(Atom::GROW);
  }
  ~FixWet() override {
    if (modify->get_fix_by_id(id)) atom->delete_callback(id, Atom::GROW);
    memory->destroy(values_);
    memory->destroy(extra_);
    if (wet == this) wet = nullptr;
  }
  int setmask() override { return FixConst::POST_FORCE; }
  void grow_arrays(int n) override {
    memory->grow(values_, n, OF_SPHERE, "pywet:values");
    memory->grow(extra_, n, 3, "pywet:extra");
    array_atom = values_;
  }
  double compute_vector(int k) override {
    if (last < 0) return 0;
    if (summed_ != last) copy_sums(sums_);
    summed_ = last;
    return sums_[k];
  }
  void post_constructor() override {
    modify->add_fix("p_liquid all property/atom d2_liquid " + std::to_string(NUMBERS_TAKEN));
    asked("line");
  }
  void init() override { asked("run"); }
  void setup(int flags) override {
    if (last < 0) asked("begin");
    post_force(flags);
  }
  void post_force(int) override {
    last = update->ntimestep;
    const int n = atom->nlocal;
    for (int a = 0; a < n; a++) std::copy(atom->f[a], atom->f[a] + 3, values_[a] + 2);
    if (callback) callback(nullptr, last, n, nullptr, atom->x, extra_);
    for (int a = 0; a < n; a++)
      for (int k = 0; k < 3; k++) values_[a][2 + k] = atom->f[a][k] - values_[a][2 + k];
    copy_sphere_values(values_, n);
  }

 private:
  double **values_ = nullptr, **extra_ = nullptr;  // values of each sphere, see script.h; unused, see plugin.cpp
  double sums_[ALL] = {};
  int64_t summed_ = -1;                 // step of these sums
};

Fix *made(LAMMPS *lmp, int n, char **words) {
  words_of_line = words[0];
  for (int k = 1; k < n; k++) words_of_line += std::string("\n") + words[k];
  return wet = new FixWet(lmp, n, words);
}

// Periodic lengths along x, y, z [m], 0 if not periodic.
std::string periodic_lengths() {
  const Domain &box = *lmp_of_script->domain;
  std::ostringstream out;
  out.precision(17);
  for (int k = 0; k < 3; k++) out << (k ? "," : "[") << (box.periodicity[k] ? box.prd[k] : 0.0);
  return out.str() + "]";
}

}  // namespace

bool hook_script(const char *id, Callback callback) {
  if (!wet || std::strcmp(wet->id, id) != 0) return false;
  wet->callback = callback;
  return true;
}

}  // namespace pywet

#define EXPORT extern "C" __attribute__((visibility("default")))

// Registers the style with the engine.
EXPORT void pywet_know_script(void *lmp, void (*ask)(const char *)) {
  using namespace pywet;
  lmp_of_script = static_cast<LAMMPS_NS::LAMMPS *>(lmp);
  asked = ask;
  (*lmp_of_script->modify->fix_map)["pywet"] = made;
}

// Words of the latest line of fix pywet after `fix`, as the engine read them; separated by line breaks.
EXPORT const char *pywet_script_words() { return pywet::words_of_line.c_str(); }

// Present state of the engine as JSON with the keys of the other engine; names are those of its script.
EXPORT const char *pywet_script_state() {
  using namespace pywet;
  static std::string text;
  LAMMPS_NS::LAMMPS &lmp = *lmp_of_script;
  const LAMMPS_NS::Neighbor &lists = *lmp.neighbor;
  const LAMMPS_NS::Atom &atom = *lmp.atom;
  const bool granular = atom.radius_flag && atom.rmass_flag;
  double least = INF, largest = 0;
  for (int a = 0; granular && a < atom.nlocal; a++) {
    least = std::min(least, atom.radius[a]);
    largest = std::max(largest, atom.radius[a]);
  }
  largest = std::max(largest, 0.5 * (lists.cutneighmax - lists.skin));  // also of spheres that a fix will insert
  const std::string pair = lmp.force->pair_style ? lmp.force->pair_style : "";
  const bool known = pair == "granular" || pair.rfind("gran/", 0) == 0;
  double *g = nullptr, gravity[3] = {};
  std::ostringstream out, fixes;
  fixes.precision(17);
  bool own = false;
  for (int k = 0; k < lmp.modify->nfix; k++) {
    LAMMPS_NS::Fix *fix = lmp.modify->fix[k];
    const bool acts = lmp.modify->get_fix_mask(fix) & LAMMPS_NS::FixConst::POST_FORCE, later = acts && own;
    own = own || fix == wet;
    const std::string style = fix->style;
    int dimension = 0;
    if (style == "gravity" && (g = static_cast<double *>(fix->extract("gvec", dimension))))
      for (int e = 0; e < 3; e++) gravity[e] += g[e];
    fixes << (k ? "," : "") << "{\"id\":\"" << fix->id << "\",\"style\":\"" << style << "\",\"all\":" << (fix->igroup == 0)
          << ",\"later\":" << later << ",\"acts\":" << acts << (style.rfind("wall/gran", 0) == 0 ? ",\"meshes\":[]" : "") << "}";
  }
  out.precision(17);
  out << "{\"ranks\":" << lmp.comm->nprocs << ",\"step\":" << lmp.update->ntimestep << ",\"last\":" << (wet ? wet->last : -1)
      << ",\"restored\":0,\"time_step\":" << lmp.update->dt << ",\"spheres\":" << atom.natoms << ",\"map\":" << atom.map_style
      << ",\"newton\":" << lmp.force->newton << ",\"delay\":" << lists.delay << ",\"every\":" << lists.every << ",\"check\":"
      << lists.dist_check << ",\"contact_distance_factor\":1.0,\"skin\":" << lists.skin << ",\"least_radius\":"
      << (least < INF ? least : 0) << ",\"largest_radius\":" << largest << ",\"layers\":" << lmp.comm->procgrid[2]
      << ",\"ghost_velocity\":" << lmp.comm->ghost_velocity << ",\"periodic\":" << periodic_lengths()
      << ",\"tilted\":" << lmp.domain->triclinic << ",\"reach\":" << lists.cutneighmax << ",\"coarsegraining\":0,\"units\":\"" << lmp.update->unit_style << "\",\"granular\":" << granular << ",\"cohesion\":"
      << (known ? 0 : -1) << ",\"steady_gravity\":0,\"gravity\":[" << gravity[0] << "," << gravity[1] << "," << gravity[2]
      << "],\"fixes\":[" << fixes.str() << "]}";
  text = out.str();
  return text.c_str();
}

// Values of all spheres, as many as the state declares, sorted by id.
EXPORT void pywet_script_spheres(void *all) {
  const LAMMPS_NS::Atom &atom = *pywet::lmp_of_script->atom;
  std::vector<pywet::Newcomer> now(atom.nlocal);
  for (int a = 0; a < atom.nlocal; a++) {
    now[a] = pywet::Newcomer{atom.tag[a], atom.type[a], atom.radius[a], atom.rmass[a], {}};
    pywet::store(pywet::Vec(atom.x[a]), now[a].x);
  }
  std::sort(now.begin(), now.end(), [](const pywet::Newcomer &p, const pywet::Newcomer &q) { return p.id < q.id; });
  std::copy(now.begin(), now.end(), static_cast<pywet::Newcomer *>(all));
}
