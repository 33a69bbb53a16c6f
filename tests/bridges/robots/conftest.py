"""Reads the .pth files of the environment below this one, by which Pinocchio is found; Python does not do that
itself."""

import site
import sys
from pathlib import Path

for folder in [path for path in sys.path if Path(path, "cmeel.pth").is_file()]:
    site.addsitedir(folder)
