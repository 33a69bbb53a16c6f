"""Sweeps and Monte Carlo studies give one row for each point, in one process and on a cluster."""

import axode
import numpy as np
import pyarrow.parquet as pq
import pytest
from axode import distributed
from mechanisms import MECHANISMS
from parquet_files import read, same

ARM = MECHANISMS["arm"]


def variant(m, seed):
    """The peak torques of an arm with random masses."""
    rng = np.random.default_rng(seed)
    drawn = m.with_parameters(m.parameters * np.repeat(rng.normal(1, 0.05, m.n_bodies), 10).clip(0.5, 1.5))
    tau = axode.gravity_torques(drawn, m.random(seed=1, n=20))
    return {"mass": drawn.total_mass, "peak": np.abs(tau).max(axis=0), "name": f"arm {seed}", "heavy": drawn.total_mass > 26}


def test_a_grid_has_all_combinations_in_order():
    points = distributed.grid(x=[1, 2], name="ab", z=[0.5])
    assert points == {"x": [1, 1, 2, 2], "name": ["a", "b", "a", "b"], "z": [0.5] * 4}


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("points_per_part", [None, 7])
def test_rows_are_those_of_a_loop(threads, points_per_part):
    found = distributed.sweep(ARM, variant, {"seed": range(40)}, threads=threads, points_per_part=points_per_part)
    rows = [variant(ARM, seed) for seed in range(40)]
    assert list(found) == ["seed", "mass", "peak", "name", "heavy"]
    assert found["seed"].dtype == np.int64 and list(found["seed"]) == list(range(40))
    for name in ("mass", "peak"):
        assert same(found[name], np.array([row[name] for row in rows]))
    assert list(found["name"]) == [row["name"] for row in rows] and list(found["heavy"]) == [row["heavy"] for row in rows]


@pytest.mark.parametrize("output", ["rows.parquet", "rows"])
def test_rows_go_to_files_and_what_is_there_is_not_computed_again(output, tmp_path):
    # Files, because a list would be a value of the function, and changes.
    log, ready = tmp_path / "log", tmp_path / "ready"

    def counted(m, x, axis):
        with log.open("a") as stream:
            print(x, file=stream)
        if x == 3 and not ready.exists():
            raise ValueError("not yet")
        return float(x * axis[1])

    points = distributed.grid(x=range(6), axis=[[0, 1, 0], [0, 2, 0]])
    with pytest.raises(RuntimeError, match=r"at x = 3, axis = \[0, 1, 0\]: ValueError: not yet"):
        distributed.sweep(ARM, counted, points, tmp_path / output, points_per_part=2)
    ready.touch()
    log.unlink()
    written = distributed.sweep(ARM, counted, points, tmp_path / output, points_per_part=2)
    assert written == (12, 6, 3, 0) and log.read_text().split() == ["3", "3", "4", "4", "5", "5"]
    assert list(read(tmp_path / output, "result")) == [x * a[1] for x, a in zip(points["x"], points["axis"])]
    assert read(tmp_path / output, "axis").tolist() == points["axis"]
    with pytest.raises(FileExistsError, match="exists.*; overwrite=True replaces it"):
        distributed.sweep(ARM, counted, points, tmp_path / output, points_per_part=2)


def test_what_varies_may_be_the_model_and_nothing_needs_to_be_one():
    models = [ARM, ARM.with_payload("flange", axode.lie.sphere_inertia(2.0, 0.05))]
    found = distributed.sweep(models, lambda all_models, k: all_models[k].total_mass, {"k": [0, 1]})
    assert found["result"][1] - found["result"][0] == pytest.approx(2)
    assert list(distributed.sweep(None, lambda m, x: x**2, {"x": [1.5, 2.5]})["result"]) == [2.25, 6.25]


@pytest.mark.parametrize("points, error, sentence", [
    ({"x": [1, 2], "y": [1]}, ValueError, "points: expected equally many values under each name"),
    ({}, ValueError, "points: expected equally many values"),
    ({"x": []}, ValueError, "points is empty; expected at least one value"),
    ({"x": [1, object()]}, ValueError, '"x" is <object.*; expected numbers, words or arrays of numbers'),
    ({"x": [[1], [1, 2]]}, ValueError, '"x" must have the same shape at all points'),
    ({"y": [1]}, RuntimeError, "at y = 1: TypeError"),
    ([{"x": 1}], TypeError, "expected a dict of equally many values under each name"),
])
def test_points_that_are_none_are_refused(points, error, sentence):
    with pytest.raises(error, match=sentence):
        distributed.sweep(None, lambda m, x: 1.0, points)


@pytest.mark.parametrize("function, sentence", [
    (lambda m, x: {"a": x} if x < 2 else {"b": x}, "at x = 2 the function returns b; before it was a"),
    (lambda m, x: {"x": x}, 'the function returns "x", which is a name of the points as well'),
    (lambda m, x: np.zeros(x), '"result" must have the same shape at all points'),
    (lambda m, x: None, '"result" is None; expected numbers, words or arrays of numbers'),
    (lambda m, x: {"a": object()}, '"a" is <object'),
    (lambda m, x: {"a": 1 + 2j}, r'"a" is \(1\+2j\)'),
    (lambda m, x: "ab" if x > 1 else 1.0, '"result"'),
])
def test_results_that_are_no_columns_are_refused(function, sentence):
    with pytest.raises(ValueError, match=sentence):
        distributed.sweep(None, function, {"x": [1, 2, 3]}, points_per_part=3)


def test_results_may_not_differ_from_part_to_part(tmp_path):
    with pytest.raises(ValueError, match=r"from part to part: x \(int64\), a \(double\) and x \(int64\), b \(double\)"):
        distributed.sweep(None, lambda m, x: {"a": x} if x < 2 else {"b": x}, {"x": [1, 2, 3]}, tmp_path / "out.parquet")
    assert not (tmp_path / "out.parquet").exists()


def test_numbers_of_any_kind_are_float64():
    found = distributed.sweep(None, lambda m, x: [1, 2.5, np.float32(3), np.int64(4), True][x], {"x": [0, 1, 2, 3]})
    assert found["result"].dtype == np.float64 and list(found["result"]) == [1, 2.5, 3, 4]


def test_rows_of_a_file_can_be_read_by_pandas(tmp_path):
    pandas = pytest.importorskip("pandas")
    distributed.sweep(ARM, variant, {"seed": range(5)}, tmp_path / "rows.parquet")
    frame = pandas.read_parquet(tmp_path / "rows.parquet")
    assert frame["mass"].mean() == pytest.approx(np.mean([variant(ARM, seed)["mass"] for seed in range(5)]))
    assert pq.ParquetFile(tmp_path / "rows.parquet").metadata.num_rows == 5
