"""Independent replay of a run: liquid and forces recomputed from the logs with the papers' equations; needs no pywet."""
