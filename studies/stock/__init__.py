"""Bridge laws of stock programs, measured from the unmodified programs: two bodies, one gap, one force."""
