"""Drives the exported FMUs of the loom with fmpy: do the tools move as prescribed, and keep their restrictions?

    python drive.py FOLDER

FOLDER is where `run_all` has put scenes, reports and FMUs. Measures the machine with cams as synthesised and with compensated
cams, asserts what was promised, and writes before_and_after.svg.
"""

import json
import sys
import tempfile
import tomllib
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from picture import Panel, page

TOOLS = ("gripper", "sley")
POINTS = 720  # of a turn


class Series:
    """U(psi) = a0 + sum of a_k cos k psi + b_k sin k psi, as a scene has it."""

    def __init__(self, cam):
        scale = float(str(cam.get("scale", 1.0)).split()[0])
        a, b = np.array(cam["a"]) * scale, np.array([0.0, *cam.get("b", [])]) * scale
        self.order = max(len(a), len(b)) - 1
        self.c = np.zeros(self.order + 1, complex)
        self.c[: len(a)] += a
        self.c[: len(b)] -= 1j * b

    def at(self, psi, derivative=0):
        k = np.arange(self.order + 1)
        return (np.exp(1j * np.outer(psi, k)) @ (self.c * (1j * k) ** derivative)).real


class Unit:
    """An instance of an FMU, initialised; values by name."""

    def __init__(self, path, **start):
        description = fmpy.read_model_description(str(path))
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.folder = tempfile.TemporaryDirectory()
        fmpy.extract(str(path), unzipdir=self.folder.name)
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self.folder.name,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=path.stem,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.set(**start)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time = 0.0

    def set(self, **values):
        self.fmu.setReal([self.references[name] for name in values], list(values.values()))

    def get(self, *names):
        return np.array(self.fmu.getReal([self.references[name] for name in names]))

    def step_to(self, time):
        self.fmu.doStep(self.time, time - self.time)
        self.time = time

    def free(self):
        self.fmu.freeInstance()
        self.folder.cleanup()


def period_of(path, guess):
    """The time of one turn on the periodic motion: phi(T) = 2 pi, seen from a guess that is nearly right."""
    unit = Unit(path)
    for i in range(1, 101):
        unit.step_to(i * guess / 100)
    phi, w = unit.get("phi", "w")
    unit.free()
    return guess + (2 * np.pi - phi) / w


def turn(folder, machine, tools, guess):
    """A machine on its periodic motion over a turn, with its tools as elastic cam drives on its shaft.

    The tools run eight turns before, so that what they started with has died out.
    """
    path = folder / f"{machine}.fmu"
    period = period_of(path, guess)
    unit, drives = Unit(path), [Unit(folder / f"{tool}.fmu") for tool in tools]
    names = ["phi", "w", "a", "U[1]", "U[2]", "der(U[1])", "der(U[2])", "der(U[1],2)", "der(U[2],2)"]
    rows, elastic = [], []
    for i in range(9 * POINTS):
        time = i * period / POINTS
        if i > 0:
            unit.step_to(time)
            for drive in drives:
                drive.step_to(time)
        values = unit.get(*names)
        for drive in drives:
            drive.set(**dict(zip(("phi", "w", "a"), values)))
        if i < POINTS:
            rows.append(values)
        if i >= 8 * POINTS:
            elastic.append([drive.get("x", "q") for drive in drives])
    for each in (unit, *drives):
        each.free()
    rows, elastic = np.array(rows), np.array(elastic)
    assert np.all(np.isfinite(rows)) and np.all(np.isfinite(elastic))
    return {"T": period, "w": rows[:, 1], "U": rows[:, 3:5], "v": rows[:, 5:7], "a": rows[:, 7:9], "x": elastic[:, :, 0], "q": elastic[:, :, 1]}


def harmonics(course):
    """Amplitudes of the harmonics 0, 1, 2 ... of a turn."""
    return np.abs(np.fft.rfft(course)) * 2 / len(course)


def judge(run, target, j):
    """Overshoot and deviation of a tool's acceleration, both relative to the largest one prescribed, and the harmonics above
    its own that have more than 1 % of the largest prescribed one."""
    psi = 2 * np.pi * np.arange(POINTS) / POINTS
    wanted = (2 * np.pi / run["T"]) ** 2 * target.at(psi, 2)
    largest = np.abs(wanted).max()
    spectrum = harmonics(run["a"][:, j])
    extra = np.flatnonzero(spectrum > 0.01 * harmonics(wanted).max())
    extra = extra[extra > target.order]
    return {
        "overshoot": np.abs(run["a"][:, j]).max() / largest - 1,
        "deviation": np.abs(run["a"][:, j] - wanted).max() / largest,
        "extra": len(extra),
        "highest": int(extra.max(initial=0)),
        "wanted": wanted,
    }


def measured(run, entry):
    """What a restriction is of, at the phase that the report names: the sum of derivatives of the tools' ways."""
    waves = np.fft.rfft(run["U"], axis=0)[:61] / POINTS
    waves[1:] *= 2
    k = np.arange(len(waves))
    turn = (1j * k) ** entry["order"] * np.exp(1j * k * entry["phase"])
    return sum(factor * (waves[:, tool - 1] * turn).real.sum() for tool, factor in entry["tools"])


def drawing(runs, quality, targets):
    """The tables of the source as a picture: accelerations over time, their spectra, the speed."""
    shown = slice(None, None, 4)
    time = (np.arange(POINTS) / POINTS)[shown]
    names = ("prescribed", "cams as synthesised", "compensated cams")
    panels = []
    for j, tool in enumerate(TOOLS):
        courses = [quality["after"][j]["wanted"], runs["before"]["a"][:, j], runs["after"]["a"][:, j]]
        label = "Acceleration [m/s²]"
        panels.append(Panel(f"{tool.capitalize()}", "Time t/T", label, [(n, time, c[shown]) for n, c in zip(names, courses)]))
        orders = np.arange(1, 17)
        spectra = [(n, orders, harmonics(c)[1:17]) for n, c in zip(names, courses)]
        panels.append(Panel(f"{tool.capitalize()}, up to harmonic {targets[j].order}", "Harmonic", label, spectra, bars=True))
    speeds = [(names[i + 1], time, runs[key]["w"][shown]) for i, key in enumerate(runs)]
    panels.append(Panel("Main shaft", "Time t/T", "Angular velocity [rad/s]", speeds, first=1))
    deflections = [(names[i + 1], time, 1e3 * runs[key]["q"][shown, 0]) for i, key in enumerate(runs)]
    panels.append(Panel("Elastic gripper", "Time t/T", "Deflection q [mm]", deflections, first=1))
    return page("Rapier loom before and after compensation", panels)


def main(folder):
    scene = tomllib.loads((folder / "loom.toml").read_text())
    targets = [Series(follower["cam"]) for follower in scene["follower"]]
    report = json.loads((folder / "loom.json").read_text())
    runs = {
        "before": turn(folder, "loom", TOOLS, report["rounds"][0]["period"]),
        "after": turn(folder, "loom_hs", [f"{tool}_hs" for tool in TOOLS], report["period"]),
    }
    quality = {key: [judge(run, target, j) for j, target in enumerate(targets)] for key, run in runs.items()}
    kept = {"before": report["rounds"][0]["restrictions"], "after": report["finished"]["restrictions"]}

    print(f"{'':44}{'before':>14}{'after':>14}")
    line = lambda name, *values: print(f"{name:44}" + "".join(f"{value:>14}" for value in values))
    line("period T [s]", *(f"{run['T']:.8f}" for run in runs.values()))
    line("speed [rad/s]", *(f"{run['w'].min():.2f}…{run['w'].max():.2f}" for run in runs.values()))
    for j, tool in enumerate(TOOLS):
        both = [quality[key][j] for key in runs]
        line(f"{tool}: overshoot [%]", *(f"{100 * q['overshoot']:.2g}" for q in both))
        line(f"{tool}: deviation of the acceleration [%]", *(f"{100 * q['deviation']:.2g}" for q in both))
        line(f"{tool}: extra harmonics (up to)", *(f"{q['extra']} ({q['highest']})" if q["extra"] else "0" for q in both))
    for both in zip(kept["before"], kept["after"]):
        line(f"{both[0]['name']}: reserve", *(f"{entry['reserve']:.2g}{'' if entry['kept'] else ' !'}" for entry in both))
    line("elastic gripper: largest |q| [mm]", *(f"{1e3 * np.abs(run['q'][:, 0]).max():.3g}" for run in runs.values()))
    line("elastic sley: largest |q| [mm]", *(f"{1e3 * np.abs(run['q'][:, 1]).max():.3g}" for run in runs.values()))
    (folder / "before_and_after.svg").write_text(drawing(runs, quality, targets))
    print(folder / "before_and_after.svg")

    # The FMUs run as in the report.
    for run, entry in ((runs["before"], report["rounds"][0]), (runs["after"], report["finished"])):
        assert abs(run["T"] / entry["period"] - 1) < 1e-9, "period"
    for j, (plain, cam) in enumerate(zip(quality["before"], report["cams"])):
        assert abs(plain["overshoot"] - report["rounds"][0]["tools"][j]["overshoot"]) < 1e-3, "overshoot"
        # The error that the finite series of the cam may cause, as stated, and the accuracy of the FMU.
        assert quality["after"][j]["deviation"] <= cam["truncation"] + 1e-9, "deviation"
        assert quality["after"][j]["extra"] == 0 and plain["extra"] > 0, "harmonics"
    psi = 2 * np.pi * np.arange(POINTS) / POINTS
    for j, target in enumerate(targets):
        # The cam drives put the tools where they are to be at that time.
        stroke = np.ptp(target.at(psi))
        assert np.abs(runs["after"]["x"][:, j] - target.at(psi)).max() < 1e-7 * stroke, "position"
    for key, run in runs.items():
        for entry in kept[key]:
            # Derivatives up to the second have the accuracy of the FMU.
            assert abs(measured(run, entry) - entry["value"]) < 1e-6, entry["name"]
    assert all(entry["kept"] for entry in kept["after"]), "restrictions"
    assert not all(entry["kept"] for entry in kept["before"]), "without compensation restrictions are missed"
    shapes = json.loads((folder / "cams" / "loom_hs.json").read_text())["followers"]
    findings = [f for shape in shapes for cam in shape["cams"] for f in cam["findings"]]
    assert findings and all(f["verdict"] == "good" for f in findings), "cams"
    print("all promises are kept")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
