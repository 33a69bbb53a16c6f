"""Tests of the bridges to other people's packages, each in an environment of its own: see tools/run_all_tests.py."""

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Libraries that these tests compile do not go into the cache of the user.
_CACHE = tempfile.TemporaryDirectory(prefix="axode-")
os.environ["XDG_CACHE_HOME"] = _CACHE.name

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
