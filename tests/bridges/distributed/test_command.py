"""`axode map` in the shell, and its documentation page, docstrings and example."""

import doctest
import os
import re
import subprocess
import sys
from pathlib import Path

import axode
import numpy as np
import pytest
from axode import distributed
from mechanisms import MECHANISMS
from pages import SOURCE, run_page
from parquet_files import read, same, states, write

ARM, HUMANOID = MECHANISMS["arm"], MECHANISMS["humanoid"]
COMMAND = SOURCE / "build/release/axode"
WAYS = {"python": [sys.executable, "-m", "axode"], "command": [str(COMMAND)]}


@pytest.fixture(params=WAYS)
def axode_on_the_shell(request, tmp_path):
    if request.param == "command" and not COMMAND.exists():
        pytest.skip("there is no build/release/axode; `make build` builds it")

    def call(*words, **environment):
        done = subprocess.run([*WAYS[request.param], *map(str, words)], cwd=tmp_path, capture_output=True, text=True,
                              env={**os.environ, "AXODE_PYTHON": sys.executable, **environment})
        return done.returncode, done.stdout, done.stderr

    return call


def test_it_maps_a_file_to_a_file(axode_on_the_shell, tmp_path):
    state = states(HUMANOID, 200)
    state["q"][17] = np.nan
    write(tmp_path / "in.parquet", HUMANOID, state, "coordinates")
    words = ("map", "mass_matrix", axode.robots / "humanoid.urdf", "in.parquet", "out.parquet", "--base", "free")
    code, out, error = axode_on_the_shell(*words)
    assert (code, out) == (1, "") and error.endswith("in.parquet: row 17: q has nan in it; expected finite numbers\n")
    assert error.count("axode map: ") == 1
    code, out, error = axode_on_the_shell(*words, "--faulty", "nan", "--float", "--set", "representation=body", "--keep", "none",
                                          "--threads", "2")
    assert (code, out) == (0, "out.parquet: mass_matrix of 200 states, 1 of them NaN\n"), error
    good = np.arange(200) != 17
    direct = axode.mass_matrix(HUMANOID, state["q"][good], "body").astype(np.float32)
    assert same(read(tmp_path / "out.parquet", "mass_matrix")[good], direct)
    code, out, error = axode_on_the_shell(*words)
    assert code == 1 and "axode map: out.parquet exists; --overwrite replaces it\n" in error


@pytest.mark.parametrize("words, code, sentence", [
    (["inverse_dynamcs", "{arm}", "in.parquet", "out"], 2, 'axode map: there is no function of states "inverse_dynamcs"; did'),
    (["jacobian", "{arm}", "in.parquet", "out"], 2, "axode map: jacobian needs an argument 'frame'"),
    (["jacobian", "{arm}", "in.parquet", "out", "--set", "frame=flang"], 2, 'did you mean "flange"?'),
    (["jacobian", "{arm}", "in.parquet", "out", "--set", "flange"], 2, '"flange" is not NAME=VALUE'),
    (["poses", "no.toml", "in.parquet", "out"], 1, "no.toml"),
    (["poses", "{arm}", "none.parquet", "out"], 1, "axode map: none.parquet: there is no such file or folder"),
    (["poses", "{arm}", "in.parquet"], 2, "axode map: "),
    (["poses", "{arm}", "in.parquet", "out", "--threads", "many"], 2, "axode map: "),
    (["poses", "{arm}", "in.parquet", "out", "--base", "fre"], 2, "fre"),
])
def test_what_is_wrong_is_said_in_a_sentence(axode_on_the_shell, words, code, sentence, tmp_path):
    write(tmp_path / "in.parquet", ARM, states(ARM, 5))
    found, out, error = axode_on_the_shell("map", *(word.format(arm=axode.robots / "arm7.toml") for word in words))
    assert (found, out) == (code, "") and sentence in error and "Traceback" not in error
    assert not (tmp_path / "out").exists()


def test_the_command_has_the_options_of_the_program():
    if not COMMAND.exists():
        pytest.skip("there is no build/release/axode; `make build` builds it")
    options = []
    for way in WAYS.values():
        shown = subprocess.run([*way, "map", "--help"], capture_output=True, text=True, check=True).stdout
        assert "axode map inverse_dynamics humanoid.urdf states.parquet tau.parquet --base free" in shown
        options.append(set(re.findall(r"--\w+", shown.partition("Example:")[0])))
    assert options[0] == options[1] and "--overwrite" in options[0]


def test_it_does_not_take_modules_of_the_working_folder(tmp_path):
    if not COMMAND.exists():
        pytest.skip("there is no build/release/axode; `make build` builds it")
    (tmp_path / "json.py").write_text("raise SystemExit('taken from the working folder')")
    done = subprocess.run([COMMAND, "map", "poses", "a", "b", "c"], cwd=tmp_path, capture_output=True, text=True,
                          env={**os.environ, "AXODE_PYTHON": sys.executable})
    assert "taken from" not in done.stderr


@pytest.mark.parametrize("name", distributed.__all__)
def test_every_docstring_has_an_example_that_runs(name):
    names = {"np": np, "axode": axode, "arm": ARM}
    test = doctest.DocTestParser().get_doctest(getattr(distributed, name).__doc__, names, name, None, None)
    assert test.examples
    printed = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test, out=printed.append)
    assert not printed, "".join(printed)


def test_what_the_page_shows_is_what_happens(tmp_path, monkeypatch):
    if not COMMAND.exists():
        pytest.skip("there is no build/release/axode; `make build` builds it")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    run_page("docs/distributed.md", {**os.environ, "PATH": f"{COMMAND.parent}:{os.environ['PATH']}",
                                     "AXODE_PYTHON": sys.executable})


def test_the_example_finds_the_arms_whose_drives_are_too_weak(tmp_path):
    example = SOURCE / "examples/python/13_monte_carlo.py"
    done = subprocess.run([sys.executable, example], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert done.stdout.startswith("1000 arms of 2")
    text = example.read_text(encoding="utf-8").partition("cluster = ")[0]
    names = {"__name__": "example"}
    exec(compile(text, str(example), "exec"), names)
    peaks = np.array([names["peaks"](names["arm"], seed)["peak"] for seed in range(1000)])
    weak = (peaks > names["arm"].effort_limits).any(axis=1).mean()
    assert 0 < weak < 0.1 and f"arms with a drive that is too weak: {weak:.1%}" in done.stdout
    assert f"{np.median(peaks[:, 1]):.2f}" in done.stdout


def test_without_ray_the_same_call_runs_in_one_process(tmp_path):
    (tmp_path / "ray.py").write_text("raise ImportError('none here')")
    write(tmp_path / "in.parquet", ARM, states(ARM, 50))
    program = """
import axode
arm = axode.load(axode.robots / "arm7.toml")
print(axode.distributed.map_states(arm, "poses", "in.parquet", "out.parquet").rows)
try: axode.distributed.map_states(arm, "poses", "in.parquet", "more.parquet", cluster="local")
except ImportError as error: print(error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path,
                          env={**{k: x for k, x in os.environ.items() if k != "RAY_ADDRESS"}, "PYTHONPATH": str(tmp_path)})
    assert done.stdout == "50\ncluster is 'local', which needs Ray: pip install ray\n", done.stderr
    assert not (Path(tmp_path) / "more.parquet").exists()
