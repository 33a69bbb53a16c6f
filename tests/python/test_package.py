"""What an installed package brings besides its functions."""

import subprocess
import sys
import sysconfig
from pathlib import Path

import axode
import pytest

COMMAND = Path(sysconfig.get_path("scripts")) / "axode"
WAYS = {"the command": [COMMAND], "the module": [sys.executable, "-m", "axode"]}


@pytest.mark.parametrize("way", WAYS)
def test_the_command_comes_with_the_package(way, tmp_path):
    def run(*words):
        return subprocess.run([*WAYS[way], *words], cwd=tmp_path, capture_output=True, text=True)

    assert run("--version").stdout.startswith(f"axode {axode.__version__}")
    assert "7 moving bodies" in run("info", axode.robots / "arm7.toml").stdout
    assert run("info", "none.toml").returncode == 1
    if axode.viewer.PAGE.exists():
        assert run("view", axode.robots / "arm7.toml", "--output", "page.html").returncode == 0
        assert (tmp_path / "page.html").stat().st_size > 1e5


def test_its_map_runs_in_the_environment_of_the_package(tmp_path):
    pytest.importorskip("pyarrow")
    done = subprocess.run([COMMAND, "map", "poses", axode.robots / "arm7.toml", "none.parquet", "out"], cwd=tmp_path,
                          env={"PATH": "/nowhere"}, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (1, "axode map: none.parquet: there is no such file or folder\n")
