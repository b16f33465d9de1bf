"""A run replayed: its logs read in parts, liquid booked, forces recomputed, what is compared."""
