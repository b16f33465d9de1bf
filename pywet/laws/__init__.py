"""The physics of liquid bridges: one law = one plain function; `registry` finds them by name. Nothing of engines or scenes."""
