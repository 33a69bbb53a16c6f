"""Runs one peer test with pytest in the Python environment of `make build/venv/tests`: run_peer_test.py PYTHON FILE.

Exits with 77, which ctest reports as skipped, when the environment or the robots' files are missing or when
every case of the file skipped itself.
"""

import os
import subprocess
import sys
from pathlib import Path

SKIPPED = 77


def main(python, file):
    source = Path(__file__).resolve().parents[2]
    robots = Path(os.environ.setdefault("AXODE_ROBOTS", str(source / "../shared/robots")))
    if not Path(python).exists() or subprocess.run([python, "-c", "import pytest"], stderr=subprocess.DEVNULL).returncode:
        print(f"skipped: there is no Python environment for tests at {python}; `make build/venv/tests` creates it")
        return SKIPPED
    if not robots.is_dir():
        print(f"skipped: there are no robots at {robots}; set AXODE_ROBOTS to a folder of URDF files")
        return SKIPPED
    run = subprocess.run([python, "-B", "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", file],
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(run.stdout)
    summary = run.stdout.strip().splitlines()[-1]
    if run.returncode == 0 and "skipped" in summary and "passed" not in summary:
        return SKIPPED
    return run.returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
