// Logs: events always, contacts in sampling windows, the rest at output steps. Files of records.h, some on every rank, some on the first.
#pragma once
#include <string>

#include "energy.h"
#include "films.h"
#include "impulse_sums.h"
#include "records.h"

namespace pywet {

class Logs {
 public:
  Logs(const SimulationState &world, const Films &films, BridgeList &standing, const EnergyBudget &energy, const ImpulseSums &sums)
      : world_(world), films_(films), standing_(standing), energy_(energy), sums_(sums) {}
  void open(const std::string &directory);
  const std::string &directory() const { return directory_; }
  void write(const Event &e);
  void write(const Drop &d);
  void write(const Felt &f);
  void write(const WireContact &c);
  void write(const RetiredSphere &s);
  void poses();                          // poses of all meshes, for a user's script
  Ledger counted() const;                // ledger of the present step; complete on the first rank; collective
  void contact(const Bridge &b, const Geometry &g, const Terms &t, double weight);
  void snapshot();                       // films, bridges, impulses, ledger, energy; collective
  void energies_in_window();             // energies of a step of a sampling window; collective
  void flush();

  // Writes the last positions of this rank's spheres to stopped.<rank>.csv, for a search for the cause.
  void stop(const std::string &why) const;

 private:
  const SimulationState &world_;
  const Films &films_;
  BridgeList &standing_;                   // caches closest points at walls when they are requested
  const EnergyBudget &energy_;
  const ImpulseSums &sums_;
  std::string directory_;
  RecordFile contacts_, bridges_, wires_, events_, drops_, felt_, retired_, ledger_, film_, wall_film_, impulses_, energies_, window_energies_, states_, poses_;

  void states();
  void energies(RecordFile &file);
};

}  // namespace pywet
