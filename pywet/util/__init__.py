"""Files, messages, caches, compiled code, ranges of numbers and options of commands; nothing of the simulation."""
