"""What the rows of axode.table say, against what the functions of the package, specialised models and generated code do."""

import inspect
import re

import numpy as np
import pytest

import axode
from axode.table import ROWS

LOOPS = ["four_bar.toml", "slider_crank.toml", "bricard.toml", "gough.toml", "leg.toml", "governor.toml"]


def mechanism(file):
    return axode.load(axode.robots / file)


def cut(m):
    """The mechanism without its loops and couplings."""
    return axode.Model.from_dict({key: value for key, value in m.to_dict().items() if key not in ("loop", "coupling")})


def arguments(m, row, seed=1):
    """One state: closed, moving as the loops allow, with accelerations that they allow under any forces."""
    rng = np.random.default_rng(seed)
    q, _ = axode.assemble(m, m.neutral())
    A = axode.loop_jacobian(m, q)
    v = rng.normal(size=m.nv)
    v -= np.linalg.lstsq(A, A @ v, rcond=1e-9)[0]
    tau = np.zeros(m.nv)
    values = {"q": q, "v": v, "a": axode.forward_dynamics(m, q, v, tau), "tau": tau, "p": axode.momenta(m, q, v)}
    values |= {name: rng.normal(size=m.nv) for name in ("dq", "dv", "da", "dtau", "w")}
    given = {name: values[name] for name in row.arrays}
    if "frame" in row.takes:
        given["frame"] = m.n_frames - 1
    return given


def call(m, row, given):
    function = getattr(axode, row.name)
    if row.name != "relative_jacobian":
        return function(m, **given)
    names = list(inspect.signature(function).parameters)
    return function(m, **given, **{names[names.index("frame") + 1]: 0})


def numbers(result):
    return [np.asarray(x) for x in result] if isinstance(result, tuple) else [np.asarray(result)]


def test_every_row_is_a_function():
    assert [name for name in ROWS if not callable(getattr(axode, name, None))] == []


@pytest.mark.parametrize("file", LOOPS)
@pytest.mark.parametrize("name", [name for name in ROWS if "loads" not in ROWS[name].symbols and name != "load_powers"])
def test_loops_are_counted_or_refused_as_the_row_says(file, name):
    m, row = mechanism(file), ROWS[name]
    word, sentence = row.counts["loops"]
    given = arguments(m, row)
    if word == "refused":
        with pytest.raises(ValueError, match=re.escape(sentence)):
            call(m, row, given)
        return
    found = numbers(call(m, row, given))
    if word == "of_the_tree":
        expected = numbers(call(cut(m), row, given))
        assert all(np.array_equal(x, y, equal_nan=True) for x, y in zip(found, expected, strict=True))
    else:
        assert word == "counted"
        many = numbers(call(m, row, {key: np.stack([x, x]) if isinstance(x, np.ndarray) else x for key, x in given.items()}))
        assert all(np.array_equal(x, y[1], equal_nan=True) for x, y in zip(found, many, strict=True))


@pytest.mark.parametrize("name", [name for name in ROWS if ROWS[name].recorded and "frame" not in ROWS[name].takes])
def test_generated_and_specialised_code_refuse_what_depends_on_loops(name):
    m, row = mechanism("four_bar.toml"), ROWS[name]
    if row.counts["loops"][0] == "of_the_tree":
        axode.codegen.c_source(m, [name])
        return
    for make in (axode.codegen.c_source, type(m).specialise):
        with pytest.raises(ValueError, match=f'{name} does not count loops, and model "four-bar" has 1; '):
            make(m, [name])


def test_docstrings_say_what_is_counted():
    for name, row in ROWS.items():
        doc = getattr(axode, name).__doc__
        for word, phrase in (("counted", "ounts "), ("refused", "efuses ")):
            counted = [column for column in row.counts if row.counts[column][0] == word]
            assert all(re.search(f"{phrase}[^;]*{column}", doc) for column in counted), name
