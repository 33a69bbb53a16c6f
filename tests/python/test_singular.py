"""Mass matrices that are singular to rounding are refused, and numbers that overflow cause an error and never a
silent NaN."""

import axode
import numpy as np
import pytest
from axode.table import ROWS
from calls import given_to, in_one
from mechanisms import MECHANISMS, REPRESENTATIONS, random_states

ARM = MECHANISMS["arm"]
SOLVED = ["forward_dynamics", "inverse_mass_matrix", "from_momenta", "momentum_form", "impulse_response"]


@pytest.mark.parametrize("way", ["fast", *REPRESENTATIONS])
@pytest.mark.parametrize("name", SOLVED)
def test_a_thin_rod_is_refused_with_its_states(name, way):
    row = ROWS[name]
    if way != "fast" and row.choice == "none" or way == "fast" and row.choice == "representation":
        pytest.skip("it has no such way")
    choice = {} if way == "fast" else {"representation": way}
    for k, R in enumerate(axode.lie.exp_SO3(np.random.default_rng(1).normal(size=(20, 3)))):
        Theta = R @ np.diag([1, 1, 0]) @ R.T
        m = axode.Model.from_bodies([{"name": "rod", "joint": {"kind": "free"}, "mass": 0.1, "com": [0, 0, 0],
                                      "inertia": [*np.diag(Theta), Theta[0, 1], Theta[0, 2], Theta[1, 2]]}])
        q, v, a, _ = random_states(m, 3, seed=k)
        for state in ((q, v, a), (q[0], v[0], a[0])):
            with pytest.raises(axode.SingularError) as refused:
                getattr(axode, name)(m, **(given_to(row, m, *state) | choice))
            assert refused.value.states == list(range(len(state[0]) if state[0].ndim == 2 else 1))
            assert np.isnan(refused.value.result).all()


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if "v" in row.arrays
                                  and name != "motion_derivatives"])  # whose error has its matrices on their side
def test_numbers_that_overflow_are_an_error_and_the_others_are_right(name):
    q, x, _, _ = random_states(ARM, 20)
    many = x.copy()
    many[3] = 1e200
    many[11] = -1e200

    def call(x, *which):
        state = [each[which] for each in (q, x, x)]
        return in_one(getattr(axode, name)(ARM, **given_to(ROWS[name], ARM, *state)), state[0])

    expected, others = call(x, ...), np.delete(np.arange(20), [3, 11])
    try:
        found = call(many, ...)
    except axode.NotFiniteError as error:
        refused = error
    else:  # numbers of 1e200 overflow in products only
        assert np.isfinite(found).all() and np.array_equal(found[others], expected[others])
        return
    assert str(refused).startswith("state 3 and 1 other: ")
    assert refused.states == [3, 11]
    assert np.array_equal(refused.result[others], expected[others])
    with pytest.raises(axode.NotFiniteError, match="not finite|overflow"):
        call(many, 3)


def test_offsets_that_overflow_are_an_error():
    with pytest.raises(axode.NotFiniteError, match="not finite|overflow"):
        axode.jacobian_rate(ARM, np.zeros(7), np.full(7, 1e200), "flange", offset=[1e200, 0, 0])
    with pytest.raises(axode.NotFiniteError, match="^state 1: "):
        axode.twist_derivatives(ARM, np.zeros((2, 7)), [[np.ones(7)] * 2, [np.full(7, 1e200)] * 2], "flange")
