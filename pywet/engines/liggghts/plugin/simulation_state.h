// State that every component of the plugin may read: the scene, the present step, the engine. Only the order of a step (step.cpp), the
// set-up (plugin.cpp) and a resumption (checkpoint.cpp) change it.
#pragma once
#include "communicator.h"
#include "engine.h"
#include "insertion.h"
#include "laws.h"
#include "settings.h"
#include "spheres.h"
#include "step_schedule.h"
#include "walls.h"

namespace pywet {

struct SimulationState {
  Settings rules;
  StepSchedule clock;
  Communicator ranks;
  Spheres spheres;
  Insertion feed;
  Walls walls;
  Laws laws;
  TransferTables transfer;
  Engine engine;
};

}  // namespace pywet
