"""Newton's law in the recorded windows: motion, contacts, walls, weights."""
