"""Independent replay of a run: recomputes liquid and forces from the logs with the papers' equations. Imports nothing of pywet."""
