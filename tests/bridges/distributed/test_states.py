"""Functions of states that read and write Parquet files give the same results as direct calls, and their errors say
what is wrong with a file."""

import inspect
import shutil

import axode
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from axode import distributed
from axode.parallel import parquet_states
from mechanisms import MECHANISMS
from parquet_files import lists, read, same, state_columns, states, write

ARM, HUMANOID = MECHANISMS["arm"], MECHANISMS["humanoid"]
FOUR_BAR = axode.load(axode.robots / "four_bar.toml")


@pytest.mark.parametrize("layout", ["lists", "lists of any length", "coordinates"])
@pytest.mark.parametrize("m", MECHANISMS.values(), ids=MECHANISMS)
def test_results_are_those_of_a_direct_call_to_the_last_bit(m, layout, tmp_path):
    state = states(m, 700)
    write(tmp_path / "states.parquet", m, state, layout, row_group_size=300)
    for function, takes, result in (("inverse_dynamics", "qva", "tau"), ("forward_dynamics", ["q", "v", "tau"], "a")):
        direct = getattr(axode, function)(m, *(state[what] for what in takes))
        for threads, rows_per_part, output in ((1, 700, "one.parquet"), (2, 64, "parts"), (3, 299, "three.parquet")):
            target = tmp_path / function / output
            target.parent.mkdir(exist_ok=True)
            written = distributed.map_states(m, function, tmp_path / "states.parquet", target, threads=threads,
                                             rows_per_part=rows_per_part)
            parts = sum(-(-rows // rows_per_part) for rows in (300, 300, 100))
            assert written == (700, parts, parts, 0)
            assert same(read(target, result), direct) and same(read(target, "t"), state["t"])


def test_every_function_of_states_is_there():
    known = parquet_states.functions()
    assert {"inverse_dynamics", "poses", "mass_matrix", "kinetic_energy", "jacobian", "regressor", "impact"} <= set(known)
    assert not {"simulate", "inverse_kinematics", "load", "view", "equilibrium"} & set(known)


OF_KNOWN_WIDTH = [name for name in parquet_states.functions() if parquet_states.OF_VELOCITIES | {
    "q", "m", "frame", "base", "loads"} >= {x.name for x in inspect.signature(getattr(axode, name)).parameters.values()
                                            if x.default is x.empty}]


@pytest.mark.parametrize("function", OF_KNOWN_WIDTH)
@pytest.mark.parametrize("m", [MECHANISMS["machine"], FOUR_BAR], ids=["machine", "four bar"])
def test_every_function_gives_what_a_direct_call_gives(m, function, tmp_path):
    rng = np.random.default_rng(3)
    state = states(m, 5) | {name: rng.uniform(-1, 1, (5, m.nv)) for name in ("p", "dq", "dv", "da", "dtau")}
    needs = [x.name for x in inspect.signature(getattr(axode, function)).parameters.values() if x.default is x.empty]
    arguments = {"frame": m.frame_names[-1], "base": 0, "loads": [axode.Load(frame=m.frame_names[-1], wrench=[1, 2, 3, 4, 5, 6])]}
    arguments = {name: value for name, value in arguments.items() if name in needs}
    given = {name: state[name] for name in needs if name in state}
    try:
        direct = getattr(axode, function)(m, **given, **arguments)
    except ValueError as error:  # such as what is not for mechanisms with loops: then there is no file either
        with pytest.raises(ValueError, match="model|loop") as raised:
            distributed.TableFunction(m, function, arguments)(pa.table(state_columns(m, state)))
        assert str(error).removeprefix("state 0: ") in str(raised.value)
        return
    write(tmp_path / "in.parquet", m, state)
    expected = parquet_states.named_results(direct, {"inverse_dynamics": "tau", "forward_dynamics": "a"}.get(function, function))
    if any(np.size(x) == 0 for x in expected.values()):
        with pytest.raises(ValueError, match=f'"{function}.*" has no numbers'):
            distributed.map_states(m, function, tmp_path / "in.parquet", tmp_path / "out.parquet", arguments=arguments)
        return
    distributed.map_states(m, function, tmp_path / "in.parquet", tmp_path / "out.parquet", arguments=arguments, rows_per_part=2)
    assert pq.read_schema(tmp_path / "out.parquet").names == ["t", *expected]
    for name, x in expected.items():
        assert same(read(tmp_path / "out.parquet", name), np.asarray(x)), name


def test_a_function_of_somebody_else_takes_the_columns_that_it_names(tmp_path):
    state = states(ARM, 300)
    write(tmp_path / "in.parquet", ARM, state)

    def power(m, q, v, tau, t, factor=1.0):
        return {"power": factor * np.sum(v * tau, axis=1), "late": t > 0.1, "frame": axode.poses(m, q)[:, -1]}

    distributed.map_states(ARM, power, tmp_path / "in.parquet", tmp_path / "out.parquet", arguments={"factor": 2.0}, keep=[],
                           rows_per_part=100)
    assert pq.read_schema(tmp_path / "out.parquet").names == ["power", "late", "frame"]
    assert same(read(tmp_path / "out.parquet", "power"), 2 * np.sum(state["v"] * state["tau"], axis=1))
    assert np.array_equal(read(tmp_path / "out.parquet", "late"), state["t"] > 0.1)
    assert same(read(tmp_path / "out.parquet", "frame"), axode.poses(ARM, state["q"])[:, -1])


def test_what_is_carried_over_is_what_was_asked_for(tmp_path):
    state = states(ARM, 20)
    file = write(tmp_path / "in.parquet", ARM, state)
    for keep, kept in ((None, ["t"]), ([], []), (["v", "t"], ["v", "t"]), ("all", ["t", "q", "v", "a", "tau"])):
        distributed.map_states(ARM, "kinetic_energy", file, tmp_path / "out.parquet", keep=keep, overwrite=True, rows_per_part=7)
        assert pq.read_schema(tmp_path / "out.parquet").names == [*kept, "kinetic_energy"]
        for name in kept:
            assert same(read(tmp_path / "out.parquet", name), state[name])
    with pytest.raises(ValueError, match='the result "tau" and a column that is kept have the same name'):
        distributed.map_states(ARM, "inverse_dynamics", file, tmp_path / "tau.parquet", keep="all")
    with pytest.raises(ValueError, match='in.parquet: there is no column "time" to keep; there are t, q, v, a, tau'):
        distributed.map_states(ARM, "inverse_dynamics", file, tmp_path / "tau.parquet", keep=["time"])


def test_float32_is_read_and_written_and_computed_in_float64(tmp_path):
    state = {name: x.astype(np.float32) for name, x in states(HUMANOID, 50).items()}
    file = write(tmp_path / "in.parquet", HUMANOID, state)
    direct = axode.inverse_dynamics(HUMANOID, state["q"], state["v"], state["a"])
    for dtype in ("float64", "float32"):
        distributed.map_states(HUMANOID, "inverse_dynamics", file, tmp_path / f"{dtype}.parquet", dtype=dtype)
        assert same(read(tmp_path / f"{dtype}.parquet", "tau"), direct.astype(dtype))
    integers = pa.table({"q": pa.array([[1, 0, 0, 0, 0, 0, 0]])})
    assert distributed.TableFunction(ARM, "poses")(integers).column("poses").type.shape == [len(ARM.frame_names), 4, 4]


def test_a_folder_is_read_in_the_order_of_its_paths(tmp_path):
    parts = [{name: x[:N] for name, x in states(ARM, 250, N).items()} for N in (100, 0, 37, 250)]
    for name, part in zip(("a/1", "a/2", "b", "c"), parts):
        (tmp_path / "in" / name).parent.mkdir(exist_ok=True, parents=True)
        write(tmp_path / "in" / f"{name}.parquet", ARM, part, row_group_size=64)
    (tmp_path / "in/_metadata.parquet").write_text("no states")
    (tmp_path / "in/note.txt").write_text("nor here")
    written = distributed.map_states(ARM, "gravity_torques", tmp_path / "in", tmp_path / "out")
    assert written.rows == 387 and written.parts == 2 + 0 + 1 + 4
    q = np.concatenate([part["q"] for part in parts])
    assert same(read(tmp_path / "out", "gravity_torques"), axode.gravity_torques(ARM, q))
    listed = [tmp_path / "in/c.parquet", str(tmp_path / "in/b.parquet")]
    distributed.map_states(ARM, "gravity_torques", listed, tmp_path / "two.parquet")
    assert same(read(tmp_path / "two.parquet", "gravity_torques"),
                axode.gravity_torques(ARM, np.concatenate([parts[3]["q"], parts[2]["q"]])))


def test_parts_are_read_in_any_order_and_from_the_file_that_is_there(tmp_path):
    """A worker keeps a row group open between its parts, also from one job to the next."""
    for N in (100, 90):
        state = states(ARM, N, seed=N)
        file = str(write(tmp_path / "in.parquet", ARM, state, row_group_size=60))
        schema, parts = parquet_states.slices(file, 25)
        assert [part.rows for part in parts] == [25, 25, 10, *([25, 15] if N == 100 else [25, 5])]
        for k in (2, 3, 0, 1, 4, 4, 2, 1):
            table = parquet_states.read(parts[k], ["t", "q"], 25)
            rows = slice(parts[k].first, parts[k].first + parts[k].rows)
            assert table.column_names == ["t", "q"] and np.array_equal(table["t"], state["t"][rows])
            assert same(parquet_states.numbers(table["q"], "q"), state["q"][rows])


@pytest.mark.parametrize("layout", ["lists", "lists of any length", "coordinates"])
@pytest.mark.parametrize("output", ["out.parquet", "out"])
def test_no_states_make_a_file_without_rows(layout, output, tmp_path):
    write(tmp_path / "in.parquet", ARM, {name: x[:0] for name, x in states(ARM, 1).items()}, layout)
    assert distributed.map_states(ARM, "mass_matrix", tmp_path / "in.parquet", tmp_path / output).rows == 0
    assert read(tmp_path / output, "mass_matrix").shape == (0, 7, 7)


def table_with(name, column, N=40):
    table = pa.table(state_columns(ARM, states(ARM, N)))
    return table.set_column(table.schema.get_field_index(name), name, column)


def rows(N=40, **changed):
    """A column of lists of seven numbers, with some rows replaced by others."""
    return pa.array([changed.get(f"row{k}", [0.1] * 7) for k in range(N)], pa.list_(pa.float64()))


@pytest.mark.parametrize("column, sentence", [
    (rows(row17=[0.1] * 6), 'row 17: column "v" has 6 numbers; model "arm7" takes 7'),
    (rows(row3=None), "row 3: v has null in it; expected finite numbers"),
    (rows(row39=[0.1, None, 0.1, 0.1, 0.1, 0.1, 0.1]), "row 39: v has null in it"),
    (rows(row20=[0.1, np.nan, 0.1, 0.1, 0.1, 0.1, 0.1]), "row 20: v has nan in it"),
    (rows(row3=[0.1, np.nan, 0.1, 0.1, 0.1, 0.1, 0.1], row20=[None] * 7), "row 3: v has nan in it"),
    (rows(row8=[0.1, 0.1, 0.1, 0.1, 0.1, 0.1, -np.inf]), "row 8: v has -inf in it"),
    (lists(np.zeros((40, 8))), 'column "v" has 8 numbers; model "arm7" takes 7'),
    (pa.array([["a"] * 7] * 40), 'column "v" holds list<.*: string>; expected lists of numbers'),
    (pa.array(["0.1"] * 40), 'column "v" holds string; expected lists of numbers'),
    (pa.array(np.zeros(40)), 'column "v" holds double; expected lists of numbers'),
], ids=["length", "null", "null in a list", "nan", "nan before null", "inf", "all lengths", "words", "strings", "no lists"])
def test_columns_that_are_no_states_are_refused_with_file_and_row(column, sentence, tmp_path):
    pq.write_table(table_with("v", column), tmp_path / "in.parquet", row_group_size=7)
    with pytest.raises(ValueError, match=rf"in\.parquet: (row \d+: )?{sentence}"):
        distributed.map_states(ARM, "inverse_dynamics", tmp_path / "in.parquet", tmp_path / "out.parquet", rows_per_part=5)
    assert not (tmp_path / "out.parquet").exists()


@pytest.mark.parametrize("change, sentence", [
    (lambda t: t.drop_columns(["a"]), 'there is no column "a", nor columns "a A1", ..., "a A7"; there are t, q, v, tau'),
    (lambda t: t.drop_columns(["q"]).append_column("q A1", pa.array(np.zeros(40))), 'there is no column "q A2"'),
])
def test_columns_that_are_missing_are_named(change, sentence, tmp_path):
    pq.write_table(change(table_with("t", pa.array(np.arange(40)))), tmp_path / "in.parquet")
    with pytest.raises(ValueError, match=sentence):
        distributed.map_states(ARM, "inverse_dynamics", tmp_path / "in.parquet", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_states_that_cannot_be_computed_are_named(tmp_path):
    state = states(HUMANOID, 1000)
    state["q"][777, :4] *= 1.1
    write(tmp_path / "quaternion.parquet", HUMANOID, state)
    with pytest.raises(ValueError, match=r'quaternion.parquet: row 777: q: the quaternion of joint "free_base" has norm 1.1'):
        distributed.map_states(HUMANOID, "poses", tmp_path / "quaternion.parquet", tmp_path / "poses", rows_per_part=400)
    state = states(ARM, 1000)
    state["v"][[600, 900]] = 1e200
    write(tmp_path / "fast.parquet", ARM, state)
    with pytest.raises(axode.NotFiniteError, match="fast.parquet: row 600: a number is not finite") as raised:
        distributed.map_states(ARM, "coriolis_vector", tmp_path / "fast.parquet", tmp_path / "out", rows_per_part=500)
    assert raised.value.states == [600]
    with pytest.raises(axode.NotFiniteError, match="row 600: "):
        distributed.TableFunction(ARM, "coriolis_vector")(pq.read_table(tmp_path / "fast.parquet"))


@pytest.mark.parametrize("function", ["inverse_dynamics", "inverse_dynamics_derivatives", "mass_matrix"])
def test_faulty_rows_are_nan_where_one_asks_and_others_are_as_ever(function, tmp_path):
    state = states(ARM, 200)
    direct = getattr(axode, function)(ARM, *(state[x] for x in ("qva" if function != "mass_matrix" else "q")))
    state["q"][[3, 150]] = np.nan
    state["v"][[77]] = 1e200
    table = pa.table(state_columns(ARM, state))
    nulls = pa.array([None if k == 9 else row for k, row in enumerate(table.column("q").to_pylist())])
    pq.write_table(table.set_column(1, "q", nulls), tmp_path / "in.parquet")
    written = distributed.map_states(ARM, function, tmp_path / "in.parquet", tmp_path / "out.parquet", faulty="nan",
                                     rows_per_part=50)
    bad = np.isin(np.arange(200), [3, 9, 150] if function == "mass_matrix" else [3, 9, 77, 150])
    assert written.faulty == bad.sum()
    for name, x in parquet_states.named_results(direct, "tau" if function == "inverse_dynamics" else function).items():
        found = read(tmp_path / "out.parquet", name)
        assert same(found[~bad], x[~bad]) and np.isnan(found[bad]).all()


def test_states_without_a_result_alone_are_nan_too(tmp_path):
    massless = axode.Model.from_bodies([{"name": "slide", "joint": {"kind": "prismatic", "axis": "z"}}])
    write(tmp_path / "in.parquet", massless, states(massless, 5))
    with pytest.raises(axode.SingularError, match="in.parquet: row 0: the mass matrix is singular"):
        distributed.map_states(massless, "forward_dynamics", tmp_path / "in.parquet", tmp_path / "out.parquet")
    written = distributed.map_states(massless, "forward_dynamics", tmp_path / "in.parquet", tmp_path / "out.parquet",
                                     faulty="nan", overwrite=True)
    assert written.faulty == 5 and np.isnan(read(tmp_path / "out.parquet", "a")).all()


def test_files_that_are_not_parquet_are_refused(tmp_path):
    whole = write(tmp_path / "whole.parquet", ARM, states(ARM, 5000), row_group_size=1000)
    data = whole.read_bytes()
    spoilt = bytearray(data)
    spoilt[len(data) // 3:len(data) // 2] = bytes(len(data) // 2 - len(data) // 3)
    for name, text in (("cut", data[:-100]), ("empty", b""), ("words", b"q,v,a\n1,2,3\n"), ("spoilt", bytes(spoilt))):
        file = tmp_path / f"{name}.parquet"
        file.write_bytes(text)
        with pytest.raises(ValueError, match=rf"{name}\.parquet: .*") as raised:
            distributed.map_states(ARM, "inverse_dynamics", file, tmp_path / "out.parquet", overwrite=True, threads=2)
        assert "\n" not in str(raised.value)
        assert not (tmp_path / "out.parquet").exists()
    with pytest.raises(FileNotFoundError, match="none.parquet: there is no such file or folder"):
        distributed.map_states(ARM, "poses", tmp_path / "none.parquet", tmp_path / "out")
    (tmp_path / "folder").mkdir()
    with pytest.raises(FileNotFoundError, match=r"folder: there are no files \*.parquet in this folder"):
        distributed.map_states(ARM, "poses", tmp_path / "folder", tmp_path / "out")
    write(tmp_path / "folder/1.parquet", ARM, states(ARM, 5))
    write(tmp_path / "folder/2.parquet", ARM, {"v": np.zeros((3, 7))})
    with pytest.raises(ValueError, match='folder/2.parquet: there is no column "q"'):
        distributed.map_states(ARM, "poses", tmp_path / "folder", tmp_path / "out")


WRONG = {
    "nothing near": (("torque", {}), KeyError, 'there is no function of states "torque"'),
    "a misprint": (("inverse_dynamcs", {}), KeyError, 'did you mean "inverse_dynamics"'),
    "a name of others": (("crba", {}), KeyError, 'did you mean "mass_matrix"'),
    "one that takes no states": (("simulate", {}), KeyError, "there is no function of states"),
    "no frame": (("jacobian", {}), TypeError, "jacobian needs an argument 'frame'"),
    "another frame": (("jacobian", {"arguments": {"frame": "flang"}}), KeyError, 'did you mean "flange"'),
    "another word": (("mass_matrix", {"arguments": {"representation": "world"}}), ValueError, "representation is 'world'"),
    "an argument it has not": (("poses", {"arguments": {"frames": 1}}), TypeError, "poses has no argument 'frames'"),
    "a misprinted argument": (("jacobian", {"arguments": {"fram": 1}}), TypeError, "did you mean 'frame'"),
    "dtype": (("poses", {"dtype": "float16"}), ValueError, "dtype is 'float16'; expected one of 'float64', 'float32'"),
    "faulty": (("poses", {"faulty": "skip"}), ValueError, "faulty is 'skip'; expected one of 'refuse', 'nan'"),
    "threads": (("poses", {"threads": 0}), ValueError, "threads is 0; it must be at least 1"),
    "a cluster that is not there": (("poses", {"cluster": "127.0.0.1:1"}), (ConnectionError, ImportError), "127.0.0.1:1"),
    "rows": (("poses", {"rows_per_part": 0}), ValueError, "rows_per_part is 0; it must be at least 1"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_calls_get_a_sentence_and_leave_no_file(wrong, tmp_path):
    (function, options), error, sentence = WRONG[wrong]
    write(tmp_path / "in.parquet", ARM, states(ARM, 5))
    with pytest.raises(error) as raised:
        distributed.map_states(ARM, function, tmp_path / "in.parquet", tmp_path / "out.parquet", **options)
    assert sentence in str(raised.value)
    assert [file.name for file in tmp_path.iterdir()] == ["in.parquet"]


def test_names_of_no_files_are_refused(tmp_path):
    for given, sentence in (("", "states is empty; expected the name"), ([], "states is empty; expected at least one file")):
        with pytest.raises(ValueError, match=sentence):
            distributed.map_states(ARM, "poses", given, tmp_path / "out")


def test_drive_forces_over_time_are_tensors(tmp_path):
    state = states(ARM, 30)
    tau = np.random.default_rng(1).uniform(-1, 1, (30, 4, 7))
    forces = pa.ExtensionArray.from_storage(pa.fixed_shape_tensor(pa.float64(), (4, 7)), lists(tau.reshape(30, 28)))
    table = pa.table({**state_columns(ARM, {"q": state["q"], "v": state["v"]}), "tau": forces})
    pq.write_table(table, tmp_path / "in.parquet", row_group_size=20)
    distributed.map_states(ARM, "rollout", tmp_path / "in.parquet", tmp_path / "out.parquet", arguments={"step": 1e-3})
    q, v = axode.rollout(ARM, state["q"], state["v"], tau, 1e-3)
    assert same(read(tmp_path / "out.parquet", "rollout.0"), q) and same(read(tmp_path / "out.parquet", "rollout.1"), v)


def test_a_model_is_a_model_and_has_states(tmp_path):
    with pytest.raises(TypeError, match="expected an axode.Model"):
        distributed.TableFunction("arm7.toml", "poses")
    static = axode.Model.from_bodies([{"name": "table", "joint": "fixed"}])
    with pytest.raises(ValueError, match="has no coordinates; there are no states of it"):
        distributed.TableFunction(static, "poses")


def test_functions_of_somebody_else_that_fail_or_misunderstand_are_named(tmp_path):
    file = write(tmp_path / "in.parquet", ARM, states(ARM, 20))

    def divided(m, q, t):
        return 1 / int(t[0] < 0.016) * q

    def one(m, q):
        return q[0]

    with pytest.raises(RuntimeError, match=r"divided of .*in.parquet, rows 16 to 19: ZeroDivisionError"):
        distributed.map_states(ARM, divided, file, tmp_path / "a", rows_per_part=4)
    with pytest.raises(RuntimeError, match=r'"one" has shape \(7,\); expected \(20, ...\), an entry for each state'):
        distributed.map_states(ARM, one, file, tmp_path / "b")


def test_memory_does_not_grow_with_the_states(tmp_path):
    """Memory holds only the parts that are being computed, so that four times the number of states needs no more."""
    most = []
    for N in (20_000, 80_000):
        file = write(tmp_path / f"{N}.parquet", ARM, {"q": np.resize(states(ARM, 100)["q"], (N, 7))}, row_group_size=N)
        seen = []
        distributed.map_states(ARM, "mass_matrix", file, tmp_path / f"out{N}.parquet", rows_per_part=2000, threads=2,
                               progress=lambda done, rows: seen.append(pa.total_allocated_bytes()))
        assert len(seen) == N // 2000
        most.append(max(seen))
    assert most[1] < 1.5 * most[0] + 4e6, most


def test_parts_are_smaller_where_results_are_large(tmp_path, monkeypatch):
    file = write(tmp_path / "in.parquet", ARM, states(ARM, 100))
    monkeypatch.setattr(distributed, "BYTES", 30 * 49 * 8)  # of 30 mass matrices
    assert distributed.map_states(ARM, "mass_matrix", file, tmp_path / "out").parts == 4
    assert same(read(tmp_path / "out", "mass_matrix"), axode.mass_matrix(ARM, states(ARM, 100)["q"]))


def test_an_output_that_is_there_is_replaced_only_if_one_says_so(tmp_path):
    file = write(tmp_path / "in.parquet", ARM, states(ARM, 100))
    for output in ("out.parquet", "out"):
        target = tmp_path / output
        distributed.map_states(ARM, "poses", file, target, rows_per_part=30)
        for function in ("poses", "mass_matrix"):
            with pytest.raises(FileExistsError, match="exists; overwrite=True replaces it"):
                distributed.map_states(ARM, function, file, target, rows_per_part=30)
        assert read(target, "poses").shape == (100, len(ARM.frame_names), 4, 4)
        written = distributed.map_states(ARM, "mass_matrix", file, target, rows_per_part=50, overwrite=True)
        assert written == (100, 2, 2, 0) and read(target, "mass_matrix").shape == (100, 7, 7)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/thesis.txt").write_text("of three years")
    for overwrite in (False, True):
        with pytest.raises(FileExistsError, match="mine is not empty and was not written by axode.distributed"):
            distributed.map_states(ARM, "poses", file, tmp_path / "mine", overwrite=overwrite)
    assert (tmp_path / "mine/thesis.txt").read_text() == "of three years"
    with pytest.raises(FileNotFoundError, match="there is no such folder"):
        distributed.map_states(ARM, "poses", file, tmp_path / "nowhere/out.parquet")
    shutil.rmtree(tmp_path / "out")
    (tmp_path / "out").write_text("")
    with pytest.raises(FileExistsError, match="out is a file"):
        distributed.map_states(ARM, "poses", file, tmp_path / "out")


def test_results_may_not_lie_among_the_states(tmp_path):
    write(tmp_path / "in/1.parquet", ARM, states(ARM, 5))
    for given, output in ((tmp_path / "in", tmp_path / "in/out.parquet"), (tmp_path / "in/1.parquet", tmp_path / "in"),
                          (tmp_path / "in/1.parquet", tmp_path / "in/1.parquet"), (tmp_path / "in", tmp_path / "in/out")):
        with pytest.raises(ValueError, match="contain each other; choose another folder"):
            distributed.map_states(ARM, "poses", given, output, overwrite=True)
    assert read(tmp_path / "in/1.parquet", "q").shape == (5, 7)
