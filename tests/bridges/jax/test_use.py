"""Errors are sentences, compiled programs outlive models, numbers may have 32 bits; and threads and memory."""

import gc
import pickle
import resource
import subprocess
import sys
import threading
from pathlib import Path

import axode
import axode.jax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from axode.table import ROWS
from mechanisms import MECHANISMS, close, random_states
from properties import WITH, assert_same_or_refused, state

SOURCE = Path(__file__).resolve().parents[3]
ARM = MECHANISMS["arm"]
ZERO = np.zeros(7)


@pytest.mark.parametrize("call, error, sentence", [
    (lambda: axode.jax.inverse_dynamics(ARM, ZERO[:6], ZERO, ZERO), ValueError,
     r"q: expected shape \(\.\.\., 7\) with nq coordinates, got \(6,\)"),
    (lambda: axode.jax.inverse_dynamics(ARM, ZERO, 1.0, ZERO), ValueError, r"v: expected shape \(\.\.\., 7\)"),
    (lambda: axode.jax.rollout(ARM, ZERO, ZERO, ZERO, 0.1), ValueError, r"tau: expected shape \(\.\.\., K, 7\)"),
    (lambda: axode.jax.inverse_dynamics(ARM, np.zeros((2, 7)), np.zeros((3, 7)), ZERO), ValueError,
     r"the axes in front of q, v, a do not go together: \(2,\), \(3,\), \(\)"),
    (lambda: axode.jax.mass_matrix(ARM, ZERO.astype(np.float16)), TypeError, "q: expected numbers of float32 or float64, got float16"),
    (lambda: axode.jax.mass_matrix(ARM, ZERO.astype(complex)), TypeError, "q: .* got complex128"),
    (lambda: axode.jax.mass_matrix(ARM, None), TypeError, "q: expected an array of numbers, got NoneType"),
    (lambda: axode.jax.mass_matrix("arm7.toml", ZERO), TypeError, "m: expected a Model, got str"),
    (lambda: axode.jax.mass_matrix(ARM, ZERO, threads=0), ValueError, "threads is 0; expected 1 or more"),
    (lambda: axode.jax.jacobian(ARM, ZERO, "flansch"), Exception, "flange"),
    (lambda: axode.jax.jacobian(ARM, ZERO, 99), ValueError, "frame is 99; expected 0 to 9"),
    (lambda: axode.jax.jacobian(ARM, ZERO, 2.0), TypeError, "frame: expected a name or a number, got float"),
    (lambda: axode.jax.jacobian(ARM, ZERO, 2, "world"), ValueError, 'representation: .* got \'world\''),
    (lambda: axode.jax.jacobian(ARM, ZERO, 2, offset=[1, 2]), ValueError, r"offset: expected shape \(3,\) or \(4, 4\), got \(2,\)"),
    (lambda: axode.jax.rollout(ARM, ZERO, ZERO, ZERO[None], -1.0), ValueError, "step is -1.0; it must be finite and above 0"),
    (lambda: jax.jit(lambda h: axode.jax.rollout(ARM, ZERO, ZERO, ZERO[None], h))(0.1), TypeError, "step: expected a number"),
])
def test_bad_arguments_are_named(call, error, sentence):
    with pytest.raises(error, match=sentence):
        call()


@pytest.mark.parametrize("case", WITH)
def test_no_function_answers_for_another_mechanism(case):
    _, m = WITH[case]
    for name in {*axode.jax.__all__} & {*ROWS}:
        given = state(m, ROWS[name])
        assert_same_or_refused(name, lambda: getattr(axode.jax, name)(m, **given), lambda: getattr(axode, name)(m, **given))
    q, v, tau = (state(m, ROWS["forward_dynamics"])[key] for key in ("q", "v", "tau"))
    assert_same_or_refused("rollout", lambda: axode.jax.rollout(m, q, v, np.stack([tau, -tau]), 1e-3),
                           lambda: axode.rollout(m, q, v, np.stack([tau, -tau]), 1e-3, contact=False))


def test_gradients_of_what_is_of_the_tree_are_those_of_differences():
    _, m = WITH["rod"]
    given = state(m, ROWS["kinetic_energy"])
    by_q, by_v = jax.grad(axode.jax.kinetic_energy, (1, 2))(m, given["q"], given["v"])
    assert close(np.asarray(by_v), axode.momenta(m, **given))
    energies = axode.kinetic_energy(m, given["q"] + 1e-6 * np.vstack([np.eye(3), -np.eye(3)]), np.tile(given["v"], (6, 1)))
    assert close(np.asarray(by_q), (energies[:3] - energies[3:]) / 2e-6, 1e-8)


def test_a_quaternion_off_1_is_an_error_of_the_program():
    m = MECHANISMS["humanoid"]
    f = jax.jit(lambda q: axode.jax.gravity_torques(m, q))
    with pytest.raises(jax.errors.JaxRuntimeError, match='the quaternion of joint "free_base" has norm 1.01.*; it must be 1 to 1e-6'):
        f(m.neutral() * 1.01).block_until_ready()
    assert np.all(np.isfinite(f(m.neutral() * (1 + 9e-7))))


def test_parameters_that_no_body_has_are_an_error_of_the_program():
    with pytest.raises(jax.errors.JaxRuntimeError, match="mass is -.* a mass must be positive"):
        axode.jax.inverse_dynamics(ARM, ZERO, ZERO, ZERO, parameters=-ARM.parameters).block_until_ready()


def test_states_without_result_are_nan_and_others_are_not():
    q, v, tau, _ = random_states(ARM, 9)
    expected = axode.forward_dynamics(ARM, q, v, tau)
    q[3, 1], v[5, 0] = np.nan, 1e200
    found = np.asarray(axode.jax.forward_dynamics(ARM, q, v, tau))
    assert np.all(~np.isfinite(found[[3, 5]]).all(axis=1))
    assert np.array_equal(np.delete(found, [3, 5], axis=0), np.delete(expected, [3, 5], axis=0))
    gradient = np.asarray(jax.grad(lambda tau: jnp.sum(axode.jax.forward_dynamics(ARM, q, v, tau)[:3]))(tau))
    assert np.all(np.isfinite(gradient[:3]))

    m = MECHANISMS["humanoid"]
    q, v, tau, _ = random_states(m, 4)
    expected = axode.poses(m, q)
    q[1, 2] = np.nan
    found = np.asarray(axode.jax.poses(m, q))
    assert np.all(np.isnan(found[1, :, :3])) and np.array_equal(np.delete(found, 1, axis=0), np.delete(expected, 1, axis=0))
    motion = np.asarray(axode.jax.rollout(m, q, v, np.stack([tau, tau], axis=1), 1e-3)[0])
    assert np.all(np.isnan(motion[1])) and np.all(np.isfinite(np.delete(motion, 1, axis=0)))


def test_a_singular_mass_matrix_is_nan():
    m = (axode.Builder().body("a", joint={"kind": "prismatic", "axis": "x"}, mass=1, com=[0, 0, 0], inertia=[1, 1, 1])
         .body("b", on="a", joint={"kind": "prismatic", "axis": "x"}, mass=0, com=[0, 0, 0], inertia=[0, 0, 0]).build())
    for lead in ((), (3,), (20,)):
        zero = np.zeros((*lead, 2))
        assert np.all(np.isnan(axode.jax.forward_dynamics(m, zero, zero, zero)))
        assert np.all(np.isnan(axode.jax.inverse_mass_matrix(m, zero)))
        assert np.all(np.isnan(jax.vmap(jax.grad(lambda t: axode.jax.forward_dynamics(m, 0 * t, 0 * t, t)[0]))(np.zeros((3, 2)))))


def test_other_devices_are_refused():
    f = jax.jit(lambda q: axode.jax.mass_matrix(ARM, q))
    with pytest.raises(NotImplementedError, match="axode.jax computes on the CPU, and mass_matrix is to be run on cuda"):
        f.trace(ZERO).lower(lowering_platforms=("cuda",))


def test_programs_outlive_models():
    m = axode.load(axode.robots / "arm7.toml").with_gravity([0, 0, -1.25])
    expected = axode.gravity_torques(m, ZERO)
    f = jax.jit(lambda q, m=m: axode.jax.gravity_torques(m, q)).lower(ZERO).compile()
    del m
    jax.clear_caches()
    gc.collect()
    assert np.array_equal(f(ZERO), expected)


def test_programs_may_be_dropped_while_they_run():
    q, v, x, _ = random_states(ARM, 2000)
    for k in range(20):
        m = ARM.with_gravity([0, 0, -1 - 0.01 * k])
        found = jax.jit(lambda q: axode.jax.inverse_dynamics(m, q, v, x))(q)  # noqa: B023, F821
        del m
        jax.clear_caches()
        gc.collect()
        assert np.all(np.isfinite(found))


def test_models_are_let_go():
    before = len(axode.jax.mechanism._by_key)
    for k in range(20):
        m = ARM.with_gravity([0, 0, -1 - 0.01 * k])
        axode.jax.mass_matrix(m, ZERO)
    assert len(axode.jax.mechanism._by_key) > before
    del m
    jax.clear_caches()
    axode.jax.calls._compiled.cache_clear()
    gc.collect()
    assert len(axode.jax.mechanism._by_key) <= before


def test_equal_models_share_programs():
    traced = []

    def f(m, q):
        traced.append(m)
        return axode.jax.gravity_torques(m, q)

    again = pickle.loads(pickle.dumps(ARM))
    texts = {jax.jit(f, static_argnums=0).lower(m, ZERO).as_text() for m in (ARM, again)}
    assert len(texts) == 1 and len(traced) == 2
    other = jax.jit(f, static_argnums=0).lower(ARM.with_gravity([0, 0, -2]), ZERO).as_text()
    assert other not in texts


def test_float32():
    m = MECHANISMS["humanoid"]
    q, v, x, _ = random_states(m, 3)
    q32, v32, x32 = (each.astype(np.float32) for each in (q, v, x))
    found = axode.jax.forward_dynamics(m, q32, v32, x32)
    assert found.dtype == jnp.float32
    exact = axode.forward_dynamics(m, m.normalize(q32.astype(float)), v32.astype(float), x32.astype(float))
    assert np.array_equal(found, exact.astype(np.float32))
    f = lambda q: jnp.sum(axode.jax.inverse_dynamics(m, q, v32[0], x32[0]))  # noqa: E731
    gradient, H = jax.jit(lambda q: (jax.grad(f)(q), jax.hessian(f)(q)))(q32[0])
    assert gradient.dtype == H.dtype == jnp.float32
    by_v = axode.inverse_dynamics_vjp(m, q[0], v[0], x[0], np.ones(m.nv)).q
    assert close(m.coordinate_rates(q[0], v[0]) @ np.asarray(gradient, dtype=float), by_v @ v[0], 1e-4)
    motion = axode.jax.rollout(m, q32, v32, x32[:, None], 1e-3)
    assert motion[0].dtype == motion[1].dtype == jnp.float32
    assert axode.jax.mass_matrix(m, q).dtype == jnp.float64
    assert axode.jax.inverse_dynamics(ARM, [0] * 7, [0] * 7, np.zeros(7, np.float32)).dtype == jnp.float32


def test_without_64_bits():
    program = """
import axode, axode.jax, jax, numpy as np
arm = axode.load(axode.robots / "arm7.toml")
q = np.full(7, 0.3)
tau = axode.jax.inverse_dynamics(arm, q, q, q)
assert tau.dtype == np.float32 and np.allclose(tau, axode.inverse_dynamics(arm, q, q, q), rtol=1e-5, atol=1e-5)
H = jax.jit(jax.hessian(lambda q: axode.jax.inverse_dynamics(arm, q, q, q)[1]))(q)
assert H.dtype == np.float32 and H.shape == (7, 7)
assert axode.jax.rollout(arm, q, q, np.zeros((3, 7)), 0.01)[0].shape == (4, 7)
assert axode.jax.inverse_dynamics(arm, [0] * 7, [0] * 7, [0] * 7).dtype == np.float32
"""
    subprocess.run([sys.executable, "-c", program], check=True, env={"JAX_ENABLE_X64": "0", "JAX_PLATFORMS": "cpu"})


def test_threads_of_python():
    m = MECHANISMS["humanoid"]
    q, v, x, _ = random_states(m, 40)
    f = jax.jit(jax.vmap(lambda q, v, x: axode.jax.forward_dynamics(m, q, v, x, threads=2)))
    expected, wrong = axode.forward_dynamics(m, q, v, x), []

    def run():
        for _ in range(20):
            wrong.append(not np.array_equal(f(q, v, x), expected))

    threads = [threading.Thread(target=run) for _ in range(8)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert len(wrong) == 160 and not any(wrong)


def test_memory_does_not_grow():
    q, v, x, _ = random_states(ARM, 500)
    f = jax.jit(jax.grad(lambda q: jnp.sum(axode.jax.forward_dynamics(ARM, q, v, x))))

    def many():
        for _ in range(100):
            f(q).block_until_ready()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    many()
    first = many()
    assert many() - first < 10_000  # kB; results of 100 calls are 2,800


def test_the_declarations_are_those_of_jaxlib(tmp_path):
    """xla_ffi.hpp declares the same as c_api.h of jaxlib, member by member."""
    members = {
        ("Sized", "XLA_FFI_Buffer"): [("struct_size", "struct_size"), ("extensions", "extension_start")],
        ("Version", "XLA_FFI_Api_Version"): [("major", "major_version"), ("minor", "minor_version")],
        ("NewError", "XLA_FFI_Error_Create_Args"): [("message", "message"), ("code", "errc")],
        ("Api", "XLA_FFI_Api"): [("version", "api_version"), ("internal", "internal_api"), ("new_error", "XLA_FFI_Error_Create")],
        ("Buffer", "XLA_FFI_Buffer"): [("type", "dtype"), ("data", "data"), ("rank", "rank"), ("lengths", "dims")],
        ("Text", "XLA_FFI_ByteSpan"): [("data", "ptr"), ("size", "len")],
        ("Scalar", "XLA_FFI_Scalar"): [("type", "dtype"), ("value", "value")],
        ("Buffers", "XLA_FFI_Args"): [("size", "size"), ("kinds", "types"), ("all", "args")],
        ("Buffers ", "XLA_FFI_Rets"): [("size", "size"), ("kinds", "types"), ("all", "rets")],
        ("Attributes", "XLA_FFI_Attrs"): [("size", "size"), ("kinds", "types"), ("names", "names"), ("values", "attrs")],
        ("CallFrame", "XLA_FFI_CallFrame"): [("api", "api"), ("context", "ctx"), ("stage", "stage"), ("arguments", "args"),
                                             ("results", "rets"), ("attributes", "attrs")],
        ("Metadata", "XLA_FFI_Metadata"): [("version", "api_version"), ("traits", "traits")],
        ("MetadataRequest", "XLA_FFI_Metadata_Extension"): [("metadata", "metadata")],
        ("MetadataRequest ", "XLA_FFI_Extension_Base"): [("kind", "type"), ("next", "next")],
    }
    values = {"Type::boolean": "DataType_PRED", "Type::int64": "DataType_S64", "Type::float32": "DataType_F32",
              "Type::float64": "DataType_F64", "AttributeKind::scalar": "AttrType_SCALAR", "AttributeKind::text": "AttrType_STRING",
              "Stage::execute": "ExecutionStage_EXECUTE", "ErrorCode::invalid_argument": "Error_Code_INVALID_ARGUMENT",
              "ErrorCode::internal": "Error_Code_INTERNAL", "MetadataRequest::expected": "Extension_Metadata"}
    text = '#include "xla_ffi.hpp"\n#include "xla/ffi/api/c_api.h"\n'
    for (ours, theirs), pairs in members.items():
        for here, there in pairs:
            text += f"static_assert(offsetof(axode::xla::{ours.strip()}, {here}) == offsetof({theirs}, {there}));\n"
            text += f"static_assert(sizeof(axode::xla::{ours.strip()}::{here}) == sizeof({theirs}::{there}));\n"
    for ours, theirs in values.items():
        text += f"static_assert(static_cast<int>(axode::xla::{ours}) == XLA_FFI_{theirs});\n"
    text += ("static_assert(axode::xla::major_version == XLA_FFI_API_MAJOR);\n"
             "static_assert(axode::xla::first_minor_version <= XLA_FFI_API_MINOR);\n")
    (tmp_path / "beside.cpp").write_text(text)
    done = subprocess.run(["c++", "-std=c++20", "-fsyntax-only", "-Wno-invalid-offsetof", f"-I{SOURCE / 'python/bindings/support'}",
                           f"-I{jax.ffi.include_dir()}", tmp_path / "beside.cpp"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_dynamics_of_long_chains_take_no_matrix_of_their_bodies():
    chain = axode.Builder("chain")
    for k in range(3000):
        joint = {"kind": "revolute", "axis": "xyz"[k % 3], "point": [0, 0, 0.001 * k]}
        chain.body(f"b{k}", **({"on": f"b{k - 1}"} if k else {}), joint=joint, mass=1, com=[0, 0, 0.001 * k], inertia=[0.1, 0.1, 0.1])
    m = chain.build()
    q = np.full(m.nq, 1e-3)
    assert np.array_equal(axode.jax.inverse_dynamics(m, q, 0 * q, 0 * q), axode.inverse_dynamics(m, q, 0 * q, 0 * q))
    jax.vjp(lambda q: axode.jax.inverse_dynamics(m, q, 0 * q, 0 * q), q)[1](q)
    assert not {"moves_frame", "moves_screw", "screw_rates"} & set(vars(axode.jax.mechanism_of(m)))
