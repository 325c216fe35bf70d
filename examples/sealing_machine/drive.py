"""Drives the exported FMUs of the sealing machine with fmpy: do jaw and feeder move in time as prescribed?

    python drive.py FOLDER

FOLDER is where `run_all` has put reports and FMUs. Prints what the README says and asserts what is promised.
"""

import json
import sys
import tomllib
from pathlib import Path

import fmpy
import numpy as np

POINTS = 720  # of a turn
TOOLS = {"jaw": 1e-3, "feeder": np.pi / 180}  # mm and degrees of the scene


class Series:
    """U(psi) = a0 + sum of a_k cos k psi + b_k sin k psi, as the scene has it."""

    def __init__(self, tool, unit):
        number = lambda text: float(text.split()[0]) * unit
        self.a = np.array([number(a) for a in tool["a"]])
        self.b = np.array([0.0, *(number(b) for b in tool["b"])])

    def acceleration(self, psi):
        a, b = np.arange(len(self.a)), np.arange(len(self.b))
        return -np.cos(np.outer(psi, a)) @ (a**2 * self.a) - np.sin(np.outer(psi, b)) @ (b**2 * self.b)


def turn(path, period):
    """Angle, speed and accelerations of the tools over one turn of the periodic motion."""
    names = ["phi", "w", "der(U[1],2)", "der(U[2],2)"]
    course = fmpy.simulate_fmu(str(path), stop_time=period, output_interval=period / POINTS, output=names)
    return np.array([course[name] for name in names])


def main(folder):
    scene = tomllib.loads((Path(__file__).parent / "scene.toml").read_text())
    report = json.loads((folder / "sealing_machine.json").read_text())
    before, after = report["rounds"][0], report
    stated = [cam["truncation"] for cam in report["cams"]]
    rows = {"period": [], "speed": [], **{name: [] for name in TOOLS}}
    for name, machine in (("sealing_machine", before), ("sealing_machine_hs", after)):
        period = machine["period"]
        phi, w, *tools = turn(folder / f"{name}.fmu", period)
        assert abs(phi[-1] - phi[0] - 2 * np.pi) < 1e-9, "the period is that of the report"
        rows["period"].append(f"{period:.9f} s")
        rows["speed"].append(f"{w.min():.2f} to {w.max():.2f} rad/s")
        psi = 2 * np.pi * np.arange(len(phi)) / POINTS
        for (tool, unit), follower, got, bound in zip(TOOLS.items(), scene["follower"], tools, stated):
            wanted = (2 * np.pi / period) ** 2 * Series(follower["tool"], unit).acceleration(psi)
            miss = np.abs(got - wanted).max() / np.abs(wanted).max()
            if name.endswith("_hs"):
                assert miss <= bound + 1e-9, f"{tool}: {miss} is more than the stated {bound}"
                rows[tool].append("< 10⁻⁸")
            else:
                rows[tool].append(f"{100 * miss:.1f} %")
    for what, values in rows.items():
        print(f"{what:8} {values[0]:28} {values[1]}")
    mechanisms = report["transmission"]
    assert all(mechanism["least_angle"] >= np.radians(40) for mechanism in mechanisms)
    print("least transmission angles", " ".join(f"{np.degrees(m['least_angle']):.1f}°" for m in mechanisms))
    print("all promises are kept")


main(Path(sys.argv[1]))
