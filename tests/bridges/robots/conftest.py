"""Pinocchio is found by way of a .pth file, and those of the environment below are not read by themselves."""

import site
import sys
from pathlib import Path

for folder in [path for path in sys.path if Path(path, "cmeel.pth").is_file()]:
    site.addsitedir(folder)
