"""Properties that every function of the state has."""

import inspect
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import axode
import numpy as np
import pytest
from calls import CALLS
from mechanisms import MECHANISMS, close, random_states

EVERYWHERE = pytest.mark.parametrize("mechanism", MECHANISMS)
EVERYTHING = pytest.mark.parametrize("call", CALLS)


def some(m):
    """A number of states for a call: only two if the results are large, such as tensors of large mechanisms."""
    return 2 if m.nv > 20 else 9


def same(x, y):
    return np.array_equal(x, y, equal_nan=True)


@EVERYWHERE
@EVERYTHING
def test_many_states_are_the_single_ones_in_a_row(mechanism, call):
    m = MECHANISMS[mechanism]
    if call.startswith("jacobian_partials") and m.nv > 20:
        pytest.skip("a tensor of 6 x 38^3 numbers")
    q, v, a, _ = random_states(m, some(m))
    many = CALLS[call](m, q, v, a)
    single = np.array([CALLS[call](m, *state) for state in zip(q, v, a)])
    assert many.dtype == np.float64
    assert many.shape == single.shape
    assert close(np.nan_to_num(many), np.nan_to_num(single))
    assert same(np.isnan(many), np.isnan(single))


@EVERYTHING
def test_no_states_give_an_empty_result(call):
    m = MECHANISMS["arm"]
    q, v, a, _ = random_states(m, 1)
    assert CALLS[call](m, q[:0], v[:0], a[:0]).shape == (0, *CALLS[call](m, q[0], v[0], a[0]).shape)


@EVERYTHING
def test_layout_and_type_of_arguments_change_nothing(call):
    m = MECHANISMS["machine"]
    q, v, a, _ = random_states(m, 4)
    expected = CALLS[call](m, q, v, a)
    assert same(CALLS[call](m, *(np.asfortranarray(x) for x in (q, v, a))), expected)
    strided = [np.repeat(x, 2, axis=1)[:, ::2] for x in (q, v, a)]
    assert same(CALLS[call](m, *strided), expected)
    assert same(CALLS[call](m, *(np.ma.masked_array(x) for x in (q, v, a))), expected)  # with nothing masked
    read_only = [x.copy() for x in (q, v, a)]
    for x in read_only:
        x.flags.writeable = False
    assert same(CALLS[call](m, *read_only), expected)


def test_lists_integers_and_single_precision_are_taken():
    m = MECHANISMS["arm"]
    expected = axode.inverse_dynamics(m, np.zeros(7), np.ones(7), np.full(7, 2.0))
    assert same(axode.inverse_dynamics(m, [0] * 7, (1,) * 7, np.full(7, 2, dtype=np.int8)), expected)
    assert same(axode.inverse_dynamics(m, np.zeros(7, np.float32), np.ones(7, np.uint64), np.full(7, 2, np.float16)),
                expected)
    assert same(axode.inverse_dynamics(m, np.zeros(7, ">f8"), np.ones(7), np.full(7, 2.0)), expected)


@EVERYTHING
def test_arguments_are_left_as_they_were(call):
    m = MECHANISMS["machine"]
    q, v, a, _ = random_states(m, 3)
    before = [x.copy() for x in (q, v, a)]
    CALLS[call](m, q, v, a)
    assert all(same(x, y) for x, y in zip((q, v, a), before))


@pytest.mark.parametrize("call", [name for name in CALLS if "operational" not in name])
def test_eight_threads_on_one_model_agree_with_one(call):
    m = MECHANISMS["machine"]
    q, v, a, _ = random_states(m, 40)
    expected = CALLS[call](m, q, v, a)
    single = [CALLS[call](m, *state) for state in zip(q, v, a)]
    with ThreadPoolExecutor(8) as pool:
        batches = [pool.submit(CALLS[call], m, q, v, a) for _ in range(16)]
        states = [pool.submit(CALLS[call], m, *state) for state in zip(q, v, a)]
        assert all(same(batch.result(), expected) for batch in batches)
        assert all(same(state.result(), one) for state, one in zip(states, single))


@pytest.mark.parametrize("representation", ["fast", "body"])
@pytest.mark.parametrize("threads", [1, 2])
def test_other_threads_run_during_a_long_call(representation, threads):
    m = MECHANISMS["humanoid"]
    q, v, a, _ = (np.repeat(x, 20000, axis=0) for x in random_states(m, 1))
    started, ended = threading.Event(), threading.Event()

    def call():
        started.set()
        axode.inverse_dynamics(m, q, v, a, representation, threads=threads)
        ended.set()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(60)  # nobody is interrupted: others run only where the call lets them
    try:
        thread = threading.Thread(target=call)
        thread.start()
        started.wait()
        assert not ended.is_set()
    finally:
        sys.setswitchinterval(interval)
        thread.join()


STATE_FUNCTIONS = sorted(name for name in axode.__all__ if not inspect.isclass(getattr(axode, name))
                         and callable(getattr(axode, name)) and {"q", "threads"} <= set(inspect.signature(getattr(axode, name)).parameters))


def test_every_function_of_the_state_is_called_here():
    assert len(STATE_FUNCTIONS) > 40
    assert not set(STATE_FUNCTIONS) - {call.split()[0] for call in CALLS}


@pytest.mark.parametrize("function", STATE_FUNCTIONS)
def test_the_number_of_threads_changes_no_bit(function, monkeypatch):
    m = MECHANISMS["machine"]
    q, v, a, _ = random_states(m, 37)
    name = next(call for call in CALLS if call.split()[0] == function)
    expected = CALLS[name](m, q, v, a)
    plain = getattr(axode, function)
    monkeypatch.setattr(axode, function, lambda *args, **more: plain(*args, **more, threads=4))
    assert same(CALLS[name](m, q, v, a), expected)
    monkeypatch.setattr(axode, function, lambda *args, **more: plain(*args, **more, threads=0))
    with pytest.raises(ValueError, match="threads is 0; expected 1 or more"):
        CALLS[name](m, q, v, a)
