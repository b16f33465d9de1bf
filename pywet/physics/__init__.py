"""What two bodies and a liquid do to each other."""
