"""Files, messages, caches, compiled code, ranges of numbers and options of commands, independent of the simulation."""
