"""The rows of axode.table describe correctly the functions of the package, of specialised models and of generated
code."""

import json
import re
import subprocess
import sysconfig
from pathlib import Path

import axode
import numpy as np
import pytest
from axode.table import ROWS
from calls import given_to, in_one, tool
from mechanisms import MECHANISMS, REPRESENTATIONS, random_states
from properties import TREE, WITH, numbers, state

LOOPS = ["four_bar.toml", "slider_crank.toml", "bricard.toml", "gough.toml", "leg.toml", "governor.toml"]


def mechanism(file):
    return axode.load(axode.robots / file)


def cut(m):
    """The mechanism without its loops and couplings."""
    return axode.Model.from_dict({key: value for key, value in m.to_dict().items() if key not in ("loop", "coupling")})


# The column of the table, a mechanism with that property, and the mechanism without it.
CASES = {file: ("loops", mechanism(file), cut(mechanism(file))) for file in LOOPS}
CASES |= {case: (column, m, TREE) for case, (column, m) in WITH.items()}


def call(m, row, given):
    return getattr(axode, row.name)(m, **given)


def test_every_row_is_a_function():
    assert [name for name in ROWS if not callable(getattr(axode, name, None))] == []


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", [name for name in ROWS if "loads" not in ROWS[name].symbols and name != "load_powers"])
def test_each_property_is_counted_refused_or_left_out_as_the_row_says(case, name):
    row = ROWS[name]
    column, m, without = CASES[case]
    word, sentence = row.counts[column]
    given = state(m, row)
    if word == "refused":
        with pytest.raises(ValueError, match=f"{name} does not count.*{re.escape(sentence)}"):
            call(m, row, given)
        return
    found = numbers(call(m, row, given))
    # Joint losses and passive joints count if that is asked for.
    if word in ("of_the_tree", "optional", "partly"):
        expected = numbers(call(without, row, given))
        assert all(np.array_equal(x, y, equal_nan=True) for x, y in zip(found, expected, strict=True))
    else:
        assert word == "counted"
        many = numbers(call(m, row, {key: np.stack([x, x]) if isinstance(x, np.ndarray) else x for key, x in given.items()}))
        assert all(np.array_equal(x, y[1], equal_nan=True) for x, y in zip(found, many, strict=True))


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", [name for name in ROWS if ROWS[name].recorded and "frame" not in ROWS[name].takes])
def test_generated_and_specialised_code_is_that_of_the_tree_or_refused(case, name):
    row = ROWS[name]
    column, m, tree = CASES[case]
    if row.counts[column][0] in ("of_the_tree", "optional", "partly"):
        for abi in ("plain", "cuda"):
            assert axode.codegen.c_source(m, [name], abi=abi).text == axode.codegen.c_source(tree, [name], abi=abi).text
        return
    for make in (axode.codegen.c_source, type(m).specialise):
        with pytest.raises(ValueError, match=f'{name} does not count {column}, and model "{m.name}" has \\d+; '):
            make(m, [name])


def test_docstrings_say_what_is_counted():
    for name, row in ROWS.items():
        doc = getattr(axode, name).__doc__
        for word, phrase in (("counted", "ounts "), ("refused", "efuses ")):
            counted = [column for column in row.counts if row.counts[column][0] == word]
            # A part of the line, with sentences in brackets.
            within = r"(?:[^;()]|\((?:[^()]|\([^()]*\))*\))*"
            assert all(re.search(f"{phrase}{within}{column}", doc) for column in counted), name


COMMAND = Path(sysconfig.get_path("scripts")) / "axode"


def told(file, state, names, *words):
    """The results that the command prints, by name."""
    done = subprocess.run([COMMAND, "eval", axode.robots / file, "--state", "-", "--want", ",".join(names), "--format",
                           "json", *words], input=json.dumps(state), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["results"]


def in_order(value):
    """A value of JSON as an array; the entries of an object keep their order."""
    value = list(value.values()) if isinstance(value, dict) else value
    return np.array([in_order(x) for x in value]) if isinstance(value, list) else value


def as_in_python(name, value):
    """The array of a printed result, in the shape that the docstring says."""
    if name == "joint_screws":  # by joint there, columns here
        return np.concatenate([in_order(screws) for screws in value.values()]).T
    if name == "centroidal_inertia":
        xx, yy, zz, xy, xz, yz = value["inertia"]
        I = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
        return np.block([[np.array(I), np.zeros((3, 3))], [np.zeros((3, 3)), value["mass"] * np.eye(3)]])
    if name.startswith("momentum_form"):
        value = {key: x for key, x in value.items() if key != "p"}  # of the state
    array = in_order(value)
    array = array[0] if "frame" in ROWS[name].takes else array
    return array.T if name == "impulse_response" else array


@pytest.mark.parametrize("representation", REPRESENTATIONS)
@pytest.mark.parametrize("file", ["arm7.toml", "machine.toml"])
def test_arrays_are_the_numbers_that_the_command_prints_to_the_last_bit(file, representation):
    m = mechanism(file)
    q, v, a, _ = (x[0] for x in random_states(m, 1, seed=2))
    loads = [axode.Load(frame=tool(m), representation="hybrid", wrench=[1, 2, 3, 4, 5, 6])]
    state = {"loads": [dict(loads[0])]}
    # No frame of the machine moves in every direction.
    left_out = ["operational_space_inertia"] if file == "machine.toml" else []
    compared = 0
    for with_frame in (False, True):
        rows = [row for name, row in ROWS.items() if ("frame" in row.takes) == with_frame and name not in left_out]
        given = {row.name: given_to(row, m, q, v, a) for row in rows}
        for one in given.values():
            one.pop("joint_losses", None)
            one |= {"loads": loads} if "loads" in one else {}
            state |= {key: x.tolist() for key, x in one.items() if isinstance(x, np.ndarray)}
        words = ["--frame", tool(m), "--relative-to", m.frame_names[1]] if with_frame else []
        printed = told(file, state, list(given), "--representation", representation, *words)
        for row in rows:
            choice = {} if row.choice == "none" else {"representation": representation}
            found = np.asarray(in_one(call(m, row, given[row.name] | choice), q))
            expected = as_in_python(row.name, printed[row.name])
            assert found.shape == np.shape(expected) and np.array_equal(found, expected), row.name
            assert row.name in ("joint_screws", "load_powers", "centroidal_inertia", "pose", "poses") or (
                found.size == np.prod(row.item(m))), row.name
            compared += 1
    assert compared == len(ROWS) - len(left_out)


WRONG = {"short": lambda x: x[..., :-1], "nan": lambda x: np.where(np.arange(x.shape[-1]) == 1, np.nan, x),
         "deep": lambda x: x[None], "complex": lambda x: x + 0j, "of another number": lambda x: x[:2]}


@pytest.mark.parametrize("name", ROWS)
def test_every_array_is_refused_by_its_name(name):
    m, row = MECHANISMS["machine"], ROWS[name]
    q, v, a, _ = random_states(m, 3)
    given = given_to(row, m, q, v, a)
    for argument in row.arrays:
        for kind, make in WRONG.items():
            if (argument, kind) == ("q", "of another number"):  # then the others are
                continue
            with pytest.raises(ValueError, match=rf"^{argument}\b"):
                call(m, row, given | {argument: make(given[argument])})
    for setting in {"frame", "base"} & set(row.takes):
        with pytest.raises(KeyError, match='has no frame "flang"'):
            call(m, row, given | {setting: "flang"})
    if "loads" in row.takes:
        with pytest.raises(ValueError, match=r"^loads\[0\].wrench: expected shape"):
            call(m, row, given | {"loads": [axode.Load(frame=0, wrench=np.zeros(5))]})
