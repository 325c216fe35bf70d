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
    cams = json.loads((folder / "rapier_loom.json").read_text())["cams"]
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
    report = json.loads((folder / "machine_linkage.json").read_text())
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


def made(folder, scene, *options):
    """The FMU of a scene's compensated machine, and what is reported of it."""
    path, target = folder / "scene.toml", folder / "out" / "compensated.toml"
    path.write_text(scene)
    subprocess.run(
        [CAMDRIVE, "compensate", path, "-o", target, "--rounds", "0", "--report", folder, *options], check=True, capture_output=True
    )
    subprocess.run([CAMDRIVE, "export", target, "-o", folder / "machine.fmu"], check=True, capture_output=True)
    (report,) = folder.glob("*.json")
    return Package(folder / "machine.fmu", folder / "fmu"), json.loads(report.read_text())


def errors(package, targets, period, mode, points=1500):
    """The largest deviation of each tool's acceleration over a turn, relative to the largest that is wanted."""
    got, wanted = [], []
    with package.unit(logging=False) as unit:
        unit.initialise(values={"start.mode": mode})
        for i in range(points):
            if i > 0:
                unit.step_to(i * period / points)
            got.append(unit.get("der(U[1],2)", "der(U[2],2)"))
            psi = 2 * np.pi * i / points
            wanted.append([(2 * np.pi / period) ** 2 * target.derivative(psi, 2) for target in targets])
    got, wanted = np.array(got), np.array(wanted)
    return np.abs(got - wanted).max(axis=0) / np.abs(wanted).max(axis=0)


def loom_targets(fmu):
    plain = fmu("rapier_loom")
    return [reference.Series.of(plain, f"follower[{j}].cam") for j in (1, 2)]


@pytest.mark.parametrize("inertia", [0.32, 0.35, 0.40])
def test_near_the_least_inertia_tables_do_what_series_cannot(fmu, tmp_path, inertia):
    """0.317727 kg.m2 is the least without motor; the speed falls to a twentieth of its largest."""
    head, _ = LOOM.read_text().replace("2.8 kg.m2", f"{inertia} kg.m2").split("[motor]")
    package, report = made(tmp_path, head + '[motor]\nkind = "none"\n', "--period", "120 ms")
    assert inertia > 0.38 or all(cut["points"] > 100 for cut in report["cams"])
    stated = np.array([cut["truncation"] for cut in report["cams"]])
    found = errors(package, loom_targets(fmu), 0.12, 1)
    assert stated.max() <= 1e-6
    assert np.all(found <= stated + 1e-9) and np.all(found >= 0.4 * stated), (found, stated)


@pytest.mark.parametrize("options", [("0.05",), ("0.01",), ("1e-4",), ("1e-3", "--laws", "table"), ("1e-6", "--laws", "table")])
def test_the_stated_error_is_that_of_the_exported_machine(fmu, tmp_path, options):
    package, report = made(tmp_path, LOOM.read_text(), "--tolerance", *options)
    stated = np.array([cut["truncation"] for cut in report["cams"]])
    found = errors(package, loom_targets(fmu), report["period"], 2)
    assert np.all(stated <= 1.1 * float(options[0]))
    assert np.all(found <= stated + 1e-9) and np.all(found >= 0.6 * stated), (found, stated)


def test_a_cam_drive_takes_a_table(fmu, tmp_path):
    """Wherever the compensated machine is, its cam has put the tool where it is to be at that time."""
    gripper = tmp_path / "gripper.toml"
    gripper.write_text(
        'name = "gripper"\nmodel = "ElasticCamDrive"\n[cam]\nlaw = "fourier"\na = [0.0, 0.1]\n[drive]\nmode = "input"\n'
        '[elasticity]\nplace = "output"\nm = "1.6 kg"\nnatural_frequency = "400 Hz"\ndamping_ratio = 0.05\n'
    )
    machine, report = made(tmp_path, LOOM.read_text(), "--laws", "table", "--cam", f"1={gripper}")
    subprocess.run(
        [CAMDRIVE, "export", tmp_path / "out" / "gripper.compensated.toml", "-o", tmp_path / "gripper.fmu"],
        check=True,
        capture_output=True,
    )
    tool = Package(tmp_path / "gripper.fmu", tmp_path / "tool")
    wanted, _ = loom_targets(fmu)
    with machine.unit(logging=False) as drive:
        drive.initialise(values={"start.mode": 2})
        for n in range(1, 8):
            drive.step_to(n * report["period"] / 8)
            inputs = dict(zip(("phi", "w", "a"), drive.get("phi", "w", "a")))
            with tool.unit(logging=False) as unit:
                unit.initialise(values=inputs)
                assert abs(unit.get("x") - wanted.derivative(2 * np.pi * n / 8, 0)) < 1e-8


@pytest.mark.parametrize("motor", ["kloss", "none"])
def test_levers_with_long_laws_move_their_tools_as_prescribed(tmp_path, motor):
    """A jaw that comes near the dead centre of its slider-crank: the lever's law has more than a hundred harmonics."""
    scene = (ROOT / "examples" / "sealing_machine" / "scene.toml").read_text().replace('"-36 mm"', '"-74 mm"')
    scene = scene.replace('J0 = "0.12 kg.m2"', "J0 = 0.6")
    options = []
    if motor == "none":
        scene, options = scene.split("[motor]")[0] + '[motor]\nkind = "none"\n', ["--period", "150 ms"]
    package, report = made(tmp_path, scene, "--tolerance", "1e-7", *options)
    angle = np.pi / 180
    targets = [
        reference.Series([1e-3, -74e-3, 3e-3, -2e-3], [0.0, 0.0, 2e-3, 1e-3]),
        reference.Series([0.0, 10 * angle, 3.5 * angle, 0.8 * angle], [0.0, 2 * angle]),
    ]
    stated = np.array([cut["truncation"] for cut in report["cams"]])
    found = errors(package, targets, report["period"], 1 if motor == "none" else 2)
    assert stated.max() <= 1e-7
    assert np.all(found <= stated + 1e-9), (found, stated)
