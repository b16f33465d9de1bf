"""Before numpy is imported: its matrices here are too small to share among threads, which on busy cores wait for each other."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
