"""A Ray cluster of two workers gives the same results. If one worker is killed, nothing is lost and nothing is
computed twice."""

import os
import signal
import time
from pathlib import Path

import axode
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from axode import distributed
from axode.parallel import jobs, parquet_states
from mechanisms import MECHANISMS
from parquet_files import read, same, state_columns, states, write

ray = pytest.importorskip("ray")
ARM, HUMANOID = MECHANISMS["arm"], MECHANISMS["humanoid"]
MACHINES = {**MECHANISMS, "four bar": axode.load(axode.robots / "four_bar.toml")}


@pytest.fixture(scope="module", autouse=True)
def cluster():
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, configure_logging=False,
             object_store_memory=200 * 2**20)
    yield
    ray.shutdown()


@pytest.mark.parametrize("m", MACHINES.values(), ids=MACHINES)
def test_results_are_those_of_one_process_and_of_a_direct_call_to_the_last_bit(m, tmp_path):
    state = states(m, 300)
    write(tmp_path / "in.parquet", m, state, row_group_size=130)
    direct = axode.forward_dynamics(m, state["q"], state["v"], state["tau"])
    for output in ("out.parquet", "out"):
        written = distributed.map_states(m, "forward_dynamics", tmp_path / "in.parquet", tmp_path / output, rows_per_part=40)
        assert written == (300, 4 + 4 + 1, 9, 0)
        assert same(read(tmp_path / output, "a"), direct) and same(read(tmp_path / output, "t"), state["t"])


def test_a_sweep_is_that_of_one_process(tmp_path):
    def variant(m, seed):
        drawn = m.with_parameters(m.parameters * np.random.default_rng(seed).uniform(0.9, 1.1))
        return {"tau": axode.gravity_torques(drawn, np.full(7, 0.3)), "pid": os.getpid()}

    found = distributed.sweep(ARM, variant, {"seed": range(60)})
    assert same(found["tau"], np.array([variant(ARM, seed)["tau"] for seed in range(60)]))
    assert os.getpid() not in found["pid"]
    assert distributed.sweep(ARM, variant, {"seed": range(60)}, tmp_path / "rows.parquet").rows == 60
    assert same(read(tmp_path / "rows.parquet", "tau"), found["tau"])


@pytest.mark.parametrize("output", ["out.parquet", "out"])
def test_nothing_is_lost_and_nothing_twice_where_a_worker_is_killed(output, tmp_path):
    state = states(ARM, 400)
    write(tmp_path / "in.parquet", ARM, state)
    log = tmp_path / "log"
    log.mkdir()

    def torques(m, q, v, a, t):
        """Records which part it computes in which process. At the first time one of the parts takes long."""
        first = not list(log.glob("0.200*"))
        (log / f"{t[0]:.3f} {os.getpid()} {time.monotonic_ns()}").touch()
        time.sleep(60 if t[0] == 0.2 and first else 0.02)
        return {"tau": axode.inverse_dynamics(m, q, v, a), "pid": np.full(len(q), float(os.getpid()))}

    killed = []

    def kill_one_of_two(done, rows):
        if not killed and (at := list(log.glob("0.200*"))):
            killed.append(int(at[0].name.split()[1]))
            os.kill(killed[0], signal.SIGKILL)

    written = distributed.map_states(ARM, torques, tmp_path / "in.parquet", tmp_path / output, rows_per_part=20,
                                     progress=kill_one_of_two)
    assert killed and written == (400, 20, 20, 0)
    assert same(read(tmp_path / output, "t"), state["t"])
    assert same(read(tmp_path / output, "tau"), axode.inverse_dynamics(ARM, state["q"], state["v"], state["a"]))
    begun = sorted(file.name.split()[0] for file in log.iterdir())
    # The part of the killed worker was started twice, and no other part.
    assert begun == sorted([f"{k * 0.02:.3f}" for k in range(20)] + ["0.200"])
    pids = read(tmp_path / output, "pid")
    assert len(set(pids)) >= 2 and killed[0] not in pids[200:220]
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(["in.parquet", "log", output])


def test_a_worker_that_ends_between_writing_and_saying_so_writes_once(tmp_path):
    """Ray starts the part again, which finds that its file exists."""
    def ending(part):
        """Its worker ends as soon as the file of the part exists."""
        with (tmp_path / "computed").open("a") as stream:
            stream.write("once\n")
        replace = Path.replace

        def replace_and_end(self, target):
            replace(self, target)
            os.kill(os.getpid(), signal.SIGKILL)

        Path.replace = replace_and_end
        return pa.table({"x": np.arange(3.0)}), 0

    path = tmp_path / "part-000000.parquet"
    report, = jobs.run(ending, [parquet_states.Part("", 0, 3)], [path], cluster=None, threads=1, retries=3, progress=False)
    assert (report.number, report.computed) == (0, False)
    assert (tmp_path / "computed").read_text() == "once\n"
    assert pq.read_table(path).column("x").to_pylist() == [0.0, 1.0, 2.0]


def test_what_ends_every_worker_is_said_and_the_rest_is_kept(tmp_path):
    state = states(ARM, 100)
    write(tmp_path / "in.parquet", ARM, state)
    healed = tmp_path / "healed"

    def torques(m, q, v, a, t):
        if t[0] == 0.08 and not healed.exists():
            os.kill(os.getpid(), signal.SIGKILL)
        return axode.inverse_dynamics(m, q, v, a)

    def call():
        return distributed.map_states(ARM, torques, tmp_path / "in.parquet", tmp_path / "out.parquet", rows_per_part=10,
                                      retries=1)

    with pytest.raises(RuntimeError, match="in.parquet, rows 80 to 89: its worker ended 2 times"):
        call()
    assert not (tmp_path / "out.parquet").exists()
    healed.touch()
    assert 1 <= call().computed < 10
    assert same(read(tmp_path / "out.parquet", "torques"), axode.inverse_dynamics(ARM, state["q"], state["v"], state["a"]))


def test_ctrl_c_ends_it_and_it_goes_on(tmp_path):
    state = states(ARM, 200)
    write(tmp_path / "in.parquet", ARM, state)

    def interrupted(done, rows):
        if done >= 60:
            raise KeyboardInterrupt

    job = {"rows_per_part": 10}
    with pytest.raises(KeyboardInterrupt):
        distributed.map_states(ARM, "mass_matrix", tmp_path / "in.parquet", tmp_path / "out", progress=interrupted, **job)
    parts = len(list((tmp_path / "out").glob("part-*")))
    assert 6 <= parts < 20
    written = distributed.map_states(ARM, "mass_matrix", tmp_path / "in.parquet", tmp_path / "out", **job)
    assert written.parts - written.computed >= parts
    assert same(read(tmp_path / "out", "mass_matrix"), axode.mass_matrix(ARM, state["q"]))


def test_what_is_wrong_is_said_as_in_one_process(tmp_path):
    state = states(HUMANOID, 100)
    state["v"][70] = 1e200
    write(tmp_path / "in.parquet", HUMANOID, state)
    with pytest.raises(axode.NotFiniteError, match="in.parquet: row 70: a number is not finite") as raised:
        distributed.map_states(HUMANOID, "inverse_dynamics", tmp_path / "in.parquet", tmp_path / "out", rows_per_part=30)
    assert raised.value.states == [70]
    written = distributed.map_states(HUMANOID, "inverse_dynamics", tmp_path / "in.parquet", tmp_path / "out", rows_per_part=30,
                                     faulty="nan", overwrite=True)
    assert written.faulty == 1 and np.isnan(read(tmp_path / "out", "tau")[70]).all()

    class Odd(Exception):
        def __reduce__(self):
            raise TypeError("not to be pickled")

    def odd(m, x):
        raise Odd("quite")

    with pytest.raises(RuntimeError, match="at x = 1: Odd: quite"):
        distributed.sweep(ARM, odd, {"x": [1]})


def test_a_program_that_is_connected_names_no_other_cluster(tmp_path):
    with pytest.raises(ValueError, match="cluster is 'local', but this program is connected to a Ray cluster"):
        distributed.sweep(ARM, lambda m, x: x, {"x": [1.0]}, cluster="local")


def test_ray_data_takes_functions_of_tables(tmp_path):
    import ray.data

    state = states(ARM, 90)
    write(tmp_path / "in.parquet", ARM, state)
    ray.data.DataContext.get_current().enable_progress_bars = False
    data = ray.data.read_parquet(str(tmp_path / "in.parquet"), override_num_blocks=1)
    data = data.map_batches(distributed.TableFunction(ARM, "inverse_dynamics"), batch_format="pyarrow", batch_size=40)
    rows = sorted(data.take_all(), key=lambda row: row["t"])
    assert same(np.stack([row["tau"] for row in rows]), axode.inverse_dynamics(ARM, state["q"], state["v"], state["a"]))


def test_a_table_of_states_is_mapped_row_by_row():
    state = states(ARM, 10)
    table = distributed.TableFunction(ARM, "gravity_torques", keep=["t"])(pa.table(state_columns(ARM, state)))
    assert table.column_names == ["t", "gravity_torques"] and table.num_rows == 10
