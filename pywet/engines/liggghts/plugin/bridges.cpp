// The order of things in one step.
#include "bridges.h"

#include <algorithm>

namespace pywet {

void Bridges::step(int64_t n) {
  const bool first = now_ < 0;
  const bool again = n == now_;  // the set-up of a further run repeats the last step: forces only, nothing is booked twice
  const bool due = n % bridges_every == 0;
  now_ = n;
  const bool fresh = first || again || lists_are_new();
  if (!due && !fresh && !energy && !weighs && !laws.shed_drop && prisms.empty()) return;
  look();
  time_ = n * at_.dt;
  if (fresh) inside_the_box();
  read_mesh_motion(fresh);
  weigh(again, fresh);
  events_.clear();
  proposed_.clear();
  if (moist) begin_work();
  std::string problem;
  try {
    touch_wires(fresh, !again && logging());
    if (fresh && initial_ > 0) find_candidates();
    if (moist && (fresh || due)) {
      const double before = travel_;
      move_bounds();
      if (bridges_every > 1) travel_ = before + moved(fresh);
    }
    if (initial_ > 0 && due) {
      weight_ = bridges_every;
      set_aside();
      stand_or_rupture(!again, !again && logging());
      act_as_impulses();
    }
    if (initial_ > 0 && due && !again) {
      propose_pairs();
      propose_walls();
    }
  } catch (const std::exception &e) {
    problem = e.what();
  }
  agree(problem);
  if (semi_implicit && initial_ > 0 && due) act_at_the_end(!again && logging());
  if (again && !saved_forces_.empty()) {
    restore_forces();
    return;
  }
  if (!again && !events_.empty()) {
    book();
    act_new(first, logging());
  }
  if (moist) add_work(first, first || again);
  if (again) return;
  shed();
  if (moist && std::binary_search(output_steps.begin(), output_steps.end(), n)) snapshot();
  if (checkpoint_every > 0 && n > 0 && n % checkpoint_every == 0) save_state();
}

}  // namespace pywet
