"""`camdrive compensate`: on the exported FMU the tools move in time as prescribed, and do not without compensation."""

import json
import subprocess

import numpy as np
import pytest

import reference
from conftest import CAMDRIVE, ROOT, Package

LOOM = ROOT / "examples" / "rapier_loom" / "scene.toml"
LINKED = ROOT / "tests" / "fmpy" / "scenes" / "machine_linkage.toml"


@pytest.fixture(scope="module")
def compensated(tmp_path_factory):
    """The loom with compensated cams, and its elastic gripper, as FMUs; the stated errors of the tools."""
    folder = tmp_path_factory.mktemp("compensated")
    gripper = folder / "gripper.toml"
    gripper.write_text(
        'name = "gripper"\nmodel = "ElasticCamDrive"\n[cam]\nlaw = "fourier"\na = [0.0, 0.1]\n'
        '[drive]\nmode = "input"\n[elasticity]\nplace = "output"\nm = "1.6 kg"\nnatural_frequency = "400 Hz"\n'
        "damping_ratio = 0.05\n"
    )
    scene = folder / "loom.toml"
    command = [CAMDRIVE, "compensate", str(LOOM), "-o", str(scene), "--cam", f"1={gripper}", "--tolerance", "1e-8"]
    subprocess.run([*command, "--report", str(folder)], check=True, capture_output=True)
    cams = json.loads((folder / "rapier_loom.compensation.json").read_text())["cams"]
    scenes = [str(scene), str(folder / "gripper.compensated.toml")]
    subprocess.run([CAMDRIVE, "export", *scenes, "-o", f"{folder}/"], check=True, capture_output=True)
    packages = [Package(folder / f"{name}_hs.fmu", folder / name) for name in ("rapier_loom", "gripper")]
    return *packages, [cam["truncation"] for cam in cams]


@pytest.fixture(scope="module")
def linked(tmp_path_factory):
    """The machine whose tools are behind mechanisms, with compensated cams, and what the command reports of it."""
    folder = tmp_path_factory.mktemp("linked")
    scene = folder / "linked.toml"
    command = [CAMDRIVE, "compensate", str(LINKED), "-o", str(scene), "--tolerance", "1e-9", "--report", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    subprocess.run([CAMDRIVE, "export", str(scene), "-o", f"{folder}/"], check=True, capture_output=True)
    report = json.loads((folder / "machine_linkage.compensation.json").read_text())
    return Package(folder / "machine_linkage_hs.fmu", folder / "fmu"), report


class Measured:
    """The motion of a tool over the phase of time from its series up to the 60th harmonic."""

    def __init__(self, package, name):
        n = 256
        values = []
        for i in range(n):
            with package.unit(logging=False) as unit:
                unit.initialise(values={"phi_start": 2 * np.pi * i / n, "w_start": 1.0, "start.mode": 1})
                values.append(unit.get(name))
        self.waves = np.fft.rfft(values)[:61] / n
        self.waves[1:] *= 2

    def derivative(self, phase, order):
        k = np.arange(len(self.waves))
        return float((self.waves * (1j * k) ** order * np.exp(1j * k * phase)).real.sum())


def test_tools_behind_mechanisms_move_as_prescribed(fmu, linked):
    """The first tool as the scene says; the second as the plain machine's would at uniform speed. The links' inertia makes a
    good part of the fluctuation: without it the cams would miss."""
    package, report = linked
    plain = fmu("machine_linkage")
    slide = reference.Series([1e-3, -36e-3, 3e-3, -2e-3], [0.0, 0.0, 2e-3, 1e-3])
    targets = [slide, Measured(plain, "U[2]")]
    got, wanted = accelerations(package, targets, report["period"])
    stated = [cut["truncation"] for cut in report["cams"]]
    assert max(stated) <= 1e-9
    assert np.all(np.abs(got - wanted).max(axis=0) <= (np.array(stated) + 1e-9) * np.abs(wanted).max(axis=0))
    # Before, by as much as the report says.
    before = report["rounds"][0]
    got, wanted = accelerations(plain, targets, before["period"])
    deviations = np.abs(got - wanted).max(axis=0) / np.abs(wanted).max(axis=0)
    assert np.all(deviations >= 0.05)
    assert np.allclose(deviations, [tool["deviation"] for tool in before["tools"]], rtol=2e-3)


def test_the_speed_of_the_compensated_machine_is_that_of_the_report(linked):
    package, report = linked
    with package.unit() as unit:
        unit.initialise(values={"start.mode": 2})
        assert abs(unit.get("start.period") - report["period"]) <= 1e-11 * report["period"]
        speeds = []
        for n in range(1, 401):
            unit.step_to(n * report["period"] / 400)
            speeds.append(unit.get("w"))
    assert abs(min(speeds) - report["speed"][0]) < 1e-3 and abs(max(speeds) - report["speed"][1]) < 1e-3


def accelerations(package, targets, period):
    """The tools' accelerations over a turn on the periodic motion and those that are prescribed, the same for both."""
    times = np.linspace(0.0, period, 401)
    got = []
    with package.unit() as unit:
        unit.initialise(values={"start.mode": 2})
        for t in times:
            if t > 0.0:
                unit.step_to(t)
            got.append(unit.get("der(U[1],2)", "der(U[2],2)"))
    phase = 2 * np.pi / period
    wanted = [[phase**2 * target.derivative(phase * t, 2) for target in targets] for t in times]
    return np.array(got), np.array(wanted)


def test_the_tools_of_the_exported_machine_move_as_prescribed(fmu, compensated):
    plain = fmu("rapier_loom")
    targets = [reference.Series.of(plain, f"follower[{j}].cam") for j in (1, 2)]
    # The period that belongs to the compensated machine, and that of the machine as it was.
    machine, _, stated = compensated
    assert max(stated) <= 1e-8
    got, wanted = accelerations(machine, targets, 0.12009167247955)
    assert np.all(np.abs(got - wanted).max(axis=0) <= (np.array(stated) + 1e-9) * np.abs(wanted).max(axis=0))
    got, wanted = accelerations(plain, targets, 0.12004168324406)
    assert np.all(np.abs(got - wanted).max(axis=0) >= 0.13 * np.abs(wanted).max(axis=0))


def test_a_cam_drive_takes_the_compensated_cam(fmu, compensated):
    machine, gripper, _ = compensated
    coefficients = [name for name in gripper.variables if name.startswith("cam.")]
    assert len(coefficients) > 60
    assert all(gripper.start(name) == machine.start(f"follower[1].{name}") for name in coefficients)
    # Wherever the machine is, the cam has put the tool where it is to be at that time.
    period = 0.12009167247955
    plain = reference.Series.of(fmu("rapier_loom"), "follower[1].cam")
    with machine.unit() as drive:
        drive.initialise(values={"start.mode": 2})
        for n in range(1, 8):
            drive.step_to(n * period / 8)
            inputs = dict(zip(("phi", "w", "a"), drive.get("phi", "w", "a")))
            with gripper.unit() as tool:
                tool.initialise(values=inputs)
                assert abs(tool.get("x") - plain.derivative(2 * np.pi * n / 8, 0)) < 1e-9
