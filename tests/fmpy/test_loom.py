"""The example of the loom from its tasks to its FMUs: all steps run, and yield what the README says."""

import os
import re
import subprocess
import sys

from conftest import CAMDRIVE, ROOT

LOOM = ROOT / "examples" / "loom"


def test_all_steps_run_and_keep_their_promises(tmp_path):
    environment = os.environ | {"CAMDRIVE": CAMDRIVE, "PYTHON": sys.executable, "PYTHONDONTWRITEBYTECODE": "1"}
    run = subprocess.run([LOOM / "run_all", tmp_path], env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    # drive.py asserts what is promised; see there.
    assert "all promises are kept" in run.stdout
    readme = (LOOM / "README.md").read_text()
    periods = re.search(r"period T \[s\] +(\S+) +(\S+)", run.stdout).groups()
    assert f"| period | {periods[0]} s | {periods[1]} s |" in readme
    # The README's commands are those of the script.
    steps = re.findall(r"^== (?:camdrive|\S*python\S*) (\S+)", run.stdout, re.MULTILINE)
    assert steps == re.findall(r"`(?:camdrive|python) (\S+)[^`]*` \|$", readme, re.MULTILINE)
    names = {path.name for path in (tmp_path / "cams").iterdir()}
    assert {"loom_hs.follower1.dxf", "loom_hs.follower2.F.csv", "loom_hs.follower2.plcopen.csv"} <= names
