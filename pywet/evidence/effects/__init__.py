"""Effects study: for scenes that differ in what they need, the plan's choice against everything on and each effect off."""
