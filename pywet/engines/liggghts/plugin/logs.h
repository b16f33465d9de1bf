// Logs: events always, contacts in windows, the rest at output steps. Files of records.h, some on every rank, some on the first.
#pragma once
#include <string>

#include "energy.h"
#include "films.h"
#include "impulse_sums.h"
#include "records.h"

namespace pywet {

class Logs {
 public:
  Logs(const SimulationState &world, const Films &films, BridgeList &standing, const EnergyBook &energy, const ImpulseSums &sums)
      : world_(world), films_(films), standing_(standing), energy_(energy), sums_(sums) {}
  void open(const std::string &directory);
  const std::string &directory() const { return directory_; }
  void write(const Event &e);
  void write(const Drop &d);
  void write(const Felt &f);
  void write(const WireContact &c);
  void write(const RetiredSphere &s);
  void poses();                          // of all meshes, of a script of the user's own
  Ledger counted() const;                // now; known to the first rank; every rank takes part
  void contact(const Bridge &b, const Geometry &g, const Terms &t, double weight);
  void snapshot();                       // films, bridges, impulses, ledger, energy; every rank takes part
  void energies_in_window();             // of a step of a window; every rank takes part
  void flush();

  // Where every sphere of this rank was when the run stopped: stopped.<rank>.csv, for a look at the cause.
  void stop(const std::string &why) const;

 private:
  const SimulationState &world_;
  const Films &films_;
  BridgeList &standing_;                   // closest points at walls are remembered when they are asked for
  const EnergyBook &energy_;
  const ImpulseSums &sums_;
  std::string directory_;
  RecordFile contacts_, bridges_, wires_, events_, drops_, felt_, retired_, ledger_, film_, wall_film_, impulses_, energies_, window_energies_, states_, poses_;

  void states();
  void energies(RecordFile &file);
};

}  // namespace pywet
