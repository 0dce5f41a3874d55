"""Attune: talk to a household robot, interrupt it at any moment, and be understood."""

import os

__version__ = "0.1.0"

# Attune's matrices are small: on several threads they wait for each other, on a busy machine twenty times as long as
# they compute. This is for numpy, where it is imported later; torch has a setting of its own.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
