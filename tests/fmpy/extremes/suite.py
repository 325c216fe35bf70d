"""What the cases of the extremes share: the list of cases, a checked instance, the table of README.md."""

import math
import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fmpy.fmi1 import FMICallException

from conftest import CAMDRIVE, Package, Unit

HERE = Path(__file__).resolve().parent
README = HERE / "README.md"

# The integrated truths are wrong by some 1e-12.
TRUTH = 1e-11
# The method of equal internal steps.
FIXED_COST = 2

# Headroom of a statement of the table over what was measured when it was written, before it is rounded up to a power
# of ten: another C library rounds a sine differently, and a step more or less is no news.
HEADROOM = 3.0
# The least error and work that the table states: below, only roundings and the start are left.
LEAST_ERROR, LEAST_WORK = 1e-13, 10.0


@dataclass
class Outcome:
    """What a case found: the error relative to the size of the motion, the counted work and, where the right answer is
    an error, its message."""

    error: float | None
    steps: float
    evaluations: float
    message: str = ""


@dataclass
class Case:
    drive: str
    extreme: str
    truth: str
    run: object
    # The largest admissible error, or a part of the message where the drive must refuse.
    bound: float | None
    message: str | None = None

    @property
    def name(self):
        return f"{self.drive}: {self.extreme}"


CASES = []


def case(drive, extreme, truth, bound):
    """Declares a case: the function below it takes the packages and returns an `Outcome`."""

    def declare(run):
        CASES.append(Case(drive, extreme, truth, run, bound))
        return run

    return declare


def refusal(drive, extreme, message, why):
    """Declares a case in which the drive has to refuse with `message`, for the reason `why`."""

    def declare(run):
        CASES.append(Case(drive, extreme, why, run, None, message))
        return run

    return declare


class Packages:
    """The FMUs of the scenes beside this file, exported in one go on first use."""

    def __init__(self, folder):
        self.folder, self.loaded = Path(folder), {}

    def __getitem__(self, name):
        fmus = self.folder / "fmus"
        if not fmus.exists():
            fmus.mkdir()
            scenes = sorted(str(p) for p in (HERE / "scenes").glob("*.toml"))
            subprocess.run([CAMDRIVE, "export", *scenes, "-o", f"{fmus}/"], check=True, capture_output=True)
        if name not in self.loaded:
            self.loaded[name] = Package(fmus / f"{name}.fmu", self.folder / name)
        return self.loaded[name]


class Moved:
    """The motion phi = c0 + c1 t + c2 t²/2 of a drive with inputs."""

    def __init__(self, *coefficients):
        self.c = coefficients + (0.0,) * (3 - len(coefficients))

    def __call__(self, t):
        c0, c1, c2 = self.c
        return c0 + c1 * t + c2 * t * t / 2, c1 + c2 * t, c2

    def inputs(self, t):
        return dict(zip(("phi", "w", "a"), self(t)))

    def drive(self, unit):
        """Sets the inputs for the step ahead."""
        unit.set(**self.inputs(unit.time))


class Refused(Exception):
    """What an instance said when it refused a step."""


class Probe(Unit):
    """An instance of which every value read must be a finite number."""

    def get(self, *names):
        values = super().get(*names)
        assert np.all(np.isfinite(values)), dict(zip(names, np.atleast_1d(values)))
        return values

    def step(self, size):
        try:
            super().step(size)
        except FMICallException as refused:
            raise Refused(self.log[-1][2]) from refused

    def outcome(self, error):
        if "solver.method" in self.package.variables and super().get("solver.method") == FIXED_COST:
            # Nothing but its own estimate bounds the error of equal steps.
            estimate = float(super().get("solver.error_estimate"))
            assert error <= max(estimate, TRUTH), f"error {error:.1e}, estimate {estimate:.1e}"
        return Outcome(float(error), *super().get("solver.steps", "solver.evaluations"))


def probe(package, values=(), start_time=0.0, inputs=None):
    """An instance at its start."""
    unit = Probe(package)
    if inputs:
        unit.set(**inputs)
    try:
        unit.initialise(start_time=start_time, values=dict(values))
    except FMICallException:
        raise AssertionError(unit.log[-1][2]) from None
    return unit


def record(unit, times, names, before=None):
    """The values of `names` at `times`, reached one after the other; `before(unit)` sets inputs. Returns the times
    reached, as the FMU counts them, and the values."""
    reached, got = [], []
    for time in times:
        if before:
            before(unit)
        unit.step_to(time)
        reached.append(unit.time)
        got.append(unit.get(*names))
    return reached, np.array(got, dtype=float).reshape(len(reached), len(names))


def reach(times, at=0.0):
    """The instants that steps to these times arrive at."""
    reached = []
    for time in times:
        at += time - at
        reached.append(at)
    return reached


def error(got, expected, scale=None):
    """The largest deviation, relative to the largest expected value of each column."""
    got, expected = np.asarray(got, dtype=float), np.asarray(expected, dtype=float)
    scale = np.abs(expected).max(axis=0) if scale is None else np.asarray(scale)
    deviation = np.abs(got - expected) / np.where(scale > 0.0, scale, 1.0)
    assert np.all(np.isfinite(deviation)), "the reference is no number"
    return deviation.max()


def refused(package, values=(), run=None, inputs=None):
    """The outcome of a drive that must refuse: at a parameter, at the start or, with `run(unit)`, on the way."""
    unit = Probe(package)
    try:
        if inputs:
            unit.set(**inputs)
        unit.initialise(values=dict(values))
        if run:
            run(unit)
    except (FMICallException, Refused):
        status, category, text = unit.log[-1]
        assert (status, category) == (3, "logStatusError"), unit.log[-1]
        assert not re.search(r"\bNaN\b|\binf\b|\d{20}", text), text
        return Outcome(None, math.nan, math.nan, text)
    raise AssertionError("the drive did not refuse")


def stated(value, least):
    """`value` with headroom, rounded up to a power of ten."""
    return 10.0 ** math.ceil(math.log10(value * HEADROOM) - 1e-9) if value > least else least


def check(case, outcome):
    """A correct value or a clear error."""
    if case.message is not None:
        assert case.message in outcome.message, outcome.message
    else:
        assert outcome.error <= case.bound, f"error {outcome.error:.2e} > {case.bound:.0e}"


HEADER = """# The drives at their extremes

Each row is a case of `tests/fmpy/test_extremes.py`, driven through the C interface: either the error against a truth \
that owes nothing to the drive, or the message with which the drive refuses. Errors are relative to the largest value \
of the motion; `error ≤` is what was measured with some headroom, rounded up to a power of ten, `bound` is what the case \
requires, the work is what `solver.steps` and `solver.evaluations` counted, rounded up likewise. The test fails when a \
statement no longer holds. `BLESS=1 pytest tests/fmpy/test_extremes.py` writes the table anew.
"""


def number(value):
    return "0" if value == 0.0 else f"{value:.0e}".replace("e+0", "e").replace("e+", "e").replace("e-0", "e-")


def row(case, outcome):
    if case.message is not None:
        cells = [case.extreme, f"refused: “{case.message}”", "", case.truth, "", ""]
    else:
        work = [number(stated(v, LEAST_WORK)) for v in (outcome.steps, outcome.evaluations)]
        cells = [case.extreme, number(min(stated(outcome.error, LEAST_ERROR), case.bound)), number(case.bound), case.truth, *work]
    return "| " + " | ".join(cells) + " |"


def table(outcomes):
    lines = [HEADER]
    for drive in dict.fromkeys(c.drive for c, _ in outcomes):
        lines += [f"## {drive}", "", "| extreme | error ≤ | bound | truth | steps ≤ | evaluations ≤ |", "|---|---|---|---|---|---|"]
        lines += [row(c, o) for c, o in outcomes if c.drive == drive]
        lines.append("")
    return "\n".join(lines)


def committed():
    """The rows of the committed table by (drive, extreme)."""
    rows, drive = {}, None
    for line in README.read_text().splitlines():
        if line.startswith("## "):
            drive = line[3:]
        elif line.startswith("| ") and not line.startswith("| extreme"):
            cells = [cell.strip() for cell in line[1:-1].split("|")]
            rows[drive, cells[0]] = cells[1:]
    return rows


BLESS = os.environ.get("BLESS") == "1"
