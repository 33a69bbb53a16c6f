"""axode.torch: its values equal those of the library, its gradients those of differences, and its operations have the
properties that PyTorch requires."""

import copy
import doctest
import gc
import io
import json
import os
import pickle
import re
import resource
import subprocess
import sys
import threading
import warnings
import weakref
from pathlib import Path

import axode
import numpy as np
import pytest
import torch
from axode.table import ROWS
from mechanisms import MECHANISMS, random_states
from pages import SOURCE, run_page
from properties import WITH, assert_same_or_refused, state
from torch.autograd import gradcheck, gradgradcheck
from torch.func import grad, hessian, jacfwd, jacrev, vmap
from torch.library import opcheck

warnings.filterwarnings("ignore", category=FutureWarning, module="torch")
torch.set_num_threads(1)
ARM = MECHANISMS["arm"]


def solid(m):
    """The same mechanism with more mass and inertia in every body, so that no mass matrix is so nearly singular that
    differences are inexact."""
    more = np.tile([1.0, 0, 0, 0, 0.1, 0.1, 0.1, 0, 0, 0], m.n_bodies)
    return m.with_parameters(m.parameters + more)


SOLID = {name: solid(m) for name, m in MECHANISMS.items()}
FUNCTIONS = {"inverse_dynamics": ("v", "a"), "forward_dynamics": ("v", "tau"), "mass_matrix": (), "inverse_mass_matrix": (),
             "kinetic_energy": ("v",), "potential_energy": (), "center_of_mass": (), "poses": (), "jacobian": ()}
WITH_PARAMETERS = [name for name in FUNCTIONS if name not in ("poses", "jacobian")]
every_mechanism = pytest.mark.parametrize("mechanism", MECHANISMS)
every_function = pytest.mark.parametrize("name", FUNCTIONS)


def states(m, *lead, seed=1, dtype=torch.float64):
    q, *others = random_states(m, int(np.prod(lead)), seed)
    return [torch.tensor(x).reshape(*lead, x.shape[-1]).to(dtype) for x in (q, *others)]


def arguments_of(name, m, *lead, **options):
    return states(m, *lead, **options)[:1 + len(FUNCTIONS[name])]


def function(name, m):
    """Of tensors alone."""
    of = getattr(axode.torch, name)
    if name == "jacobian":
        frame = m.frame_names[-1]
        return lambda q: of(m, q, frame, "hybrid")
    return lambda *arguments, **options: of(m, *arguments, **options)


def by_library(name, m, *arguments):
    more = (m.frame_names[-1], "hybrid") if name == "jacobian" else ()
    return getattr(axode, name)(m, *arguments, *more)


def leaves(arguments):
    return [x.clone().requires_grad_() for x in arguments]


def close(x, y, tolerance=1e-11):
    return x.shape == y.shape and (x - y).abs().max() <= tolerance * y.abs().max()


# Values

@every_mechanism
@every_function
def test_values_are_those_of_the_library(mechanism, name):
    m = MECHANISMS[mechanism]
    arguments = arguments_of(name, m, 5)
    of_library = torch.tensor(by_library(name, m, *map(np.asarray, arguments)))
    assert close(function(name, m)(*arguments), of_library)
    assert close(function(name, m)(*(x[2] for x in arguments)), of_library[2])


@every_function
def test_axes_in_front_are_any_and_broadcast(name):
    m = MECHANISMS["humanoid"]
    q, *others = arguments_of(name, m, 2, 3)
    f, flat = function(name, m), [x.flatten(0, 1) for x in (q, *others)]
    assert close(f(q, *others), f(*flat).unflatten(0, (2, 3)))
    assert close(f(q, *(x[0] for x in others)), f(q, *(x[:1].expand(2, 3, -1) for x in others)))
    assert close(f(q.transpose(0, 1), *(x.transpose(0, 1) for x in others)), f(q, *others).transpose(0, 1))
    assert f(q[:, :0], *(x[:, :0] for x in others)).shape == (2, 0, *f(q, *others).shape[2:])


@every_function
def test_gradients_of_no_states_are_empty(name):
    arguments = leaves(x[:0] for x in arguments_of(name, ARM, 1))
    function(name, ARM)(*arguments).sum().backward()
    assert all(x.grad.shape == x.shape for x in arguments)


@every_mechanism
@every_function
def test_float32_is_the_same_to_its_precision(mechanism, name):
    m = SOLID[mechanism]
    arguments = leaves(arguments_of(name, m, 4, dtype=torch.float32))
    exact = leaves(x.detach().double() for x in arguments)
    single, double = (function(name, m)(*x) for x in (arguments, exact))
    assert single.dtype == torch.float32 and close(single.double(), double, 1e-5)
    for x, y in zip(torch.autograd.grad(single.sum(), arguments), torch.autograd.grad(double.sum(), exact)):
        assert x.dtype == torch.float32 and close(x.double(), y, 1e-4)


@every_mechanism
def test_rollout_is_that_of_the_library(mechanism):
    m = MECHANISMS[mechanism]
    q, v, tau, _ = states(m, 2)
    tau = 1e-3 * tau[:, None].expand(2, 3, m.nv)
    for ours, theirs in zip(axode.torch.rollout(m, q, v, tau, 1e-3), axode.rollout(m, *map(np.asarray, (q, v, tau)), 1e-3)):
        assert close(ours, torch.tensor(theirs))
    path, _ = axode.torch.rollout(m, q, v, tau[:, :0], 1e-3)
    assert close(path, q[:, None])
    one, _ = axode.torch.rollout(m, q, v, tau[0, :2], 1e-3)
    assert one.shape == (2, 3, m.nq)


# Gradients

@every_mechanism
@every_function
def test_gradients_are_those_of_differences_and_so_are_second_ones(mechanism, name):
    m = SOLID[mechanism]
    arguments = leaves(arguments_of(name, m, 2))
    slowly = mechanism == "machine" and name in ("forward_dynamics", "inverse_dynamics", "center_of_mass")
    assert gradcheck(function(name, m), arguments, eps=1e-7, atol=1e-4, rtol=1e-5, fast_mode=not slowly)
    assert gradgradcheck(function(name, m), arguments, eps=1e-7, atol=1e-4, rtol=1e-5, fast_mode=True)


#: Two balls on a floor: one slides, and one meets it.
TABLE = axode.Model.from_dict({
    "format": "axode drawing 1", "shape": [{"kind": "plane", "role": "collision", "friction": 0.3}],
    "body": [{"name": name, "joint": "free", "mass": 1, "com": [0.01, 0, 0.02], "inertia": [4e-3, 5e-3, 6e-3], "shape": [
        {"kind": "sphere", "role": "collision", "radius": 0.1, "friction": 0.3, "restitution": 0.5}]} for name in ("slider", "bouncer")]})
ON_TABLE = [torch.tensor(np.array(x, dtype=float)) for x in (
    [0, 0, 0, 1, 0, 0, 0.1, 0, 0, 0.6, 0.8, 1, 0, 0.1035], [1, 0, 2, 1.5, 0.5, 0, 0.5, 1, 0, 0.5, 0, -1.0], np.full((2, 12), 0.05),
    1.1 * TABLE.parameters, [0.2, 0.4, 0.3], [0.1, 0.5, 0.4], 0.01 * np.sin(np.arange(18)))]


def contact_motion(*x):
    return axode.torch.contact_rollout(TABLE, *x[:3], 5e-3, **dict(zip(("parameters", "friction", "restitution", "placement"), x[3:])))


def test_motions_with_contact_have_first_derivatives_by_parameters():
    numbers = [x.numpy() for x in ON_TABLE]
    changed = axode.with_shapes(TABLE.with_parameters(numbers[3]), friction=numbers[4], restitution=numbers[5],
                                placement=numbers[6].reshape(3, 6))
    expected = axode.rollout(changed, *numbers[:3], 5e-3, joint_losses=True, contact=True)
    for ours, theirs in zip(contact_motion(*ON_TABLE), expected[:2]):
        assert close(ours, torch.tensor(theirs), 1e-12)
    assert gradcheck(contact_motion, leaves(ON_TABLE), eps=1e-7, atol=1e-4, rtol=1e-5, fast_mode=True, check_forward_ad=True)
    two = [torch.stack([x, x]) for x in ON_TABLE[:3]]
    assert close(vmap(contact_motion)(*two)[0][1], contact_motion(*ON_TABLE[:3])[0])


def test_distances_of_shapes_have_first_derivatives():
    m = axode.load(axode.robots / "quadruped.toml")
    pairs = axode.shape_pairs(m)[:5]
    q = torch.tensor(m.random(seed=3, n=4)).reshape(2, 2, m.nq).requires_grad_()
    f = lambda q: axode.torch.pair_distances(m, q, pairs)  # noqa: E731
    assert close(f(q).reshape(4, 5), torch.tensor(axode.pair_distances(m, q.detach().reshape(4, m.nq), pairs).distances), 1e-14)
    assert axode.torch.pair_distances(m, q).shape == (2, 2, len(axode.shape_pairs(m)))
    assert gradcheck(f, (q,), eps=1e-7, atol=1e-5)
    assert close(jacfwd(f)(q[0, 0]), jacrev(f)(q[0, 0])) and close(vmap(f)(q), f(q))
    with pytest.raises(NotImplementedError, match="axode.torch has no derivatives of pair jacobians"):
        torch.autograd.grad(torch.autograd.grad(f(q).sum(), q, create_graph=True)[0].sum(), q)


@every_mechanism
@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_gradients_by_parameters_are_those_of_differences(mechanism, name):
    m, f = SOLID[mechanism], function(name, SOLID[mechanism])
    arguments = leaves(arguments_of(name, m, 2))
    for pi in (torch.tensor(m.parameters), torch.tensor(m.parameters) * torch.tensor([[1.0], [1.1]])):
        assert gradcheck(lambda pi, *x: f(*x, parameters=pi), [pi.requires_grad_(), *arguments], eps=1e-7, atol=1e-4,
                         rtol=1e-5, fast_mode=True)


@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_parameters_may_differ_from_state_to_state(name):
    f, arguments = function(name, ARM), arguments_of(name, ARM, 2, 3)
    heavier = ARM.with_parameters(1.2 * ARM.parameters)
    pi = torch.tensor(ARM.parameters) * torch.tensor([1, 1.2, 1], dtype=torch.float64)[:, None]
    found = f(*arguments, parameters=pi)
    assert close(found[:, 1], function(name, heavier)(*(x[:, 1] for x in arguments)))
    assert close(found[:, 2], f(*(x[:, 2] for x in arguments)))


@every_mechanism
def test_the_gradient_by_parameters_is_the_regressor(mechanism):
    m = MECHANISMS[mechanism]
    q, v, a, w = states(m, 3)
    pi = torch.tensor(m.parameters).requires_grad_()
    gradient, = torch.autograd.grad(axode.torch.inverse_dynamics(m, q, v, a, parameters=pi), pi, w)
    Y = torch.tensor(axode.regressor(m, *map(np.asarray, (q, v, a))))
    assert close(gradient, torch.einsum("ni,nij->j", w, Y))


@every_mechanism
def test_gradients_of_rollouts_are_those_of_differences(mechanism):
    m = SOLID[mechanism]
    q, v, tau, _ = states(m, 2)
    arguments = leaves([q, v, tau[:, None].expand(2, 3, m.nv)])
    assert gradcheck(lambda *x: axode.torch.rollout(m, *x, 1e-2), arguments, eps=1e-7, atol=1e-4, rtol=1e-5, fast_mode=True)


@every_mechanism
@every_function
def test_transforms_agree_with_each_other(mechanism, name):
    m, f = SOLID[mechanism], function(name, SOLID[mechanism])
    q, *others = arguments_of(name, m, 2)

    def at(k, of=f):
        return lambda q: of(q, *(x[k] for x in others))

    assert torch.equal(vmap(f)(q, *others), f(q, *others))
    assert torch.equal(vmap(at(0), in_dims=1)(q.T), f(q, *(x[:1].expand_as(x) for x in others)))
    assert close(jacfwd(at(0))(q[0]), jacrev(at(0))(q[0]), 1e-9)

    def loss(*x):
        return f(*x).square().sum()

    each = vmap(grad(loss))(q, *others)
    x = q.clone().requires_grad_()
    assert close(each, torch.autograd.grad(loss(x, *others), x)[0], 1e-9)
    assert close(hessian(at(1, loss))(q[1]), jacrev(jacrev(at(1, loss)))(q[1]), 1e-8)


@pytest.mark.parametrize("m", [SOLID["arm"], SOLID["humanoid"].reduced(SOLID["humanoid"].joint_names[4:], SOLID["humanoid"].neutral())],
                         ids=["arm", "humanoid without knees"])
def test_forward_mode_by_parameters_and_of_rollouts(m):
    q, v, a, _ = states(m)
    pi = torch.tensor(m.parameters)
    for name, x in {"inverse_dynamics": (q, v, a), "forward_dynamics": (q, v, a), "mass_matrix": (q,),
                    "kinetic_energy": (q, v), "potential_energy": (q,)}.items():
        def f(pi, name=name, x=x):
            return getattr(axode.torch, name)(m, *x, parameters=pi)

        assert close(jacfwd(f)(pi), jacrev(f)(pi), 1e-9)
    tau = torch.zeros(3, m.nv, dtype=torch.float64)
    for end in (0, 1):
        def last(q, tau, end=end):
            return axode.torch.rollout(m, q, v, tau, 1e-2)[end][-1]

        for k in (0, 1):
            assert close(jacfwd(last, k)(q, tau), jacrev(last, k)(q, tau), 1e-9)


def test_a_batch_of_parameters_is_a_loop_over_them():
    q, v, a, _ = states(ARM, 3)
    pi = torch.tensor(ARM.parameters) * torch.tensor([[1.0], [1.1]])
    together = vmap(lambda pi: axode.torch.inverse_dynamics(ARM, q, v, a, parameters=pi))(pi)
    assert torch.equal(together, torch.stack([axode.torch.inverse_dynamics(ARM, q, v, a, parameters=own) for own in pi]))


def test_only_what_is_needed_is_computed(monkeypatch):
    called = []
    call = axode.torch.mechanism.Mechanism.__call__
    monkeypatch.setattr(axode.torch.mechanism.Mechanism, "__call__", lambda self, name, *x: called.append(name) or call(self, name, *x))
    q, v, a, w = states(ARM)
    pi = torch.tensor(ARM.parameters)
    axode.torch.inverse_dynamics(ARM, q, v, a, parameters=pi)
    assert called == ["inverse_dynamics"]
    tau = axode.torch.inverse_dynamics(ARM, q, v.requires_grad_(), a, parameters=pi)
    called.clear()
    tau.sum().backward()
    assert called == ["inverse_dynamics_vjp"] and q.grad is None and a.grad is None
    tau = axode.torch.inverse_dynamics(ARM, q, v.detach(), a, parameters=pi.requires_grad_())
    called.clear()
    tau.sum().backward()
    assert "inverse_dynamics_vjp" not in called and set(called) == {"twists", "accelerations", "poses"}


def test_quaternions_count_by_their_direction():
    m = MECHANISMS["humanoid"]
    q, v, a, _ = states(m)
    q.requires_grad_()
    axode.torch.inverse_dynamics(m, q, v, a).square().sum().backward()
    assert abs(torch.dot(q.grad[:4], q[:4])) < 1e-9 * q.grad[:4].norm()
    along = axode.inverse_dynamics_vjp(m, *(x.detach().numpy() for x in (q, v, a)),
                                       2 * axode.torch.inverse_dynamics(m, q, v, a).detach().numpy()).q
    rates = torch.tensor(m.coordinate_rates(q.detach().numpy(), v.numpy()))
    assert torch.dot(q.grad, rates).item() == pytest.approx(along @ v.numpy())


# What PyTorch asks of operations

def operations():
    """The operations, each with arguments that require gradients if it has gradients."""
    key = axode.torch.handle(ARM)
    q, v, a, w = leaves(states(ARM, 2))
    pi = torch.tensor(ARM.parameters).expand(2, -1).clone().requires_grad_()
    W = torch.ones(2, len(ARM.frame_names), 6, dtype=torch.float64).requires_grad_()
    tau, w_q = (torch.ones(2, n, 7, dtype=torch.float64).requires_grad_() for n in (3, 4))
    o = torch.ops.axode
    for dynamics in (o.inverse_dynamics, o.forward_dynamics):
        yield dynamics, (key, q, v, a, None)
        yield dynamics, (key, q, v, a, pi)
        name = dynamics._qualified_op_name.partition("::")[2]
        yield getattr(o, name + "_vjp"), (key, q, v, a, None, w)
        yield getattr(o, name + "_jvp"), (key, q, v, a, None, w, w, w)
        yield getattr(o, name + "_hessian"), (key, True, *(x.detach() for x in (q, v, a, pi, w, w, w, w)))
    yield o.inverse_dynamics_parameters_vjp, (key, *(x.detach() for x in (q, v, a, w)))
    yield o.inverse_dynamics_parameters_jvp, (key, *(x.detach() for x in (q, v, a, pi)))
    yield o.mass_matrix, (key, q, pi)
    yield o.inverse_mass_matrix, (key, q, None)
    yield o.potential_energy, (key, q, pi)
    yield o.poses, (key, q)
    robot = axode.load(axode.robots / "quadruped.toml")
    of_robot = (axode.torch.handle(robot), json.dumps(axode.shape_pairs(robot)[:2]), torch.tensor(robot.random(seed=1, n=2)))
    yield o.pair_jacobians, of_robot
    yield o.pair_distances, (*of_robot[:2], of_robot[2].clone().requires_grad_())
    on_table = axode.torch.handle(TABLE), 5e-3, json.dumps([["parameters", 20]]), *(x[None] for x in ON_TABLE[:4])
    yield o.contact_rollout_matrices, on_table
    yield o.contact_rollout, (*on_table[:3], *(x.clone().requires_grad_() for x in on_table[3:]))
    yield o.twists, (key, q, v)
    yield o.generalized_loads, (key, q, W)
    yield o.load_product, (key, True, q.detach(), W.detach(), v.detach())
    yield o.jacobian_partials, (key, 1, "body", 1, q)
    yield o.rollout, (key, 1e-3, q, v, tau)
    yield o.rollout_vjp, (key, 1e-3, *(x.detach() for x in (q, v, tau, w_q, w_q)))
    yield o.rollout_jvp, (key, 1e-3, *(x.detach() for x in (q, v, tau, q, v, tau)))


@pytest.mark.parametrize("operation, arguments", list(operations()), ids=lambda x: getattr(x, "__name__", ""))
def test_operations_are_as_pytorch_wants_them(operation, arguments):
    opcheck(operation.default, arguments)


def test_there_are_no_operations_but_these():
    known = {name.partition("::")[2] for name in torch._C._dispatch_get_all_op_names() if name.startswith("axode::")}
    assert known == {operation._qualified_op_name.partition("::")[2] for operation, _ in operations()}


def test_operations_have_gradients_without_the_module_too():
    m = MECHANISMS["humanoid"]
    q, v, a, w = leaves(states(m, 2))
    directly = torch.ops.axode.inverse_dynamics(axode.torch.handle(m), q, v, a, None)
    ours = axode.torch.inverse_dynamics(m, q, v, a)
    for x, y in zip(torch.autograd.grad(directly, (q, v, a), w), torch.autograd.grad(ours, (q, v, a), w)):
        assert torch.equal(x, y)


def test_compiled_functions_are_the_same():
    m = MECHANISMS["humanoid"]

    def loss(m, q, v, a, pi):
        tau = axode.torch.inverse_dynamics(m, q, v, a, parameters=pi)
        return tau.square().mean() + axode.torch.poses(m, q)[..., -1, :3, 3].square().mean()

    compiled = torch.compile(loss, fullgraph=True, backend="aot_eager")
    arguments = leaves([*states(m, 2)[:3], torch.tensor(m.parameters)])
    assert close(compiled(m, *arguments), loss(m, *arguments))
    for x, y in zip(torch.autograd.grad(compiled(m, *arguments), arguments), torch.autograd.grad(loss(m, *arguments), arguments)):
        assert close(x, y)


def test_compiling_goes_all_the_way():
    compiled = torch.compile(axode.torch.inverse_dynamics, fullgraph=True)
    q, v, a, w = leaves(states(ARM, 2))
    for x, y in zip(torch.autograd.grad(compiled(ARM, q, v, a), (q, v, a), w),
                    torch.autograd.grad(axode.torch.inverse_dynamics(ARM, q, v, a), (q, v, a), w)):
        assert close(x, y)


def test_a_compiled_function_knows_which_model_it_is_called_with():
    compiled = torch.compile(axode.torch.center_of_mass, fullgraph=True, backend="eager")
    models = [ARM, ARM.with_parameters(np.ravel(ARM.parameters.reshape(-1, 10) * np.arange(1, 8)[:, None])),
              MECHANISMS["humanoid"], ARM]
    for m in models:
        q = states(m, 2)[0]
        assert close(compiled(m, q), axode.torch.center_of_mass(m, q))


def test_all_functions_compile():
    for name in FUNCTIONS:
        arguments = leaves(arguments_of(name, ARM, 2))
        f = function(name, ARM)
        compiled = torch.compile(f, fullgraph=True, backend="eager")
        for x, y in zip(torch.autograd.grad(compiled(*arguments).sum(), arguments),
                        torch.autograd.grad(f(*arguments).sum(), arguments)):
            assert close(x, y), name


class Forces(torch.nn.Module):
    def forward(self, q, v):
        return axode.torch.inverse_dynamics(ARM, q, v, v)


def test_exported_programs_are_the_same_for_other_batches():
    N = torch.export.Dim("N", min=2)
    q, v, _, _ = states(ARM, 3)
    program = torch.export.export(Forces(), (q, v), dynamic_shapes=({0: N}, {0: N}))
    file = io.BytesIO()
    torch.export.save(program, file)
    file.seek(0)
    q, v, _, _ = states(ARM, 5)
    assert torch.equal(torch.export.load(file).module()(q, v), Forces()(q, v))


# Models

def test_models_alike_share_a_handle_and_others_do_not():
    for m in MECHANISMS.values():
        assert axode.torch.handle(m) == axode.torch.handle(pickle.loads(pickle.dumps(m))) == axode.torch.handle(copy.copy(m))
        assert axode.torch.handle(m) != axode.torch.handle(m.with_gravity([0, 0, -1.62]))
        assert axode.torch.handle(m).startswith(m.name)


def test_a_model_is_kept_while_a_graph_needs_it_and_no_longer():
    q, v, a, w = states(ARM)
    own = ARM.with_gravity([0, 0, -3.0])
    key = axode.torch.handle(own)
    expected = axode.inverse_dynamics_vjp(own, *map(np.asarray, (q, v, a, w))).v
    tau = axode.torch.inverse_dynamics(own, q, v.requires_grad_(), a)
    kept = weakref.ref(axode.torch.mechanism._mechanisms[key])
    del own
    for k in range(axode.torch.mechanism.KEPT + 1):  # so many others are used
        axode.torch.handle(ARM.with_gravity([0, 0, -4 - k]))
    gc.collect()
    assert kept() is not None
    gradient, = torch.autograd.grad(tau, v, w)
    assert torch.equal(gradient, torch.tensor(expected))
    del tau
    gc.collect()
    assert kept() is None
    with pytest.raises(KeyError, match=re.escape(f"no model '{key}'; axode.torch.handle(m) registers one")):
        torch.ops.axode.inverse_dynamics(key, q, v, a, None)


def test_memory_does_not_grow_over_10_000_calls():
    q, v, a, _ = leaves(states(ARM))

    def use(n):
        for k in range(n):
            tau = axode.torch.inverse_dynamics(ARM, q, v, a)
            if k % 10 == 0:
                tau.sum().backward()
            if k % 10 == 1:
                axode.torch.potential_energy(ARM.with_gravity([0, 0, -5.0 - k]), q)
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # KiB, the largest there was

    before = use(3000)  # which has filled the places for models
    assert use(10_000) - before < 5000


def test_threads_may_share_a_model():
    q, v, a, _ = states(ARM, 200)
    expected = function("forward_dynamics", ARM)(q, v, a)
    results = {}

    def run(k):
        x = q.clone().requires_grad_()
        found = axode.torch.forward_dynamics(ARM, x, v, a)
        found.sum().backward()
        results[k] = found.detach(), x.grad

    threads = [threading.Thread(target=run, args=(k,)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 8
    assert all(torch.equal(found, expected) and torch.equal(gradient, results[0][1]) for found, gradient in results.values())


class Torques(torch.utils.data.Dataset):
    """A dataset of torques whose items a worker process computes."""

    def __init__(self, m):
        self.m = m

    def __len__(self):
        return 4

    def __getitem__(self, k):
        q, v, a, _ = states(self.m, 100, seed=k)
        return axode.torch.inverse_dynamics(self.m, q, v, a)


def test_workers_of_a_loader_use_models():
    data = Torques(ARM)
    loader = torch.utils.data.DataLoader(data, num_workers=1)  # forked
    for k, batch in enumerate(loader):
        assert torch.equal(batch[0], data[k])


def test_specialised_models_serve_as_well():
    functions = ["inverse_dynamics", "inverse_dynamics_vjp", "mass_matrix", "forward_dynamics"]
    q, v, a, w = states(ARM, 3)
    for scalar, dtype, tolerance in (("float64", torch.float64, 1e-11), ("float32", torch.float32, 1e-5)):
        fast = ARM.specialise(functions, scalar, flags=["-O1"])
        x = leaves(x.to(dtype) for x in (q, v, a))
        tau = axode.torch.inverse_dynamics(fast, *x)
        assert tau.dtype == dtype and close(tau.double(), function("inverse_dynamics", ARM)(q, v, a), tolerance)
        found = torch.autograd.grad(tau, x, w.to(dtype), create_graph=True)
        vjp = axode.inverse_dynamics_vjp(ARM, *map(np.asarray, (q, v, a, w)))
        assert all(close(g.double(), torch.tensor(y), 20 * tolerance) for g, y in zip(found, vjp))
        second, = torch.autograd.grad(found[0].sum(), x[0])  # which it was made without
        assert torch.isfinite(second).all() and second.any()
        assert close(axode.torch.mass_matrix(fast, q), axode.torch.mass_matrix(ARM, q), tolerance)
        assert close(axode.torch.center_of_mass(fast, q), axode.torch.center_of_mass(ARM, q))
        forces = torch.ones(3, 20, 7, dtype=dtype)
        path = axode.torch.rollout(fast, *x[:2], forces, 1e-3)
        assert all(np.array_equal(x.detach(), y) for x, y in zip(
            path, axode.rollout(fast, *(x.numpy() for x in (*(x.detach() for x in x[:2]), forces)), 1e-3)))
    with pytest.raises(ValueError, match="compiled with its own parameters"):
        axode.torch.inverse_dynamics(fast, q, v, a, parameters=torch.tensor(ARM.parameters))


def test_loops_are_counted_or_refused():
    m = axode.load(axode.robots / "four_bar.toml")
    q, v = (torch.tensor(x) for x in axode.assemble(m, m.neutral(), np.zeros(3)))
    tau = torch.tensor([0.1, 0.0, 0.0], dtype=torch.float64)
    found = axode.torch.forward_dynamics(m, q, v, tau.requires_grad_())
    assert np.array_equal(found.detach(), axode.forward_dynamics(m, *(x.detach().numpy() for x in (q, v, tau))))
    derivatives = axode.forward_dynamics_derivatives(m, *(x.detach().numpy() for x in (q, v, tau)))
    assert close(torch.autograd.grad(found.sum(), tau)[0], torch.tensor(derivatives.tau.sum(axis=0)))
    for name in ("inverse_dynamics", "rollout"):
        arguments = (q, v, v) if name == "inverse_dynamics" else (q, v, tau[None], 1e-3)
        with pytest.raises(ValueError, match=f'{name} does not count loops, and model "four-bar" has 1'):
            getattr(axode.torch, name)(m, *arguments)
    for name in ("mass_matrix", "kinetic_energy", "potential_energy", "center_of_mass", "poses"):
        x = leaves(arguments_of(name, m))
        assert gradcheck(function(name, m), x, eps=1e-7, atol=1e-4, fast_mode=True), name


@pytest.mark.parametrize("case", WITH)
def test_no_function_answers_for_another_mechanism(case):
    _, m = WITH[case]
    for name in {*FUNCTIONS} & {*ROWS} - {"jacobian"}:
        given = state(m, ROWS[name])
        assert_same_or_refused(name, lambda: getattr(axode.torch, name)(m, *map(torch.tensor, given.values())),
                               lambda: getattr(axode, name)(m, **given))
    q, v, tau = (state(m, ROWS["forward_dynamics"])[key] for key in ("q", "v", "tau"))
    assert_same_or_refused("rollout", lambda: axode.torch.rollout(m, *map(torch.tensor, (q, v, np.stack([tau, -tau]))), 1e-3),
                           lambda: axode.rollout(m, q, v, np.stack([tau, -tau]), 1e-3, contact=False))


@pytest.mark.parametrize("joint", [{"kind": "planar", "axis": "z", "point": [0, 0, 0]},
                                   {"kind": "spherical", "point": [0, 0, 0]}, {"kind": "free"}], ids=lambda joint: joint["kind"])
def test_a_model_with_a_single_joint_has_gradients_by_its_coordinates(joint):
    m = axode.Model.from_bodies([{"name": "block", "joint": joint, "mass": 1, "com": [0.1, 0, 0.2], "inertia": [1, 2, 2]}])
    x = leaves(states(m, 2)[:3])
    assert gradcheck(function("inverse_dynamics", m), x, eps=1e-7, atol=1e-4, rtol=1e-5)


def test_a_model_without_joints_has_empty_results():
    m = ARM.reduced(ARM.joint_names, ARM.neutral())
    none = torch.zeros(3, 0, dtype=torch.float64, requires_grad=True)
    assert axode.torch.inverse_dynamics(m, none, none, none).shape == (3, 0)
    assert axode.torch.mass_matrix(m, none).shape == (3, 0, 0)
    axode.torch.poses(m, none).sum().backward()


# Errors

def test_what_is_wrong_is_said_in_a_sentence():
    q, v, a, _ = states(ARM, 4)
    humanoid = MECHANISMS["humanoid"]
    f = axode.torch.inverse_dynamics
    longer = states(humanoid)[0]
    longer[:4] *= 1.01
    of_humanoid = states(humanoid)[1:3]
    for call, kind, sentence in [
        (lambda: f(ARM, q, v, a[:, :6]), ValueError, "a: expected shape (..., 7), nv numbers, got (4, 6)"),
        (lambda: f(ARM, q, v, torch.tensor(1.0, dtype=torch.float64)), ValueError, "a: expected shape (..., 7), nv numbers, got ()"),
        (lambda: f(ARM, q, v.numpy(), a), ValueError, "v: expected a tensor, got ndarray"),
        (lambda: f(ARM, q, v.int(), a), ValueError, "v: expected a tensor of float64 or float32, got torch.int32"),
        (lambda: f(ARM, q, v.float(), a), ValueError, "v is of torch.float32 and q of torch.float64; expected one type for all"),
        (lambda: f(ARM, q.to("meta"), v, a), ValueError,
         "q is on the device meta; axode computes on the CPU, where q.cpu() takes it"),
        (lambda: f(ARM, q, v.to_sparse(), a), ValueError, "v: expected a dense tensor, got torch.sparse_coo"),
        (lambda: f(ARM, q, v[:3], a), ValueError,
         "the axes in front of the last do not broadcast: q (4, 7), v (3, 7), a (4, 7)"),
        (lambda: f(ARM, q, v, a, parameters=torch.ones(7, 10, dtype=torch.float64)), ValueError,
         "parameters: expected shape (..., 70), ten numbers for each body, got (7, 10)"),
        (lambda: f(ARM, q, v, a, parameters=-torch.tensor(ARM.parameters)), axode.ModelError, "a mass must be positive"),
        (lambda: f("arm", q, v, a), TypeError, "m: expected an axode.Model, or a specialised model from Model.specialise, got str"),
        (lambda: f(ARM, q, v, a / 0), ValueError, "expected finite numbers"),
        (lambda: f(humanoid, longer, *of_humanoid), ValueError,
         'q: the quaternion of joint "free_base" has norm 1.01; it must be 1 to 1e-06'),
        (lambda: axode.torch.inverse_dynamcs, AttributeError, "no attribute 'inverse_dynamcs'; did you mean 'inverse_dynamics'?"),
        (lambda: f(ARM, q, v, a, parameter=q), TypeError,
         "inverse_dynamics has no argument 'parameter'; did you mean 'parameters'?"),
        (lambda: f(ARM, q, v), TypeError, "inverse_dynamics needs 'a' as well"),
        (lambda: axode.torch.jacobian(ARM, q, "flang"), KeyError, "did you mean"),
        (lambda: axode.torch.jacobian(ARM, q, "flange", "world"), ValueError, "representation is 'world'"),
        (lambda: axode.torch.rollout(ARM, q, v, a[0], 1e-3), ValueError, "tau: expected a tensor of shape (..., K, nv)"),
        (lambda: axode.torch.inertial_parameters(q), ValueError, "P: expected a tensor of shape (..., 4, 4)"),
        (lambda: axode.torch.rollout(ARM, q, v, a[:, None], torch.tensor(1.0, requires_grad=True)), ValueError, "step"),
    ]:
        with pytest.raises(kind, match=re.escape(sentence)):
            call()


def test_singular_states_are_named():
    massless = axode.Builder().body("a", joint={"kind": "revolute", "axis": "z", "point": [0, 0, 0]}).build()
    x = torch.ones(3, 1, dtype=torch.float64)
    with pytest.raises(axode.SingularError) as raised:
        axode.torch.forward_dynamics(massless, x, x, x)
    assert list(raised.value.states) == [0, 1, 2]


def test_derivatives_that_there_are_not_are_refused():
    q, v, a, _ = leaves(states(ARM))
    pi = torch.tensor(ARM.parameters).requires_grad_()
    for name in ("inverse_dynamics", "forward_dynamics"):
        def loss(pi, q, name=name):
            return getattr(axode.torch, name)(ARM, q, v, a, parameters=pi).square().sum()

        for x in (pi, q):
            gradient, = torch.autograd.grad(loss(pi, q), x, create_graph=True)
            with pytest.raises(NotImplementedError, match="parameters"):
                gradient.sum().backward()
        for of in (lambda: hessian(loss)(pi, q), lambda: jacfwd(grad(loss, 1))(pi, q), lambda: jacrev(grad(loss, 1))(pi, q)):
            with pytest.raises(NotImplementedError, match="parameters"):
                of()
        assert hessian(loss, 1)(pi.detach(), q).isfinite().all()
    gradient, = torch.autograd.grad(axode.torch.inverse_dynamics(ARM, q, v, a).sum(), q, create_graph=True)
    second, = torch.autograd.grad(gradient.square().sum(), q, create_graph=True)
    with pytest.raises(NotImplementedError, match="no derivatives of inverse dynamics hessian"):
        second.sum().backward()
    path, _ = axode.torch.rollout(ARM, q, v, a[None], 1e-3)
    gradient, = torch.autograd.grad(path.sum(), q, create_graph=True)
    with pytest.raises(NotImplementedError, match="no derivatives of rollout vjp"):
        gradient.sum().backward()


def test_parameters_are_those_of_a_pseudo_inertia():
    for m in MECHANISMS.values():
        pi = m.parameters.reshape(-1, 10)
        P = torch.tensor(axode.identification.pseudo_inertia(pi)).requires_grad_()
        assert np.allclose(axode.torch.inertial_parameters(P).detach(), pi, atol=1e-15)


def test_a_pseudo_inertia_at_the_flange_is_a_payload_there():
    M = axode.lie.transform_inertia(axode.lie.exp([0.1, 0.2, 0, 0.02, 0, 0.1]), axode.lie.box_inertia(1.5, [0.1, 0.2, 0.3]))
    matter = [M[3, 3], M[2, 4], M[0, 5], M[1, 3], M[0, 0], M[1, 1], M[2, 2], M[0, 1], M[0, 2], M[1, 2]]
    C = ARM.frame_pose("flange")[1]
    added = axode.torch.inertial_parameters(torch.tensor(C @ axode.identification.pseudo_inertia(matter) @ C.T))
    pi = torch.tensor(ARM.parameters)
    pi[-10:] += added
    q, v, a, _ = states(ARM, 3)
    loaded = axode.inverse_dynamics(ARM.with_payload("flange", M), *map(np.asarray, (q, v, a)))
    assert close(axode.torch.inverse_dynamics(ARM, q, v, a, parameters=pi), torch.tensor(loaded))


# Documentation

@pytest.mark.parametrize("name", axode.torch.__all__)
def test_docstring_has_an_example_that_runs(name):
    text = getattr(axode.torch, name).__doc__
    names = {"np": np, "axode": axode, "torch": torch, "arm": ARM}
    test = doctest.DocTestParser().get_doctest(text, names, name, None, None)
    assert test.examples
    printed = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test, out=printed.append)
    assert not printed, "".join(printed)


def test_what_the_page_shows_is_what_happens(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_page("docs/torch.md", {})


def test_the_page_lists_the_public_names():
    page = (SOURCE / "docs/torch.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `(\w+)\(", page, re.MULTILINE)) == set(axode.torch.__all__)


def test_the_example_learns_the_payload_and_the_friction():
    done = subprocess.run([sys.executable, SOURCE / "examples/python/11_learning_with_torch.py"], capture_output=True, text=True,
                          env={**os.environ, "OMP_NUM_THREADS": "1"})
    assert done.returncode == 0 and done.stderr == "", done.stderr
    numbers = {line.split(":")[0]: [float(x) for x in re.findall(r"-?\d+\.?\d*", line.split(":")[1])]
               for line in done.stdout.splitlines() if ":" in line}
    assert numbers["mass of the payload in kg"] == pytest.approx([1.5, 1.5], abs=0.03)
    before, payload, both, noise = numbers["torques off by in N m"]
    assert before > 2 * payload > 10 * both and both < 1.3 * noise


def test_nothing_is_imported_unless_it_is_asked_for_and_nothing_is_said_at_the_end():
    script = """
import sys, axode
assert "torch" not in sys.modules
import torch
arm = axode.load(axode.robots / "arm7.toml")
q = torch.zeros(7, dtype=torch.float64, requires_grad=True)
U = axode.torch.potential_energy(arm, q)  # a graph that is never gone back through
print(axode.torch.handle(arm))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=Path(__file__).parent)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert done.stdout.strip() == axode.torch.handle(ARM)  # the same in another process
