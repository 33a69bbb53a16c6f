"""Times of calls from Python, compared with those of Pinocchio: python_calls.py [--states N].

Medians of several runs, in microseconds. What a call costs beyond the C++ that it runs is read off the body-fixed
recursion, which takes one state after the other: a call for one state less the time of each of many in one call.

Specialised models are measured in nanoseconds for each of 64 states in one call on one core, whose matrices stay in the
caches, beside the library's batches and Pinocchio's single calls, all in processor time, and so is the compiler; the last
column says how many times Pinocchio's rate that is.
"""

import argparse
import os
import resource
import statistics
import tempfile
import time
import timeit

import axode
import numpy as np
import pinocchio as pin


def microseconds(call, repetitions=9):
    timer = timeit.Timer(call)
    number = max(1, timer.autorange()[0] // 4)
    return statistics.median(timer.repeat(repetitions, number)) / number * 1e6


def robots():
    """The same mechanisms in both libraries; URDF cannot express armature."""
    drawing = axode.load(axode.robots / "arm7.toml").to_dict()
    for body in drawing["body"]:
        if isinstance(body["joint"], dict):
            body["joint"].pop("armature", None)
    yield axode.Model.from_dict(drawing)
    yield axode.load(axode.robots / "humanoid.urdf")


def nanoseconds(call, states, repetitions=9):
    """The processor time for each state, in nanoseconds. Other programs on the machine do not count in it."""
    timer = timeit.Timer(call, timer=time.process_time)
    number = max(1, timer.autorange()[0] // 4)
    return statistics.median(timer.repeat(repetitions, number)) / number / states * 1e9


def measure_specialised(m, N=64):
    peer = pin.buildModelFromXML(axode.urdf(m))
    data = peer.createData()
    Q, V, A = np.random.default_rng(1).uniform(-1, 1, (3, N, m.nv))
    q, v, a = Q[0], V[0], A[0]
    for function, given, theirs in [
            ("inverse_dynamics", (Q, V, A), lambda: pin.rnea(peer, data, q, v, a)),
            ("forward_dynamics", (Q, V, A), lambda: pin.aba(peer, data, q, v, a)),
            ("mass_matrix", (Q,), lambda: pin.crba(peer, data, q)),
            ("inverse_dynamics_derivatives", (Q, V, A), lambda: pin.computeRNEADerivatives(peer, data, q, v, a)),
            ("forward_dynamics_derivatives", (Q, V, A), lambda: pin.computeABADerivatives(peer, data, q, v, a))]:
        axode.codegen.clear_cache()
        start = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        specialised = m.specialise([function])
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - start
        ours = nanoseconds(lambda: getattr(specialised, function)(*given), N)
        batch = nanoseconds(lambda: getattr(axode, function)(m, *given), N)
        single = nanoseconds(theirs, 1)
        print(f"| {m.name} | {function} | {seconds:.1f} s | {ours:.0f} | {batch:.0f} | {single:.0f} | {single / ours:.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--states", type=int, default=4096, help="of the batches")
    N = parser.parse_args().states
    print(f"{'':26}{'axode':>9}{'Pinocchio':>11}{'ratio':>7}")
    for m in robots():
        peer = pin.buildModelFromXML(axode.urdf(m))
        data = peer.createData()
        q, v, a = np.random.default_rng(0).uniform(-1, 1, (3, m.nv))
        Q, V, A = np.random.default_rng(1).uniform(-1, 1, (3, N, m.nv))
        for name, ours, theirs in [
                ("inverse dynamics", lambda: axode.inverse_dynamics(m, q, v, a), lambda: pin.rnea(peer, data, q, v, a)),
                ("forward dynamics", lambda: axode.forward_dynamics(m, q, v, a), lambda: pin.aba(peer, data, q, v, a)),
                ("mass matrix", lambda: axode.mass_matrix(m, q), lambda: pin.crba(peer, data, q)),
                (f"{N} inverse dynamics", lambda: axode.inverse_dynamics(m, Q, V, A),
                 lambda: [pin.rnea(peer, data, *state) for state in zip(Q, V, A)])]:
            x, y = microseconds(ours), microseconds(theirs)
            print(f"{m.name + ' ' + name:30}{x:9.2f}{y:11.2f}{x / y:7.2f}")
        body = microseconds(lambda: axode.inverse_dynamics(m, q, v, a, "body"))
        inside = microseconds(lambda: axode.inverse_dynamics(m, Q, V, A, "body")) / N
        print(f"{m.name + ' beyond the C++':30}{body - inside:9.2f}")
    print("\n| | | compiled in | specialised | library | Pinocchio | times |\n|---|---|--:|--:|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as cache:
        os.environ["XDG_CACHE_HOME"] = cache
        for m in robots():
            measure_specialised(m)


if __name__ == "__main__":
    main()
