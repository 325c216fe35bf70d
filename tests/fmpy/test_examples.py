"""The numbers that the READMEs of the examples promise, measured on the exported FMUs."""

import importlib.util
import math

import fmpy
import numpy as np
import pytest

from conftest import FMUS, ROOT


def dwell_error(package, rpm, upper_centre):
    """Largest deviation from the ideal dwell positions within two dwells of 64 degrees, relative to the stroke."""
    speed = rpm * 2 * math.pi / 60
    turn = 2 * math.pi / speed
    stroke = 0.94e-3
    angles, y = [], []
    with package.unit() as unit:
        unit.initialise(values={"start.mode": 3, "drive.w": speed})
        for i in range(1440):
            unit.step_to(turn * (i + 1) / 1440)
            angles.append(math.degrees(speed * unit.time) % 360)
            y.append(unit.get("y"))
    angles, y = np.array(angles), np.array(y)
    middle = (y.max() + y.min()) / 2
    middle = 0.0 if abs(middle) < 0.05 * stroke else stroke / 2
    upper = np.abs((angles - upper_centre + 180) % 360 - 180) <= 32
    lower = np.abs((angles - upper_centre) % 360 - 180) <= 32
    return max(np.abs(y[upper] - middle - stroke / 2).max(), np.abs(y[lower] - middle + stroke / 2).max()) / stroke


@pytest.mark.parametrize("rpm, hs, traditional", [(1500, 8.6e-4, 7.9e-3), (1800, 3.2e-4, 8.0e-3), (2000, 4.4e-4, 1.05e-2)])
def test_guide_bar(fmu, rpm, hs, traditional):
    assert abs(dwell_error(fmu("guide_bar"), rpm, 0.0) - hs) < 0.05 * hs
    assert abs(dwell_error(fmu("guide_bar_traditional"), rpm, 180.0) - traditional) < 0.05 * traditional


def test_the_run_up_of_the_guide_bar():
    spec = importlib.util.spec_from_file_location("run_up", ROOT / "examples" / "guide_bar" / "run_up.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    result = script.run(str(FMUS / "guide_bar_run_up.fmu"))
    # Half of the last digit that the README gives.
    assert abs(np.abs(result["q"]).max() - 18.04e-6) < 0.005e-6
    assert abs(np.abs(result["force"]).max() - 623) < 0.5


def test_the_impacts_of_the_backlash_drive():
    result = fmpy.simulate_fmu(str(FMUS / "backlash_drive.fmu"), stop_time=0.5, output_interval=1e-3, output=["impacts"])
    assert result["impacts"][-1] == 16
