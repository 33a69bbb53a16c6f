"""Times of calls from Python beside Pinocchio's: python_calls.py [--states N].

Medians of several runs, in microseconds. What a call costs beyond the C++ that it runs is read off the body-fixed
recursion, which takes one state after the other: a call for one state less the time of each of many in one call.
"""

import argparse
import statistics
import timeit

import axode
import numpy as np
import pinocchio as pin


def microseconds(call, repetitions=9):
    timer = timeit.Timer(call)
    number = max(1, timer.autorange()[0] // 4)
    return statistics.median(timer.repeat(repetitions, number)) / number * 1e6


def robots():
    """The same mechanisms in both libraries; URDF has no word for armature."""
    drawing = axode.load(axode.robots / "arm7.toml").to_dict()
    for body in drawing["body"]:
        if isinstance(body["joint"], dict):
            body["joint"].pop("armature", None)
    yield axode.Model.from_dict(drawing)
    yield axode.load(axode.robots / "humanoid.urdf")


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


if __name__ == "__main__":
    main()
