"""A run directory: raw files to tables, its reader, the shapes of its JSON."""
