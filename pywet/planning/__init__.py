"""Effects and laws that a scene calls for (`effect_plan`), time steps (`time_steps`, `step_choice`), and the plan's audit."""
