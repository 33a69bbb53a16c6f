#!/usr/bin/env python3
"""Writes the drawing of a chain of n hinges in general position, each in the frame of its body.

usage: make_chain.py N > chain.toml
"""
import random
import sys


def main(n):
    draw = random.Random(1)

    def vector(size):
        return [round(draw.uniform(-size, size), 4) for _ in range(3)]

    print(f'format = "axode drawing 1"\nname = "chain{n}"')
    for i in range(1, n + 1):
        on = f'on = "{i - 1}"\n' if i > 1 else ""
        print(
            f'\n[[body]]\nname = "{i}"\n{on}B = {{ position = {vector(0.3)}, rpy = {vector(1.5)} }}\n'
            f'joint = {{ kind = "revolute", axis = {vector(1)}, point = {vector(0.1)} }}\n'
            f"mass = 1\ncom = {vector(0.1)}\ninertia = [0.1, 0.1, 0.1]"
        )


if __name__ == "__main__":
    if len(sys.argv) != 2 or not sys.argv[1].isdigit() or sys.argv[1] == "0":
        sys.exit(__doc__.strip().splitlines()[-1])
    main(int(sys.argv[1]))
