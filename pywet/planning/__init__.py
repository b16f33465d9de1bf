"""What a scene calls for: effects and laws (`effect_plan`), time steps (`time_steps`, `step_choice`), and the plan's audit."""
