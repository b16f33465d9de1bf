"""How wet a small vibrating deck may be: a sweep over moisture and stroke, and its figure for docs/screens.md."""
