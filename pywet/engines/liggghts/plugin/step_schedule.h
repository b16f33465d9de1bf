// The present step and the schedule of the run, which is fixed before it starts.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace pywet {

class StepSchedule {
 public:
  std::vector<int64_t> output_steps, window_first, window_last;
  int64_t checkpoint_every = 0;         // interval of checkpoints [steps]; 0: none
  int64_t drop_every = 0;               // interval between two evaluations of shedding [steps]
  int64_t output_every = 0, output_from = 0;  // interval and first step of outputs in a run of unknown length, in place of output_steps
  int64_t window_steps = 0;             // in such a run: number of steps after each output in which contacts are logged
  int bridges_every = 1;                // interval between two evaluations of the bridges [steps]

  int64_t now = -1;
  double time = 0;
  bool first = false;                   // whether this is the first step of the run
  bool again = false;                   // the set-up of a further run repeats the last step: forces are evaluated, events are not applied again

  void go(int64_t step) {
    first = now < 0;
    again = step == now;
    now = step;
  }
  bool bridges_act() const { return now % bridges_every == 0; }
  bool drops_fall() const { return !again && now % drop_every == 0; }
  bool logs_contacts() const {
    if (output_every > 0) return !again && (now - output_from) % output_every < window_steps;
    for (size_t k = 0; k < window_first.size() && !again; k++)
      if (now >= window_first[k] && now < window_last[k]) return true;
    return false;
  }
  bool output() const {
    if (output_every > 0) return !again && (now - output_from) % output_every == 0;
    return !again && std::binary_search(output_steps.begin(), output_steps.end(), now);
  }
  bool checkpoint() const { return !again && checkpoint_every > 0 && now > 0 && now % checkpoint_every == 0; }
};

}  // namespace pywet
