"""The code of the page and of the docstrings gives what they show, and the example runs."""

import ast
import doctest
import os
import re
import subprocess
import sys

import axode
import axode.jax
import jax
import jax.numpy as jnp
import numpy as np
from pages import SOURCE, run_page


def test_what_the_page_shows_is_what_happens(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_page("docs/jax.md", os.environ)


def test_the_page_lists_the_functions():
    table = (SOURCE / "docs/jax.md").read_text(encoding="utf-8").partition("| function | derivatives |")[2].partition("\n\n")[0]
    assert set(re.findall(r"`(\w+)\(", table)) == set(axode.jax.__all__)


def test_examples_in_docstrings():
    names = {"axode": axode, "jax": jax, "jnp": jnp, "np": np, "arm": axode.load(axode.robots / "arm7.toml")}
    failed = doctest.testmod(axode.jax, extraglobs=names)
    assert failed.attempted > len(axode.jax.__all__) and failed.failed == 0
    assert all(">>>" in getattr(axode.jax, name).__doc__ for name in axode.jax.__all__)


def test_a_gait_is_found(tmp_path):
    done = subprocess.run([sys.executable, SOURCE / "examples/python/12_gait_with_jax.py"], cwd=tmp_path, capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    together, found, phases = done.stdout.splitlines()
    assert abs(float(together.split()[1])) < 0.01 and float(found.split()[1]) > 1
    assert len(ast.literal_eval(re.sub(r"(?<=\d)\.?\s+(?=[-\d])", ", ", phases.partition(":")[2].strip()))) == 5


def test_jax_is_imported_only_if_it_is_asked_for():
    assert subprocess.run([sys.executable, "-c", "import axode, sys; sys.exit('jax' in sys.modules)"]).returncode == 0
