#!python
"""The command axode, which the package brings in its folder bin. Nothing of the package is imported, so that it starts at once."""

import os
import sys
from importlib.util import find_spec

os.environ.setdefault("AXODE_PYTHON", sys.executable)
command = os.path.join(find_spec("axode").submodule_search_locations[0], "bin", "axode")
os.execv(command, ["axode", *sys.argv[1:]])
