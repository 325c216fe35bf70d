"""Runs per second and core of `camdrive study` against fmpy, which reuses all that it can, on the same work.

    cargo build --release && $(tests/python) benches/study/compare.py [--rounds 3] [SCENE …]

SCENE: guide_bar, rapier_loom, backlash_drive; default: all. CAMDRIVE names another tool than that of this tree.

A run is a start as the scene says with one parameter set, and the default experiment with the largest absolute value of
one output, which is read after each communication step: `getReal` by the methods doStep and getReal of fmpy, `pointers`
by its functions of the C interface with arguments that are made once, straight into an array of numpy; `simulate_fmu` is
the function of fmpy with the instance given. All unpack and instantiate once, and reset the instance before each run.
Rounds go in turn through all of them; the best of each counts.
"""

import argparse
import ctypes
import json
import math
import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
CAMDRIVE = os.environ.get("CAMDRIVE", str(ROOT / "target/release/camdrive"))
OUT = ROOT / "target/bench/study"


@dataclass(frozen=True)
class Work:
    """What varies from `low` to `high` in a unit, of which one is `si`, and the output that is measured."""

    scene: str
    name: str
    low: float
    high: float
    unit: str
    si: float
    output: str
    # Rows of a study, for about a second on one core, and runs of fmpy, spread over the same values.
    rows: int
    runs: int
    # Of the study: no worse than the samples of fmpy, whose largest falls short by up to 4e-3, 7e-5 and 1.4e-2.
    accuracy: float

    def values(self):
        return np.linspace(self.low * self.si, self.high * self.si, self.runs)


RPM = math.tau / 60.0
WORKS = (
    Work("guide_bar", "drive.w", 1000.0, 3000.0, "rpm", RPM, "q", 20_000, 400, 1e-3),
    Work("rapier_loom", "motor.w_s", 400.0, 600.0, "rpm", RPM, "M_an", 2_000, 200, 1e-4),
    Work("backlash_drive", "s", 20.0, 100.0, "um", 1e-6, "force", 2_000, 200, 1e-3),
)


class Fmu:
    """The FMU of a scene, exported, unpacked and instantiated once."""

    def __init__(self, work):
        self.work = work
        scene = ROOT / "examples" / work.scene / "scene.toml"
        file = OUT / f"{work.scene}.fmu"
        subprocess.run([CAMDRIVE, "export", scene, "-o", file], check=True, stdout=subprocess.DEVNULL)
        self.folder = OUT / work.scene
        shutil.rmtree(self.folder, ignore_errors=True)
        fmpy.extract(str(file), str(self.folder))
        self.description = fmpy.read_model_description(str(self.folder))
        experiment = self.description.defaultExperiment
        self.stop, self.step, self.tolerance = (
            float(text) for text in (experiment.stopTime, experiment.stepSize, experiment.tolerance)
        )
        self.count = round(self.stop / self.step)
        references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.parameter, self.output = [references[work.name]], [references[work.output]]
        self.slave = fmpy.instantiate_fmu(str(self.folder), self.description, "CoSimulation")
        # Results go where numpy reads them.
        self.results = (ctypes.c_double * (self.count + 1))()
        self.array = np.frombuffer(self.results)
        self.reference = (ctypes.c_uint * 1)(*self.output)
        start, real = ctypes.addressof(self.results), ctypes.POINTER(ctypes.c_double)
        self.places = [ctypes.cast(start + 8 * i, real) for i in range(self.count + 1)]
        self.times = [i * self.step for i in range(self.count)]

    def start(self, value):
        self.slave.reset()
        self.slave.setReal(self.parameter, [value])
        self.slave.setupExperiment(tolerance=self.tolerance, startTime=0.0, stopTime=self.stop)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def get_real(self, value):
        slave, step, output, array = self.slave, self.step, self.output, self.array
        self.start(value)
        array[0] = slave.getReal(output)[0]
        for i, now in enumerate(self.times, 1):
            slave.doStep(now, step)
            array[i] = slave.getReal(output)[0]
        return np.abs(array).max()

    def pointers(self, value):
        get, do, step = self.slave.fmi2GetReal, self.slave.fmi2DoStep, self.step
        component, output, places = self.slave.component, self.reference, self.places
        self.start(value)
        get(component, output, 1, places[0])
        for i, now in enumerate(self.times, 1):
            do(component, now, step, 1)
            get(component, output, 1, places[i])
        return np.abs(self.array).max()

    def simulate(self, value):
        self.slave.reset()
        result = fmpy.simulate_fmu(
            str(self.folder),
            model_description=self.description,
            fmu_instance=self.slave,
            start_values={self.work.name: value},
            output=[self.work.output],
            output_interval=self.step,
            stop_time=self.stop,
        )
        return np.abs(result[self.work.output]).max()

    def free(self):
        self.slave.freeInstance()


def rate(run, values):
    """Runs per second, and the results."""
    begin = time.perf_counter()
    results = [run(value) for value in values]
    return len(values) / (time.perf_counter() - begin), results


def study(work, stop, threads):
    """Rows per second of the study with so many threads; None where the tool fails."""
    file, folder = OUT / f"{work.scene}.study.toml", OUT / f"{work.scene}_study"
    scene = ROOT / "examples" / work.scene / "scene.toml"
    file.write_text(
        f'scene = "{scene.as_posix()}"\n'
        f'time = "{stop!r} s"\n'
        f'accuracy = {work.accuracy!r}\nmeasures = ["max |{work.output}|"]\n\n'
        f'[[vary]]\nname = "{work.name}"\n'
        f'from = "{work.low!r} {work.unit}"\nto = "{work.high!r} {work.unit}"\ncount = {work.rows}\n'
    )
    shutil.rmtree(folder, ignore_errors=True)
    command = [CAMDRIVE, "study", file, "-o", folder, "--threads", str(threads), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(f"left out: study of {work.scene}: {done.stderr.strip().splitlines()[0]}", file=sys.stderr)
        return None
    report = json.loads(done.stdout)
    return report["rows"] / report["seconds"]


def measured(work, rounds):
    """The line of the table."""
    fmu = Fmu(work)
    kinds = {
        "getReal": lambda: rate(fmu.get_real, work.values())[0],
        "pointers": lambda: rate(fmu.pointers, work.values())[0],
        "simulate_fmu": lambda: rate(fmu.simulate, work.values()[::10])[0],
        "one": lambda: study(work, fmu.stop, 1),
        "two": lambda: study(work, fmu.stop, 2),
    }
    # The same numbers in all ways but for rounded times, or the work is not the same.
    sample = work.values()[:: work.runs // 5]
    results = [rate(run, sample)[1] for run in (fmu.get_real, fmu.pointers, fmu.simulate)]
    assert np.allclose(results, results[0], rtol=1e-9, atol=0.0), work.scene
    best = dict.fromkeys(kinds)
    for _ in range(rounds):
        for kind, run in kinds.items():
            # What failed once fails again.
            if best[kind] != 0.0:
                best[kind] = max(best[kind] or 0.0, run() or 0.0)
    fmu.free()
    get_real, pointers, simulate, one, two = best.values()
    rates = [f"{x:,.0f}" if x else "none" for x in best.values()]
    pairs = ((one, get_real, 1), (one, pointers, 1), (one, simulate, 1), (two, one, 2))
    ratios = [f"{a / b:.{digits}f}" if a and b else "" for a, b, digits in pairs]
    return [work.scene, str(fmu.count), *rates, *ratios]


def processor():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return "an unknown processor"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", choices=[[], *(work.scene for work in WORKS)])
    options = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    version = subprocess.run([CAMDRIVE, "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
    print(f"Runs per second on {processor()}, {os.cpu_count()} processors; {version}, fmpy {fmpy.__version__}\n")
    head = ["scene", "steps", "getReal", "pointers", "simulate_fmu", "study", "two threads"]
    head += ["study / getReal", "study / pointers", "study / simulate_fmu", "two threads / one"]
    print(f"| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for work in WORKS:
        if not options.scenes or work.scene in options.scenes:
            print(f"| {' | '.join(measured(work, options.rounds))} |", flush=True)


main()
