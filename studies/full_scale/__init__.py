"""Does the simulation confirm the paper's statements? Campaign at the paper's size, stored tables, statements, page."""
