#include "contacts.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "contact_law.h"

// engine headers, in an order that compiles outside the engine's source tree
#include "atom.h"
#include "fix_insert_stream.h"
#include "fix_property_global.h"
#include "force.h"
#include "global_properties.h"
#include "lammps.h"
#include "modify.h"
#include "mpi.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "update.h"

// As in engine.cpp: the engine's package lacks the lists of contact models, which are not needed to call a model.
#define CONTACT_MODEL_CONSTANTS_H_
namespace LIGGGHTS {
namespace ContactModels {
enum { NORMAL_OFF, TANGENTIAL_OFF, COHESION_OFF, ROLLING_OFF };
}
}  // namespace LIGGGHTS
#include "pair_gran_proxy.h"

namespace pywet {
namespace {

typedef LIGGGHTS::PairStyles::IGranularPairStyle Style;

// The contact members of the engine's pair style are private; an explicit instantiation may name private members.
template <Style *LAMMPS_NS::PairGranProxy::*MEMBER>
struct Door {
  friend Style *&style_of(LAMMPS_NS::PairGranProxy &pair) { return pair.*MEMBER; }
};
Style *&style_of(LAMMPS_NS::PairGranProxy &pair);
template struct Door<&LAMMPS_NS::PairGranProxy::impl>;

const int TOUCHED = 1 << 0 | 1 << 2;    // the engine's flags of its normal and tangential models

bool is(Style &style, const char *rolling) {
  return style.contact_match("surface", "default") && style.contact_match("normal", "hooke/stiffness") &&
         style.contact_match("tangential", "history") && style.contact_match("cohesion", "off") &&
         style.contact_match("rolling_friction", rolling);
}

// Everything but the forces of an ordinary step is done by the engine's own style.
class Batches : public Style {
 public:
  Batches(LAMMPS_NS::LAMMPS *lmp, Style *stock) : lmp_(lmp), stock_(stock) {
    types_ = lmp->atom->ntypes;
    materials_.resize(types_ * types_);
    read("kn", &Material::normal);
    read("kt", &Material::tangential);
    read("gamman_abs", &Material::damping);
    read("coefficientFriction", &Material::friction);
    if (is(*stock, "cdt")) read("coefficientRollingFriction", &Material::rolling);
  }

  void settings(int n, char **words, LIGGGHTS::IContactHistorySetup *history) override { stock_->settings(n, words, history); }
  void init_granular() override { stock_->init_granular(); }
  void write_restart_settings(FILE *file) override { stock_->write_restart_settings(file); }
  void read_restart_settings(FILE *file, int64_t hashcode) override { stock_->read_restart_settings(file, hashcode); }
  // cppcheck-suppress passedByValue; signature of the engine
  int get_history_offset(const std::string name) override { return stock_->get_history_offset(name); }
  double stressStrainExponent() override { return stock_->stressStrainExponent(); }
  int64_t hashcode() override { return stock_->hashcode(); }
  // cppcheck-suppress passedByValue; signature of the engine
  bool contact_match(const std::string kind, const std::string model) override { return stock_->contact_match(kind, model); }

  // The set-up of a run does not change springs; requests for single contacts are answered by the engine.
  void compute_force(LAMMPS_NS::PairGran *pair, int energy, int virial, int add) override {
    if (!pair->computeflag() || !pair->shearupdate() || add || pair->storeContactForces() || pair->storeContactForcesStress() ||
        pair->store_sum_normal_force())
      return stock_->compute_force(pair, energy, virial, add);
    pair->evflag = pair->vflag_fdotr = 0;
    const LAMMPS_NS::NeighList &list = *pair->list, &history = *pair->listgranhistory;
    const double *places = lmp_->atom->x[0], *radii = lmp_->atom->radius;
    const int numbers = pair->dnum();
    for (int q = 0; q < list.inum; q++) {
      const int i = list.ilist[q], count = list.numneigh[i], *partner = list.firstneigh[i];
      int *touched = history.firstneigh[i];
      double *springs = history.firstdouble[i];
      for (int from = 0; from < count; from += BATCH) {
        const int n = std::min(BATCH, count - from);
        find_touching(n, partner + from, NEIGHMASK, places, radii, lmp_->atom->x[i], radii[i], touches_);
        for (int k = 0; k < n; k++) {
          const int c = from + k;
          if (touches_[k]) {
            touched[c] |= TOUCHED;
            add_contact(i, partner[c] & NEIGHMASK, springs + numbers * c);
          } else if (touched[c]) {
            touched[c] = 0;
            std::fill_n(springs + numbers * c, numbers, 0.0);
          }
        }
      }
    }
    press();
  }

 private:
  LAMMPS_NS::LAMMPS *lmp_;
  std::unique_ptr<Style> stock_;
  int types_, count_ = 0;
  std::vector<Material> materials_;
  ContactBatch batch_ = {};
  unsigned touches_[BATCH];

  void read(const char *name, double Material::*number) {
    LAMMPS_NS::FixPropertyGlobal *fix =
        dynamic_cast<LAMMPS_NS::FixPropertyGlobal *>(lmp_->modify->find_fix_id((std::string("p_") + name).c_str()));
    if (!fix) throw std::runtime_error(std::string("the deck has no fix property/global named p_") + name);
    for (int a = 0; a < types_; a++)
      for (int b = 0; b < types_; b++) materials_[a * types_ + b].*number = fix->compute_array(a, b);
  }

  void add_contact(int i, int j, double *spring) {
    const LAMMPS_NS::Atom &atom = *lmp_->atom;
    const int k = count_;
    const Material &m = materials_[(atom.type[i] - 1) * types_ + atom.type[j] - 1];
    for (int e = 0; e < 3; e++) {
      batch_.apart[e][k] = atom.x[i][e] - atom.x[j][e];
      batch_.velocity[e][k] = atom.v[i][e] - atom.v[j][e];
      batch_.spin_i[e][k] = atom.omega[i][e];
      batch_.spin_j[e][k] = atom.omega[j][e];
      batch_.spring[e][k] = spring[e];
    }
    batch_.radius_i[k] = atom.radius[i];
    batch_.radius_j[k] = atom.radius[j];
    batch_.normal[k] = m.normal;
    batch_.tangential[k] = m.tangential;
    batch_.damping[k] = m.damping;
    batch_.friction[k] = m.friction;
    batch_.rolling[k] = m.rolling;
    batch_.i[k] = i;
    batch_.j[k] = j;
    batch_.history[k] = spring;
    if (++count_ == BATCH) press();
  }

  // Sums are formed in the order of the neighbour list, as in the engine.
  void press() {
    const LAMMPS_NS::Atom &atom = *lmp_->atom;
    press_together(batch_, count_, lmp_->update->dt);
    for (int k = 0; k < count_; k++) {
      const int i = batch_.i[k], j = batch_.j[k];
      for (int e = 0; e < 3; e++) {
        batch_.history[k][e] = batch_.spring[e][k];
        atom.f[i][e] += batch_.force[e][k];
        atom.torque[i][e] += batch_.torque_i[e][k];
      }
      if (j >= atom.nlocal) continue;
      for (int e = 0; e < 3; e++) {
        atom.f[j][e] -= batch_.force[e][k];
        atom.torque[j][e] += batch_.torque_j[e][k];
      }
    }
    count_ = 0;
  }
};

}  // namespace

int cohesion(LAMMPS_NS::LAMMPS *lmp) {
  LAMMPS_NS::PairGranProxy *pair = dynamic_cast<LAMMPS_NS::PairGranProxy *>(lmp->force->pair);
  return !pair ? -1 : !style_of(*pair)->contact_match("cohesion", "off");
}

bool batch_contacts(LAMMPS_NS::LAMMPS *lmp) {
  LAMMPS_NS::PairGranProxy *pair = dynamic_cast<LAMMPS_NS::PairGranProxy *>(lmp->force->pair);
  if (!pair || lmp->force->newton_pair) return false;
  Style *&style = style_of(*pair);
  if (!is(*style, "cdt") && !is(*style, "off")) return false;
  Batches *batches = new Batches(lmp, style);
  style = batches;                      // the engine deletes it with its pair style
  return true;
}

}  // namespace pywet
