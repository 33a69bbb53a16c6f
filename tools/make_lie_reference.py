#!/usr/bin/env python3
"""Writes tests/data/lie_reference.json: exp, dexp, their inverses and derivatives on SO(3) and SE(3) to 25 digits.

Everything comes from definitions, in 90-digit arithmetic, and shares no formula with the library:
  exp          the power series of the 4x4 matrix, and of the quaternion (xi/2; 0) in the quaternion algebra
  dexp         sum_k ad^k / (k+1)!
  ddexp        the product rule on that series
  dexp_inv     the solution of dexp x = z
  ddexp_inv    -dexp^-1 ddexp dexp^-1
  log          the argument of exp; at half a turn also the one with the opposite axis
Inputs are written so that they read back as exactly the doubles that were used. Results for SO(3) are the angular
parts. Screws are (angular; linear), poses are R row by row and then r, quaternions x y z w.

usage: make_lie_reference.py > tests/data/lie_reference.json          (needs mpmath)
"""
import json
import random

from mpmath import eye, factorial, inverse, matrix, mp, mpf, nstr, pi, sqrt, zeros

mp.dps = 90
TERMS = 180  # the largest ad_X has norm below 21, and 21^180/180! < 1e-91
ANGLES = [0, mpf("1e-12"), mpf("1e-10"), mpf("1e-8"), mpf("1e-6"), mpf("1e-4"), mpf("1e-3"), mpf("1e-2"),
          mpf("0.1"), mpf("0.5"), mpf("0.9"), mpf("0.999"), mpf("1.001"), mpf("1.1"), mpf("1.5"), mpf(2),
          mpf("2.5"), mpf(3), mpf("3.1"), pi - mpf("1e-3"), pi - mpf("1e-6"), pi - mpf("1e-9"),
          pi - mpf("1e-12"), pi]
COORDINATE_AXES = [(1, 0, 0), (0, -1, 0), (0, 0, 1), (-1, 0, 0), (0, 1, 0), (0, 0, -1)]
GENERIC_AXES = [(1, 2, 2), (-3, 4, 1), (2, -1, -5), (-1, -1, -1), (1, -1, 0), (4, 7, -4), (-1, 1, 30)]
LINEAR_SIZES = [0.1, 0.5, 1, 3, 10]


def skew(a):
    return matrix([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def blocks(A, B, C, D):
    M = zeros(A.rows + C.rows, A.cols + B.cols)
    M[: A.rows, : A.cols] = A
    M[: A.rows, A.cols :] = B
    M[A.rows :, : A.cols] = C
    M[A.rows :, A.cols :] = D
    return M


def hat(X):
    return blocks(skew(X[:3]), matrix(X[3:]), zeros(1, 3), zeros(1, 1))


def ad(X):
    return blocks(skew(X[:3]), zeros(3, 3), skew(X[3:]), skew(X[:3]))


def left_product(q):
    """The matrix of p -> q p in the quaternion algebra, order x y z w."""
    x, y, z, w = q
    return matrix([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])


def exp_series(A):
    power, total = eye(A.rows), eye(A.rows)
    for k in range(1, TERMS):
        power = power * A / k
        total += power
    return total


def dexp_series(A, dA):
    """sum_k A^k/(k+1)! and its derivative when A moves along dA."""
    power, d_power = eye(6), zeros(6, 6)
    total, d_total = eye(6), zeros(6, 6)
    for k in range(1, TERMS):
        power, d_power = power * A, d_power * A + power * dA
        total += power / factorial(k + 1)
        d_total += d_power / factorial(k + 1)
    return total, d_total


def doubles(values):
    return [float(v) for v in values]


def exact(values):
    return [mpf(v) for v in values]


def written(values):
    return [nstr(v, 25, strip_zeros=True) if v != 0 else "0" for v in values]


def case(w, v, Z, U):
    X, z = exact(w + v), matrix(exact(Z))
    D, dD = dexp_series(ad(X), ad(exact(U)))
    Di = inverse(D)
    C = exp_series(hat(X))
    q = exp_series(left_product([x / 2 for x in X[:3]] + [mpf(0)])) * matrix([0, 0, 0, 1])
    result = {"X": [repr(x) for x in w + v], "Z": [repr(x) for x in Z], "U": [repr(x) for x in U]}
    result["exp"] = written([C[i, j] for i in range(3) for j in range(3)] + [C[i, 3] for i in range(3)])
    result["quaternion"] = written(q)
    result["dexp"] = written(D * z)
    result["dexp_inv"] = written(Di * z)
    result["ddexp"] = written(dD * z)
    result["ddexp_inv"] = written(-Di * (dD * (Di * z)))
    angle = sqrt(sum(x * x for x in X[:3]))
    if abs(angle - pi) < mpf("1e-14"):
        other = [x * (1 - 2 * pi / angle) for x in X[:3]]
        D_other, _ = dexp_series(ad(other + [mpf(0)] * 3), zeros(6, 6))
        result["other_log"] = written(other + list(inverse(D_other[:3, :3]) * C[:3, 3]))
    return result


def main():
    source = random.Random(1)
    cases = []
    for k, angle in enumerate(ANGLES):
        axes = [COORDINATE_AXES[(2 * k) % 6], COORDINATE_AXES[(2 * k + 1) % 6], COORDINATE_AXES[(2 * k + 2) % 6],
                GENERIC_AXES[k % 7], GENERIC_AXES[(k + 3) % 7]]
        for n, axis in enumerate(axes if angle else axes[:1]):
            length = sqrt(sum(mpf(x) ** 2 for x in axis))
            w = doubles([angle * x / length for x in axis])
            size = LINEAR_SIZES[(n + k) % 5]

            def triple(s):
                return [round(source.uniform(-s, s), 4) for _ in range(3)]

            cases.append(case(w, triple(size), triple(1.5) + triple(1.5), triple(1.5) + triple(1.5)))
    print('{"cases": [')
    print(",\n".join(json.dumps(c, separators=(",", ":")) for c in cases))
    print("]}")


if __name__ == "__main__":
    main()
