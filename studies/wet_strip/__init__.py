"""Largest moisture of a small vibrating deck: a sweep over moisture and stroke, and its figure for docs/screens.md."""
