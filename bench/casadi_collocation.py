"""Forward dynamics in CasADi: the function of axode compared with the same operations in CasADi's own expressions:
casadi_collocation.py [--compiled].

First one state: the function and its derivatives, in microseconds of processor time for each of 200 states in a map, medians. Then
the optimisations of examples/python/10_casadi_collocation.py with IPOPT and exact Hessians, in seconds of processor time: to make the
solver, to solve, and of this in functions and their derivatives. CasADi's expressions are also expanded, which makes one expression
of the whole problem.

The expressions (SX) are those of our own generated C, which is shorter than what a recursion written in SX gives. CasADi differentiates
them, and with --compiled it also writes function and derivatives as C, which the same compiler makes a library of with the
same flags; that takes minutes.
"""

import argparse
import contextlib
import io
import re
import runpy
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import axode
import axode.casadi
import casadi as ca
import numpy as np

EXAMPLE = Path(__file__).resolve().parents[1] / "examples/python/10_casadi_collocation.py"
FLAGS = ["-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"]
OURS = axode.casadi.function


def traced(m, quantity, states=1):
    """A generated function as an expression of CasADi: its statements, executed with SX."""
    source = axode.codegen.c_source(m, [quantity], prefix="m")
    name, result = source.functions[0].name, "a" if quantity == "forward_dynamics" else "C"
    body = source.text[source.text.rindex(f"{name}("):]
    lengths = {"q": m.nq, "v": m.nv, "tau": m.nv} if quantity == "forward_dynamics" else {"q": m.nq}
    arguments = {argument: ca.SX.sym(argument, length) for argument, length in lengths.items()}
    names = {**arguments, result: [0] * (m.nv if result == "a" else 12)}
    for line in re.findall(r"^  (.*);$", body, re.MULTILINE):
        if made := re.fullmatch(r"const double (angle\d*)\[(\d+)\] = \{(.*)\}", line):
            names[made[1]] = [eval(angle, {}, names) for angle in made[3].split(",")]
        elif made := re.fullmatch(r"m_sine_cosine\((\w+), (\w+), (\w+), \d+\)", line):
            names[made[2]], names[made[3]] = ([f(x) for x in names[made[1]]] for f in (ca.sin, ca.cos))
        elif made := re.fullmatch(r"const double (\w+) = (.*)", line):
            names[made[1]] = eval(made[2], {}, names)
        elif made := re.fullmatch(rf"{result}\[(\d+)\] = (.*)", line):
            names[result][int(made[1])] = eval(made[2], {}, names)
    y = ca.vertcat(*names[result])
    F = ca.Function("expression", list(arguments.values()), [y if result == "a" else ca.reshape(y, 3, 4)])
    return F if states == 1 else F.map(states)


def family(F):
    return {"a": F, "jac_": F.jacobian(), "adj1_": F.reverse(1), "jac_adj1_": F.reverse(1).jacobian()}


def compiled(F, folder):
    """The same function, compiled from C that CasADi writes."""
    generator = ca.CodeGenerator("expression.c")
    for each in family(F).values():
        generator.add(each)
    generator.generate(f"{folder}/")
    library = f"{folder}/expression.so"
    started = time.monotonic()
    subprocess.run(["cc", *FLAGS, "-fPIC", "-shared", f"{folder}/expression.c", "-o", library, "-lm"], check=True)
    print(f"CasADi's C: compiled in {time.monotonic() - started:.0f} s")
    return ca.external("expression", library)


def microseconds(F, states=200, repetitions=9):
    """The processor time for one state, in microseconds."""
    mapped, random = F.map(states), np.random.default_rng(0)
    x = [ca.DM(random.uniform(-1, 1, mapped.size_in(k))) for k in range(mapped.n_in())]
    times = []
    for _ in range(repetitions):
        started = time.process_time()
        mapped.call(x)
        times.append(time.process_time() - started)
    return statistics.median(times) / states * 1e6


def solved(function, options):
    """For each optimisation of the example its name, IPOPT's iterations, and the processor's times."""
    made, nlpsol = [], ca.nlpsol

    def timed(name, plugin, problem, given):
        solver = nlpsol(name, plugin, problem, {**given, **options})
        made.append((solver, time.process_time()))
        return solver

    axode.casadi.function, ca.nlpsol = function, timed
    with contextlib.redirect_stdout(io.StringIO()):
        example = runpy.run_path(str(EXAMPLE))
    problems = {
        "acrobot": lambda: example["least_forces"](
            example["acrobot"], 4.0, 120, np.zeros(2), example["upright"], np.array([0.0, 20.0]), np.full(2, np.inf),
            lambda q: q - example["upright"]),
        "arm": lambda: example["least_forces"](
            example["arm"], 1.0, 20, np.zeros(7), np.full(7, 0.3), example["effort"], example["speed"],
            lambda q: example["pose"](q)[:3, 3] - example["target"]),
    }
    for name, solve in problems.items():
        times = []
        for _ in range(3):
            started = time.process_time()
            motion = solve()
            solver, ready = made[-1]
            in_functions = sum(seconds for word, seconds in solver.stats().items() if word.startswith("t_proc_nlp_"))
            times.append((ready - started, time.process_time() - ready, in_functions))
        yield name, motion, [statistics.median(column) for column in zip(*times)]
    ca.nlpsol = nlpsol


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--compiled", action="store_true", help="CasADi's own C as well")
    arguments = parser.parse_args()
    arm = axode.load(axode.robots / "arm7.toml")
    with tempfile.TemporaryDirectory() as folder:
        started = time.monotonic()
        functions = {"ours": OURS(arm, "forward_dynamics")}
        print(f"ours: written and compiled, or found in the cache, in {time.monotonic() - started:.1f} s")
        functions["SX"] = traced(arm, "forward_dynamics")
        if arguments.compiled:
            functions["SX, C"] = compiled(functions["SX"], folder)
        for name, F in functions.items():
            print(f"{name:6}", "  ".join(f"{word} {microseconds(each):8.2f}" for word, each in family(F).items()), "us")
    for name, function, options in (("ours", OURS, {}), ("SX", traced, {}), ("SX, expanded", traced, {"expand": True})):
        for problem, motion, (made, solving, in_functions) in solved(function, options):
            print(f"{name:12} {problem:8} {motion.status} after {motion.iterations}: made in {made:.2f} s, solved in {solving:.2f} s, "
                  f"of which {in_functions:.3f} s in functions")


if __name__ == "__main__":
    main()
