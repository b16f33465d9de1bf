"""YADE as a second engine, run as a program, on the same scenes as LIGGGHTS. For comparison, not for production."""
