#include "step.h"

#include <algorithm>

namespace pywet {

void Plugin::attach(LAMMPS_NS::LAMMPS *lmp, const std::string &directory) {
  const std::vector<double> &radii = world.spheres.type_radius;
  world.ranks.join(processes(lmp));
  const double least = radii.empty() ? world.engine.skin : *std::min_element(radii.begin(), radii.end());
  world.walls.finish(0.05 * least);
  world.rules.touches_faces = world.rules.touches_faces && world.engine.leaves_faces();
  world.engine.attach(lmp, world.walls, world.rules.touches_faces || !wires.parts.empty());
  world.engine.look();
  world.walls.images = world.engine.at.images;
  films.begin();
  turnover.begin();
  faces.arrange();
  wires.arrange();
  weight.begin();
  // With the engine's own contacts its own movers act too, so that both are compared with it.
  if (world.rules.batched) world.engine.move_meshes_together();
  world.rules.batched = world.rules.batched && deletes_springs() && world.engine.contacts_in_batches();
  logs.open(directory);
}

void Plugin::resume(const std::string &state_file) {
  checkpoint.resume(state_file);
  weight.begin();
}

// Dry contacts with walls, bridge forces, formations and ruptures.
void Plugin::act(bool fresh) {
  const StepSchedule &clock = world.clock;
  const bool bridges_act = clock.bridges_act();
  faces.touch(fresh);
  wires.touch(fresh);
  if (fresh && wet()) {
    films.mark();
    standing.sort();
    near.find();
  }
  if (fresh && deletes_springs()) world.engine.shorten_lists();
  if (world.rules.moist && (fresh || bridges_act)) near.move_on(impulses.on() ? impulses.moved(fresh) : INF);
  if (!wet() || !bridges_act) return;
  forces.act(ledger.events);
  if (!clock.again) near.propose(ledger.events);
}

void Plugin::step(int64_t n) {
  StepSchedule &clock = world.clock;
  Engine &engine = world.engine;
  const Settings &rules = world.rules;
  clock.go(n);
  const bool fresh = clock.first || clock.again || engine.lists_are_new(n);
  const bool feeding = n < world.feed.last;
  engine.look();
  if (!fresh && deletes_springs()) engine.forget_springs();
  if (!clock.bridges_act() && !fresh && !rules.energy && !rules.weighs && !world.laws.shed_drop && !touches_walls() && !feeding)
    return;
  if (clock.first || clock.again) engine.keep_skin();
  if (rules.scripted && fresh) turnover.look();
  if (fresh && !world.ranks.alone()) {
    engine.find_neighbours(world.ranks);
    engine.update_ghosts();
  }
  clock.time = n * engine.at.dt;
  if (fresh && !rules.scripted) engine.check_box(world.spheres, world.ranks, n);
  energy.begin(engine.read_meshes(world.walls, world.ranks, fresh, clock.again));
  weight.weigh(fresh);
  world.feed.hold(engine.at, rules, n);
  ledger.events.clear();
  sums.begin();
  if (fresh && wet()) standing.exchange();
  std::string problem;
  try {
    act(fresh);
  } catch (const std::exception &e) {
    problem = e.what();
  }
  ledger.gather(problem);
  if (rules.semi_implicit && wet() && clock.bridges_act()) implicit.act();
  if (clock.again && checkpoint.restore_forces()) return;
  if (ledger.any) {
    ledger.apply_events();
    forces.act_new(ledger.events);
  }
  energy.add_up();
  shedding.shed();
  retirement.retire();
  if (rules.scripted) turnover.apply_events();
  if (rules.moist && clock.output()) logs.snapshot();
  if (rules.scripted && !clock.again && (ledger.any || clock.output() || clock.logs_contacts())) logs.poses();
  if (clock.logs_contacts()) logs.energies_in_window();
  if (clock.checkpoint()) checkpoint.save();
}

void Plugin::create() { world.engine.create(world.feed.due(world.clock.now), world.spheres, world.ranks, world.clock.time); }

}  // namespace pywet
