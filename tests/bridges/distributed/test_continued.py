"""Work that was interrupted continues: nothing is lost, nothing is computed twice, and no file is incomplete."""

import functools
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import axode
import numpy as np
import pytest
from axode import distributed
from axode.parallel.job_identity import digest
from mechanisms import MECHANISMS
from parquet_files import read, same, states, write

ARM = MECHANISMS["arm"]
PART = 50
PROGRAM = """
import os, signal, sys, time
import axode
import numpy as np
arm = axode.load(axode.robots / "arm7.toml")

def torques(m, q, v, a, t):
    "Ends its process at a time, or says that it is there and waits."
    for what, at in (("kill", signal.SIGKILL), ("wait", None)):
        if os.environ.get(what) and t[0] <= float(os.environ[what]) <= t[-1]:
            if at:
                os.kill(os.getpid(), at)
            print("waiting", flush=True)
            time.sleep(60)
    return {"tau": axode.inverse_dynamics(m, q, v, a), "pid": np.full(len(q), float(os.getpid()))}

if __name__ == "__main__":
    print(axode.distributed.map_states(arm, torques, "in.parquet", sys.argv[1], rows_per_part=50, threads=int(sys.argv[2])))
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with a program and a file of states."""
    (tmp_path / "program.py").write_text(PROGRAM)
    write(tmp_path / "in.parquet", ARM, states(ARM, 500), row_group_size=120)  # parts of 50, 50 and 20 rows
    return tmp_path


def start(folder, *words, **environment):
    return subprocess.Popen([sys.executable, *words], cwd=folder, env={**os.environ, **environment}, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))


def check(folder, output, pids):
    """Expects that each row is there once and in order, and that `pids` processes have computed them."""
    state = states(ARM, 500)
    assert same(read(folder / output, "tau"), axode.inverse_dynamics(ARM, state["q"], state["v"], state["a"]))
    assert same(read(folder / output, "t"), state["t"])
    assert len(set(read(folder / output, "pid"))) == pids
    left = {file.name for file in folder.iterdir()} - {"in.parquet", "program.py", output, "__pycache__"}
    assert not left
    if output == "out":
        assert all(file.name == "_axode.json" or file.name.startswith("part-") for file in (folder / output).iterdir())


@pytest.mark.parametrize("output, threads", [("out.parquet", "1"), ("out", "2")])
def test_what_a_killed_program_has_written_is_not_computed_again(output, threads, folder):
    killed = start(folder, "program.py", output, threads, kill="0.3")
    killed.communicate(timeout=60)
    assert killed.returncode == -signal.SIGKILL
    assert not (folder / "out.parquet").exists()
    parts = folder / ("out.parquet.parts" if output == "out.parquet" else "out")
    there = {file.name: file.stat().st_mtime_ns for file in parts.glob("part-*")}
    assert 6 <= len(there) < 13
    again = start(folder, "program.py", output, threads)
    printed, error = again.communicate(timeout=60)
    assert printed == f"Written(rows=500, parts=13, computed={13 - len(there)}, faulty=0)\n", error
    if output == "out":
        assert there.items() <= {file.name: file.stat().st_mtime_ns for file in parts.glob("part-*")}.items()
    check(folder, output, 2)


def test_a_program_that_is_killed_while_it_joins_the_parts_goes_on(folder):
    """The program is killed when all parts exist, but not the joined file."""
    def killed_at_the_end(done, rows):
        if done == rows:
            raise MemoryError  # stands for whatever ends it there

    map_all = {"rows_per_part": PART, "threads": 2}
    with pytest.raises(MemoryError):
        distributed.map_states(ARM, "inverse_dynamics", folder / "in.parquet", folder / "out.parquet",
                               progress=killed_at_the_end, **map_all)
    assert not (folder / "out.parquet").exists()
    (folder / "out.parquet.parts/.part-000003.arrow.0").write_text("of a process that was killed")
    written = distributed.map_states(ARM, "inverse_dynamics", folder / "in.parquet", folder / "out.parquet", **map_all)
    assert written.computed == 0 and sorted(file.name for file in folder.iterdir()) == ["in.parquet", "out.parquet", "program.py"]


def test_ctrl_c_ends_it_and_it_goes_on(folder):
    ended = start(folder, "program.py", "out.parquet", "1", wait="0.3")
    assert ended.stdout.readline() == "waiting\n"
    time.sleep(0.2)
    ended.send_signal(signal.SIGINT)
    _, error = ended.communicate(timeout=30)
    assert error.rstrip().endswith("KeyboardInterrupt")
    assert not (folder / "out.parquet").exists()
    again = start(folder, "program.py", "out.parquet", "1")
    assert "rows=500" in again.communicate(timeout=60)[0]
    check(folder, "out.parquet", 2)


def test_ctrl_c_ends_the_command_with_a_sentence(folder):
    state = {name: np.resize(x, (60_000, *x.shape[1:])) for name, x in states(ARM, 100).items()}
    write(folder / "many.parquet", ARM, state)
    words = ("-m", "axode", "map", "inverse_dynamics_second_derivatives", str(axode.robots / "arm7.toml"), "many.parquet", "out")
    ended = start(folder, *words)
    for _ in range(600):
        if list(folder.glob("out/.part-*")):
            break
        time.sleep(0.05)
    ended.send_signal(signal.SIGINT)
    _, error = ended.communicate(timeout=60)
    assert (ended.returncode, error) == (130, "axode map: interrupted; the same command continues from there\n")
    assert not list(folder.glob("out/.part-*"))


def test_a_job_is_continued_by_the_same_call_only(folder):
    def ended(done, rows):
        if done > 100:
            raise RuntimeError("ended")

    def call(function="inverse_dynamics", m=ARM, states="in.parquet", **options):
        return distributed.map_states(m, function, folder / states, folder / "out", **{"rows_per_part": PART, **options})

    with pytest.raises(RuntimeError, match="ended"):
        call(progress=ended, threads=1)
    heavier = ARM.with_parameters(1.1 * ARM.parameters)
    write(folder / "other.parquet", ARM, states(ARM, 500, 1))
    for options, what in (({"function": "coriolis_vector"}, "function"), ({"m": heavier}, "model"), ({"keep": []}, "arguments"),
                          ({"rows_per_part": 51}, "rows_per_part"), ({"states": "other.parquet"}, "states"),
                          ({"arguments": {"joint_losses": True}}, "arguments"), ({"dtype": "float32"}, "arguments")):
        with pytest.raises(FileExistsError, match=f"out holds parts of another job: {what} differs"):
            call(**options)
    twin = axode.load(axode.robots / "arm7.toml")
    written = call(m=twin)
    assert written.parts - written.computed == 3
    assert call("coriolis_vector", overwrite=True).computed == 13


class Scaled:
    """A callable object."""

    def __init__(self, factor):
        self.factor = factor

    def __call__(self, m, q):
        return self.factor * q


class Shifted(Scaled):
    def __call__(self, m, q):
        return self.factor + q


def scaled(m, q, factor=1.0):
    return factor * q


def scaled_by(factor):
    return lambda m, q: factor * q


def repeated(factor):
    """A function that calls itself."""
    def again(m, q, more=True):
        return again(m, factor * q, False) if more else q

    return again


def without_text(expression):
    """A function whose source Python cannot find."""
    return eval(f"lambda m, q: {expression}")


FUNCTIONS = {
    "a partial": (lambda factor: functools.partial(scaled, factor=factor), 2.0, 3.0),
    "an object": (Scaled, 2.0, 3.0),
    "a method": (lambda factor: Scaled(factor).__call__, 2.0, 3.0),
    "a class": (lambda kind: kind(2.0), Scaled, Shifted),
    "a variable of an enclosing function": (scaled_by, 2.0, 3.0),
    "a function that calls itself": (repeated, 2.0, 3.0),
    "an array in a variable": (scaled_by, np.arange(7.0), np.arange(1.0, 8.0)),
    "a function without text": (without_text, "2 * q", "3 * q"),
    "a set of words": (without_text, "q if 'a' in {'a', 'b', 'c'} else -q", "q if 'a' in {'a', 'b', 'd'} else -q"),
    "a function within": (lambda g: functools.partial(lambda g, m, q: g(q), g), np.sin, np.cos),
}


@pytest.mark.parametrize("make, value, other", FUNCTIONS.values(), ids=FUNCTIONS)
@pytest.mark.parametrize("kind", ["map_states", "sweep"])
def test_a_job_is_continued_with_the_values_and_the_code_of_its_function_only(kind, make, value, other, folder):
    def ended(done, rows):
        if done > 100:
            raise RuntimeError("ended")

    def call(function, **options):
        if kind == "map_states":
            return distributed.map_states(ARM, function, folder / "in.parquet", folder / "out", rows_per_part=PART, **options)
        of_point = functools.partial(lambda f, m, k: {"x": np.asarray(f(m, np.full(7, float(k))))}, function)
        return distributed.sweep(ARM, of_point, {"k": range(260)}, folder / "out", points_per_part=20, **options)

    with pytest.raises(RuntimeError, match="ended"):
        call(make(value), progress=ended)
    with pytest.raises(FileExistsError, match="out holds parts of another job: function differs; overwrite=True"):
        call(make(other))
    written = call(make(value))
    assert 0 < written.computed < written.parts == 13


def test_overwriting_computes_everything_anew(folder):
    def ended(done, rows):
        if done > 100:
            raise RuntimeError("ended")

    def call(**options):
        return distributed.map_states(ARM, "poses", folder / "in.parquet", folder / "out", rows_per_part=PART, **options)

    with pytest.raises(RuntimeError, match="ended"):
        call(progress=ended, threads=1)
    assert call(overwrite=True).computed == 13


def test_a_function_that_cannot_be_compared_is_computed_but_not_continued(folder):
    held = functools.partial(lambda lock, m, q: q, threading.Lock())

    def ended(done, rows):
        if done > 100:
            raise RuntimeError("ended")

    def call(**options):
        return distributed.map_states(ARM, held, folder / "in.parquet", folder / "out", rows_per_part=PART, **options)

    with pytest.raises(RuntimeError, match="ended"):
        call(progress=ended)
    with pytest.raises(FileExistsError, match="cannot be compared with this one: function holds an object of _thread.lock.*"
                       "overwrite=True starts it again"):
        call()
    assert call(overwrite=True).computed == 13


def test_a_job_is_known_in_another_process_whatever_the_order_of_its_sets(tmp_path):
    program = tmp_path / "program.py"
    program.write_text("""
import functools
from axode.parallel.job_identity import digest
def member(words, m, q, among=frozenset("abcdefgh")): return q in {"p", "q", "r", "s"} and words
print(digest(functools.partial(member, {"one", "two", "three", "four"})))
""")
    printed = {subprocess.run([sys.executable, program], env={**os.environ, "PYTHONHASHSEED": seed}, text=True, check=True,
                              capture_output=True).stdout for seed in "123"}
    assert len(printed) == 1


def test_a_job_does_not_depend_on_what_python_shares():
    word, pair, array = "ab", ("ab", 1), np.arange(6.0).reshape(2, 3)
    assert digest([word, word, array]) == digest([word, "".join("ab"), np.asfortranarray(array)])
    assert digest([pair, pair]) == digest([pair, tuple(["ab", 1])])
    assert len({digest(x) for x in ("a", b"a", ["a"], ("a",), {"a"}, frozenset("a"), {"a": 1}, array, array.ravel())}) == 9


def test_a_program_that_is_killed_while_it_begins_leaves_nothing_in_the_way(folder):
    (folder / "out").mkdir()
    (folder / "out/._axode.json.0").write_text("half of")
    distributed.map_states(ARM, "poses", folder / "in.parquet", folder / "out")
    manifest = folder / "out/_axode.json"
    manifest.write_text("{}")  # as while another job is cleared away
    with pytest.raises(FileExistsError, match="holds parts of another job"):
        distributed.map_states(ARM, "poses", folder / "in.parquet", folder / "out")
    assert distributed.map_states(ARM, "poses", folder / "in.parquet", folder / "out", overwrite=True).computed == 5
    assert sorted(file.name for file in (folder / "out").iterdir()) == ["_axode.json", *(f"part-{k:06}.parquet" for k in range(5))]


def test_two_processes_do_not_work_on_the_same_output(folder):
    def at_work(done, rows):
        with pytest.raises(FileExistsError, match="out: another process is writing to it"):
            distributed.map_states(ARM, "poses", folder / "in.parquet", folder / "out", overwrite=True)

    distributed.map_states(ARM, "poses", folder / "in.parquet", folder / "out", progress=at_work)
    assert len(read(folder / "out", "poses")) == 500


def test_a_function_that_fails_leaves_what_is_whole(folder):
    state = states(ARM, 500)
    good = Path(folder / "good")

    def torques(m, q, v, a, t):
        if t[-1] > 0.2 and not good.exists():
            raise ArithmeticError("not yet")
        return axode.inverse_dynamics(m, q, v, a)

    def call(threads):
        return distributed.map_states(ARM, torques, folder / "in.parquet", folder / "out.parquet", rows_per_part=PART,
                                      threads=threads)

    with pytest.raises(RuntimeError, match=r"torques of .*in.parquet, rows 170 to 219: ArithmeticError: not yet"):
        call(1)
    assert not (folder / "out.parquet").exists()
    assert len(list((folder / "out.parquet.parts").glob("part-*.arrow"))) == 4
    good.touch()
    assert call(3).computed == 9
    assert same(read(folder / "out.parquet", "torques"), axode.inverse_dynamics(ARM, state["q"], state["v"], state["a"]))


def test_progress_is_told_row_by_row_and_shown_by_a_bar(folder, capfd):
    told = []
    distributed.map_states(ARM, "poses", folder / "in.parquet", folder / "a.parquet", rows_per_part=PART, threads=1,
                           progress=lambda done, rows: told.append((done, rows)))
    assert told[0] == (50, 500) and told[-1] == (500, 500) and len(told) == 13
    assert capfd.readouterr() == ("", "")
    distributed.map_states(ARM, "poses", folder / "in.parquet", folder / "b.parquet", progress=True)
    out, error = capfd.readouterr()
    assert out == "" and "500/500" in error
