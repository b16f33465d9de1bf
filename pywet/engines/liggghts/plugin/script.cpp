// A fix style for scripts of the user's own, `fix ID all pywet WORDS`: the engine reads its script by itself and this style sets the
// plugin up where its line stands. What is said there, and whether it can be done, is for pywet.cases.script to say.
#include <cstdint>
#include <map>
#include <sstream>
#include <string>

#include "contacts.h"
#include "engine.h"

// engine headers, in the order in which they compile outside the engine's own tree
#include "mpi.h"
#include "fix_insert_stream.h"
#include "global_properties.h"
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "fix_external.h"
#include "force.h"
#include "lammps.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

namespace pywet {
namespace {

using namespace LAMMPS_NS;

// What is asked when the line is read (with its words) and before every run (without): a refusal ends the program there.
typedef void (*Asked)(const char *words);

Asked asked = nullptr;
LAMMPS *lmp_of_script = nullptr;

typedef std::map<std::string, Fix *(*)(LAMMPS *, int, char **)> Styles;
template <Styles *Modify::*MEMBER>
struct Door {
  friend Styles *styles_of(Modify &modify) { return modify.*MEMBER; }
};
Styles *styles_of(Modify &modify);

class FixWet : public FixExternal {
 public:
  int64_t last = -1;                    // step of the latest forces

  FixWet(LAMMPS *lmp, int n, char **words, int same, char **as_external) : FixExternal(lmp, same, as_external) {
    for (int k = 0; k < n; k++) words_ += std::string(k ? "\n" : "") + words[k];
  }
  void post_create() override {
    const char *held[8 + NUMBERS_TAKEN] = {"p_liquid", "all", "property/atom", "pywet_liquid", "vector", "no", "yes", "no"};
    std::fill_n(held + 8, int(NUMBERS_TAKEN), "none");
    modify->add_fix(8 + NUMBERS_TAKEN, const_cast<char **>(held));
    asked(words_.c_str());
  }
  void init() override {
    asked("");
    FixExternal::init();
  }
  void setup(int flags) override { post_force(flags); }
  void post_force(int flags) override {
    last = update->ntimestep;
    FixExternal::post_force(flags);
  }

 private:
  std::string words_;
};

FixWet *wet = nullptr;

Fix *made(LAMMPS *lmp, int n, char **words) {
  const char *same[6] = {words[0], words[1], "external", "pf/callback", "1", "1"};
  return wet = new FixWet(lmp, n, words, 6, const_cast<char **>(same));
}

}  // namespace

template struct Door<&Modify::fix_map>;

}  // namespace pywet

#define EXPORT extern "C" __attribute__((visibility("default")))

// Makes the style known to the engine.
EXPORT void pywet_know_script(void *lmp, void (*ask)(const char *)) {
  using namespace pywet;
  lmp_of_script = static_cast<LAMMPS_NS::LAMMPS *>(lmp);
  asked = ask;
  (*styles_of(*lmp_of_script->modify))["pywet"] = made;
}

// What the engine holds now, as JSON; names in it are words of its script.
EXPORT const char *pywet_script_state() {
  using namespace pywet;
  static std::string text;
  LAMMPS_NS::LAMMPS &lmp = *lmp_of_script;
  const LAMMPS_NS::Neighbor &lists = *lmp.neighbor;
  std::ostringstream out;
  out.precision(17);
  out << "{\"ranks\":" << lmp.comm->nprocs << ",\"step\":" << lmp.update->ntimestep << ",\"last\":" << (wet ? wet->last : -1)
      << ",\"time_step\":" << lmp.update->dt << ",\"spheres\":" << lmp.atom->natoms << ",\"map\":" << lmp.atom->map_style
      << ",\"newton\":" << lmp.force->newton << ",\"delay\":" << lists.delay << ",\"every\":" << lists.every
      << ",\"check\":" << lists.dist_check << ",\"contact_distance_factor\":" << lists.contactDistanceFactor
      << ",\"skin\":" << lists.skin << ",\"periodic\":"
      << (lmp.domain->xperiodic || lmp.domain->yperiodic || lmp.domain->zperiodic) << ",\"coarsegraining\":"
      << lmp.force->cg_active() << ",\"units\":\"" << lmp.update->unit_style << "\",\"granular\":"
      << (lmp.atom->radius_flag && lmp.atom->rmass_flag) << ",\"cohesion\":" << int(cohesion(&lmp)) << ",\"fixes\":[";
  for (int k = 0, own = lmp.modify->nfix; k < lmp.modify->nfix; k++) {
    LAMMPS_NS::Fix *fix = lmp.modify->fix[k];
    if (fix == wet) own = k;
    const bool later = k > own && (lmp.modify->fmask[k] & LAMMPS_NS::FixConst::POST_FORCE);
    out << (k ? "," : "") << "{\"id\":\"" << fix->id << "\",\"style\":\"" << fix->style << "\",\"all\":" << (fix->igroup == 0)
        << ",\"later\":" << later << "}";
  }
  out << "]}";
  text = out.str();
  return text.c_str();
}

// Of the spheres, as many as the state says.
EXPORT void pywet_script_spheres(int *id, int *type, double *radius, double *mass) {
  const LAMMPS_NS::Atom &atom = *pywet::lmp_of_script->atom;
  for (int a = 0; a < atom.nlocal; a++) {
    id[a] = atom.tag[a];
    type[a] = atom.type[a];
    radius[a] = atom.radius[a];
    mass[a] = atom.rmass[a];
  }
}
