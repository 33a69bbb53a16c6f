"""Tools that draw what was measured."""

import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parents[2] / "tools"
HEADER = "model,bodies,velocities,algorithm,frames,representation,mul,add,div,sqrt,sin_cos,ns\n"


def test_a_study_becomes_a_plot(tmp_path):
    pytest.importorskip("matplotlib")
    rows = [f'"a ""door"" & <hinge>",1,1,{algorithm},{frames},{representation},2,3,0,0,2,50\n'
            for algorithm in ("inverse_dynamics", "mass_matrix")
            for frames in ("joint", "user", "com", "construction")
            for representation in ("body", "spatial", "hybrid", "mixed")]
    (tmp_path / "study.csv").write_text(HEADER + "".join(rows))
    files = [tmp_path / "study.csv", tmp_path / "study.svg"]
    subprocess.run([sys.executable, TOOLS / "plot_study.py", *files], check=True)
    drawn = (tmp_path / "study.svg").read_text()
    texts = [text.text for text in xml.etree.ElementTree.fromstring(drawn).iter("{http://www.w3.org/2000/svg}text")]
    assert {'a "door" & <hinge>', "mass matrix", "constr.", "spatial", "operations"} <= set(texts)
