"""The second engine: YADE, run as a program, on the same scenes as LIGGGHTS. For comparison, not for production."""
