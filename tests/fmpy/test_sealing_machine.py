"""The example of tools behind mechanisms: all steps run, and yield what the README says."""

import os
import re
import subprocess
import sys

import pytest
from fmpy.fmi1 import FMICallException

from conftest import CAMDRIVE, ROOT

FOLDER = ROOT / "examples" / "sealing_machine"


def test_all_steps_run_and_keep_their_promises(tmp_path):
    environment = os.environ | {"CAMDRIVE": CAMDRIVE, "PYTHON": sys.executable, "PYTHONDONTWRITEBYTECODE": "1"}
    run = subprocess.run([FOLDER / "run_all", tmp_path], env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    # Libraries of other platforms may be of an earlier build.
    assert "warning" not in run.stderr.replace("warning: left out", "")
    # drive.py asserts what is promised; see there.
    assert "all promises are kept" in run.stdout
    readme = (FOLDER / "README.md").read_text()
    table = re.findall(r"^(period|speed|jaw|feeder) +(\S.*?) {2,}(\S.*)$", run.stdout, re.MULTILINE)
    assert len(table) == 4 and all(f"| {' | '.join(row)} |" in readme for row in table)
    angles = re.search(r"least transmission angles (\S+) (\S+) (\S+)", run.stdout).groups()
    assert "angles are {}, {} and {}".format(*angles) in readme
    # The README's commands are those of the script.
    steps = re.findall(r"^== (?:camdrive|\S*python\S*) (\S+)", run.stdout, re.MULTILINE)
    assert steps == re.findall(r"`(?:camdrive|python) (\S+)[^`]*` \|$", readme, re.MULTILINE)
    names = {path.name for path in (tmp_path / "cams").iterdir()}
    assert {"sealing_machine_hs.follower1.P.csv", "sealing_machine_hs.follower2.dxf"} <= names


def test_a_derivative_along_some_parameters_is_their_sum_and_many_at_once_are_refused(fmu):
    """Before the start each parameter takes many starts of the machine: those of some fit into a call."""
    package = fmu("sealing_machine")
    chosen = [v for v in package.variables.values() if v.type == "Real" and v.causality == "parameter"]
    knowns = [v.valueReference for v in chosen if not v.name.startswith("solver.")]
    unknown = [package.variables["a"].valueReference]
    with package.unit() as unit:
        unit.slave.setupExperiment(startTime=0.0)
        unit.slave.enterInitializationMode()
        derivative = unit.slave.getDirectionalDerivative
        for known in knowns[::20]:
            assert derivative(unknown, [known], [1.0]) == derivative(unknown, [known], [1.0])
        some = [package.variables[name].valueReference for name in ("J0", "follower[2].cam.a[2]", "follower[1].m")]
        together = derivative(unknown, some, [0.7, 1e-3, 0.1])[0]
        columns = [derivative(unknown, [known], [part])[0] for known, part in zip(some, [0.7, 1e-3, 0.1])]
        assert together == pytest.approx(sum(columns), rel=1e-12)
        with pytest.raises(FMICallException):
            derivative(unknown, knowns, [1.0] * len(knowns))
        assert any("ask for one known at a time" in message for _, _, message in unit.log)
