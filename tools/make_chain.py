#!/usr/bin/env python3
"""Writes the drawing of a chain of n hinges in general position, each in the frame of its body.

usage: make_chain.py N [KIND [SHAPE]] > chain.toml

KIND is revolute, prismatic or spherical instead of a hinge; SHAPE is chain, tree (two bodies on each) or star (all on
the ground).
"""
import random
import sys

KINDS = ["revolute", "prismatic", "spherical"]
PARENTS = {"chain": lambda i: i - 1, "tree": lambda i: i // 2, "star": lambda i: 0}


def drawing(n, kind="revolute", shape="chain"):
    """The text of the drawing."""
    draw = random.Random(1)

    def vector(size):
        return [round(draw.uniform(-size, size), 4) for _ in range(3)]

    text = f'format = "axode drawing 1"\nname = "{shape}{n}"\n'
    for i in range(1, n + 1):
        parent = PARENTS[shape](i)
        on = f'on = "{parent}"\n' if parent > 0 else ""
        position, rpy, axis, point = vector(0.3), vector(1.5), vector(1), vector(0.1)
        line = {"revolute": f"axis = {axis}, point = {point}", "prismatic": f"axis = {axis}",
                "spherical": f"point = {point}"}[kind]
        text += (f'\n[[body]]\nname = "{i}"\n{on}B = {{ position = {position}, rpy = {rpy} }}\n'
                 f'joint = {{ kind = "{kind}", {line} }}\n'
                 f"mass = 1\ncom = {vector(0.1)}\ninertia = [0.1, 0.1, 0.1]\n")
    return text


def main(words):
    n, kind, shape = [*words, *["revolute", "chain"][len(words) - 1:]] if 1 <= len(words) <= 3 else ("", "", "")
    if not n.isdigit() or n == "0" or kind not in KINDS or shape not in PARENTS:
        sys.exit("usage: make_chain.py N [KIND [SHAPE]] > chain.toml")
    print(drawing(int(n), kind, shape), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
