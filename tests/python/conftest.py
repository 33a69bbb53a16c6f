"""Adds tests/peers to the path, with robots in other libraries that use the conventions of axode."""

import os
import sys
import tempfile
from pathlib import Path

import pytest

# Threads of BLAS wait for each other in a loop: with other work
# on the cores the small matrices here take 15 times as long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Libraries that these tests compile do not go into the cache of the user.
_CACHE = tempfile.TemporaryDirectory(prefix="axode-")
os.environ["XDG_CACHE_HOME"] = _CACHE.name

TESTS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTS / "peers"))
ROBOTS = Path(os.environ.get("AXODE_ROBOTS") or TESTS.parent.parent / "shared/robots")


def pytest_generate_tests(metafunc):
    """`robot` is every URDF, or one skipped parameter that says why there is none; `base` is fixed and free."""
    if "robot" in metafunc.fixturenames:
        reason = f"there are no URDF files in {ROBOTS}; set AXODE_ROBOTS"
        none = pytest.param(None, id="none", marks=pytest.mark.skip(reason=reason))
        files = [pytest.param(file, id=file.stem) for file in sorted(ROBOTS.glob("*.urdf"))]
        metafunc.parametrize("robot", files or [none])
    if "base" in metafunc.fixturenames:
        metafunc.parametrize("base", ["fixed", "free"])
