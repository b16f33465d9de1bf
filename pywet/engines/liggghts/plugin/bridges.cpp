// The order of things in one step.
#include "bridges.h"

#include <algorithm>

namespace pywet {

void Bridges::step(int64_t n) {
  const bool first = now_ < 0;
  const bool again = n == now_;  // the set-up of a further run repeats the last step: forces only, nothing is booked twice
  now_ = n;
  look();
  time_ = n * at_.dt;
  const bool fresh = first || again || lists_are_new();
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
    if (moist) move_bounds();
    if (initial_ > 0) stand_or_rupture(!again, !again && logging());
    if (initial_ > 0 && !again) {
      propose_pairs();
      propose_walls();
    }
  } catch (const std::exception &e) {
    problem = e.what();
  }
  agree(problem);
  if (semi_implicit && initial_ > 0) act_at_the_end(!again && logging());
  if (again && !saved_forces_.empty()) {
    restore_forces();
    return;
  }
  if (moist) add_work(first, first || again);
  if (again) return;
  if (!events_.empty()) book();
  shed();
  if (moist && std::binary_search(output_steps.begin(), output_steps.end(), n)) snapshot();
  if (checkpoint_every > 0 && n > 0 && n % checkpoint_every == 0) save_state();
}

}  // namespace pywet
