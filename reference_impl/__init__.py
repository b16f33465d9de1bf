"""Independent replay of a run: liquid and forces recomputed from the logs with the papers' equations; does not need pywet."""

import os

# set before numpy is imported: the matrices of the exact bridge are too small for several threads
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
