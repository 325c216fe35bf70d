"""The FMUs of benches/works against general solvers, at equal achieved accuracy; called by benches/peers/run.

Every solver is given a ladder of settings. A setting counts for an accuracy when its error against the truth is at most
that; the error is the largest over the outputs at all milliseconds, each relative to its largest value. The cheapest
setting of every solver and accuracy is then measured again, all of them in turn, one after the other, and the median
counts, so that a change of the clock rate touches all alike. Times are CPU times in one process.
"""

import argparse
import csv
import ctypes
import statistics
import sys
from pathlib import Path

import numpy as np
import truth
from truth import doubles

TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)
REPETITIONS = 7

# A solver that takes longer than this [s] for a work is not given a tighter setting.
PATIENCE = 1.0

WORKS = [
    ("M1", "m1_elastic_output", "q der(q) tau", "elastic output, 100 turns"),
    ("M2", "m2_elastic_shaft", "q der(q) tau", "elastic shaft, 100 turns"),
    ("M3", "m3_backlash", "x1 y der(y)", "backlash, 50 turns (error: 5)"),
    ("M4", "m4_rigid_machine", "phi w a", "rigid machine, 10 s"),
    ("ramp", "ramp", "q der(q) tau", "ramped speed, 10 s"),
    ("M5", "m5_train", "w follower[1].q follower[3].y", "train, 10 s"),
    ("M6", "m6_train_backlash", "follower[3].x1 follower[3].y w", "train with backlash, 10 s"),
]
RAMP = (50.26548245743669, 5.0)

TOLERANCES = [m * 10.0**-e for e in range(2, 15) for m in (3.0, 1.0)]
DECADES = [10.0**-e for e in range(2, 15)]
FIXED = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256]

OURS = "camdrive FMU"
WAYS = ("in process", "as an FMU")


def blank(rows, columns):
    """Memory for outputs. It is written to, so that the operating system has provided it before the clock runs."""
    return np.full((rows, columns), np.nan)


class Peer:
    """A library with the interface of peer.hpp."""

    way = WAYS[0]

    def __init__(self, file):
        self.library = ctypes.CDLL(str(file))
        self.library.peer_methods.restype = ctypes.c_char_p
        self.methods = self.library.peer_methods().decode().split(";")

    def ladder(self, method):
        return FIXED if "fixed" in self.methods[method] else TOLERANCES

    def solve(self, method, work, setting):
        out, seconds = blank(truth.STEPS[work], 2), ctypes.c_double()
        failed = self.library.peer_solve(method, work, ctypes.c_double(setting), doubles(out), ctypes.byref(seconds))
        return (None if failed else out), seconds.value


class Scipy:
    way = WAYS[0]

    def __init__(self):
        import scipy_peer

        scipy_peer.compile_all()
        self.peer, self.methods = scipy_peer, scipy_peer.METHODS

    def ladder(self, method):
        return DECADES

    def solve(self, method, work, setting):
        return self.peer.solve(method, work, setting, truth.STEPS[work])


class Host:
    """FMUs through fmu.c. The CPU time is that of initialisation and all steps with their outputs."""

    class Times(ctypes.Structure):
        _fields_ = [(name, ctypes.c_double) for name in ("instantiate", "initialise", "steps")]

    def __init__(self, library):
        self.library = ctypes.CDLL(str(library))

    def open(self, folder, outputs, work):
        fmu = ctypes.create_string_buffer(4096)
        assert self.library.fmu_open(fmu, str(folder).encode(), outputs.encode(), WORKS[work][1] == "ramp") == 0
        return fmu

    def run(self, fmu, work, tolerance):
        count = truth.STEPS[work]
        out, times, step = blank(count, 3), self.Times(), ctypes.c_double(1e-3)
        settings = f"solver.tolerance={tolerance!r}".encode() if tolerance else None
        ramp = (ctypes.c_double * 2)(*RAMP) if WORKS[work][1] == "ramp" else None
        failed = self.library.fmu_run(
            fmu, settings, ramp, step, ctypes.c_long(count), doubles(out), ctypes.byref(times)
        )
        return (None if failed else out[:, :2]), times.initialise + times.steps


class Fmu:
    """The exported FMUs."""

    way = WAYS[1]

    def __init__(self, folder, host):
        self.host, self.methods, self.fmus, self.has_tolerance = host, [OURS], [], []
        for work, (_, scene, outputs, _) in enumerate(WORKS):
            self.fmus.append(host.open(folder / scene, outputs, work))
            self.has_tolerance.append('"solver.tolerance"' in (folder / scene / "modelDescription.xml").read_text())

    def ladder(self, method):
        return [0.0] + TOLERANCES

    def solve(self, method, work, setting):
        if setting and not self.has_tolerance[work]:
            return None, 0.0
        return self.host.run(self.fmus[work], work, setting)


class PeerFmu:
    """A peer behind the C interface of an FMU: the functions of peer.cpp, called as those of the exported FMUs."""

    way = WAYS[1]
    VARIABLES = ("first", "second", "third", "solver.tolerance", "phi", "w", "a")

    def __init__(self, peer, file, folder, host):
        self.file, self.folder, self.host, self.fmus = file, folder, host, {}
        self.methods, self.ladder = peer.methods, peer.ladder

    def solve(self, method, work, setting):
        if (method, work) not in self.fmus:
            name = f"{self.file.stem}_{method}_{work}"
            library = self.folder / name / "binaries/linux64" / f"{name}.so"
            library.parent.mkdir(parents=True, exist_ok=True)
            library.unlink(missing_ok=True)
            library.symlink_to(self.file.resolve())
            variables = "".join(
                f'<ScalarVariable name="{one}" valueReference="{k}"><Real/></ScalarVariable>'
                for k, one in enumerate(self.VARIABLES)
            )
            (self.folder / name / "modelDescription.xml").write_text(
                f'<fmiModelDescription guid="{method} {work}"><CoSimulation modelIdentifier="{name}"/>{variables}'
                "</fmiModelDescription>"
            )
            self.fmus[method, work] = self.host.open(self.folder / name, "first second third", work)
        return self.host.run(self.fmus[method, work], work, float(setting))


def error(outputs, values, rates, is_fmu):
    """An FMU answers for fl(fl(i h) + h), the others for fl((i + 1) h): half a unit in the last place of t, which is
    made good to first order."""
    n = len(values)
    if outputs is None or not np.all(np.isfinite(outputs[:n])):
        return np.inf
    if is_fmu:
        i = np.arange(n, dtype=np.longdouble)
        begin = np.arange(n) * 1e-3
        delta = begin.astype(np.longdouble) + np.longdouble(1e-3) - ((np.arange(n) + 1) * 1e-3).astype(np.longdouble)
        values = values + rates * delta.astype(float)[:, None]
    return float(np.max(np.max(np.abs(outputs[:n] - values), axis=0) / np.max(np.abs(values), axis=0)))


def sweep(solver, method, work, facts):
    """(setting, error, CPU seconds) for each setting that the solver was given."""
    rows = []
    for setting in solver.ladder(method):
        runs = [solver.solve(method, work, setting)]
        if runs[0][1] < 0.1:
            runs.append(solver.solve(method, work, setting))
        seconds = min(run[1] for run in runs)
        rows.append((setting, error(runs[0][0], *facts, solver.way == WAYS[1]), seconds))
        if seconds > PATIENCE or (rows[-1][1] < 1e-13):
            break
    return rows


def cheapest(rows, target):
    good = [row for row in rows if row[1] <= target]
    return min(good, key=lambda row: row[2]) if good else None


def measure(chosen):
    """The median CPU seconds of every (solver, method, work, setting), measured in turn; of those that are hopelessly
    slow the seconds of the sweep."""
    samples = {one: [] for one, seconds in chosen.items() if seconds <= PATIENCE}
    for _ in range(REPETITIONS):
        for solver, method, work, setting in samples:
            samples[solver, method, work, setting].append(solver.solve(method, work, setting)[1])
    return chosen | {one: statistics.median(seconds) for one, seconds in samples.items()}


def short_number(ratio):
    """Two significant digits; a dash where the FMU does not reach the accuracy."""
    if np.isnan(ratio):
        return "–"
    return f"{ratio:.0f}" if ratio >= 10 else f"{ratio:.1f}" if ratio >= 1 else f"{ratio:.2f}"


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--works", default="M1 M2 M3 M4 ramp M5 M6")
    arguments.add_argument("--without-scipy", action="store_true")
    options = arguments.parse_args()
    folder, works = options.folder, options.works.split()

    host = Host(folder / "libfmu.so")
    solvers = [Fmu(folder, host)]
    for name in ("rk4", "odeint", "gsl", "cvode", "crates"):
        file = folder / f"libpeer_{name}.so"
        if file.exists():
            peer = Peer(file)
            solvers.append(peer)
            # The crates integrate to an end that they are told at the start: they cannot be stepped.
            if name != "crates":
                solvers.append(PeerFmu(peer, file, folder / "peer_fmus", host))
    if not options.without_scipy:
        solvers.append(Scipy())
    reference = ctypes.CDLL(str(folder / "libreference.so"))

    # Chosen settings by (work, label, target, way).
    picks, seconds, sweeps = {}, {}, []
    numbers = [w for w in range(len(WORKS)) if WORKS[w][0] in works]
    for work in numbers:
        facts = truth.truth(work, reference, folder)
        for solver in solvers:
            for method, label in enumerate(solver.methods):
                print(f"\r\033[K{WORKS[work][0]}: {label}, {solver.way}", end="", file=sys.stderr, flush=True)
                rows = sweep(solver, method, work, facts)
                sweeps += [(WORKS[work][0], label, solver.way, *row) for row in rows]
                for target in TARGETS:
                    row = cheapest(rows, target)
                    if row:
                        picks[work, label, target, solver.way] = (solver, method, work, row[0]), row[1]
                        seconds[solver, method, work, row[0]] = row[2]
    print("\r\033[Kmeasuring in turn", end="", file=sys.stderr, flush=True)
    medians = measure(seconds)
    print("\r\033[K", end="", file=sys.stderr)

    report(picks, medians, numbers, solvers, folder)
    with open(folder / "work_precision.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["work", "solver", "way", "setting", "relative error", "CPU seconds"])
        writer.writerows(sweeps)
    draw([WORKS[work] for work in numbers], sweeps, folder / "speed.svg")


def draw(works, sweeps, file):
    """CPU time over error: the FMU of camdrive and, at each error, the fastest of all others."""
    import matplotlib.ticker

    matplotlib.use("svg")
    import matplotlib.pyplot as plt

    matplotlib.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "speed", "font.size": 9}
    columns = min(len(works), 2)
    size = (3.4 * columns, 2.6 * -(-len(works) // columns))
    figure, axes = plt.subplots(-(-len(works) // columns), columns, figsize=size, squeeze=False, layout="constrained")
    for axis, (short, _, _, title) in zip(axes.flat, works, strict=False):
        for ours, color in ((True, "#c05a10"), (False, "#1f4e79")):
            points = [(e, 1e3 * s) for work, label, _, _, e, s in sweeps if work == short and (label == OURS) == ours]
            points = sorted(point for point in points if 1e-13 <= point[0] <= 1e-1)
            # A point counts if none with at most its error takes less time.
            front, least = [], np.inf
            for e, ms in points:
                if ms < least:
                    front.append((e, ms))
                    least = ms
            axis.loglog(*np.transpose(front), ".-", color=color, label="FMU of camdrive" if ours else "fastest other solver")
        axis.invert_xaxis()
        axis.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
        axis.yaxis.set_major_formatter("{x:g}")
        axis.yaxis.set_minor_formatter("")
        axis.set_title(f"{short}: {title}", fontsize=9, loc="left")
    for axis in axes.flat[len(works) :]:
        axis.remove()
    axes[0, 0].legend(frameon=False, fontsize=8)
    figure.supxlabel("largest relative error", fontsize=9)
    figure.supylabel("CPU time (ms)", fontsize=9)
    figure.savefig(file, metadata={"Date": None, "Creator": None})


def report(picks, medians, numbers, solvers, folder):
    """Prints the tables and writes them as Markdown; every number as CSV."""
    lines, rows = [], []
    ways = [(target, way) for target in TARGETS for way in WAYS]
    head = "".join(f" {target:.0e} | as an FMU |" for target in TARGETS)
    rule = "|---|" + "---|" * 2 * len(TARGETS)
    lines += ["CPU ms at the relative error that the column names, then as an FMU; in brackets: times camdrive's FMU.", ""]
    summary = []
    for work in numbers:
        short, _, _, title = WORKS[work]
        lines += [f"| {short}: {title} |{head}", rule]
        best = {}
        for label in dict.fromkeys(label for solver in solvers for label in solver.methods):
            cells = []
            for target, way in ways:
                pick, mine = picks.get((work, label, target, way)), picks.get((work, OURS, target, WAYS[1]))
                if not pick:
                    cells.append("–")
                    continue
                ms = 1e3 * medians[pick[0]]
                ratio = ms / (1e3 * medians[mine[0]]) if mine else float("nan")
                rows.append([short, label, way, target, pick[0][3], pick[1], ms, ratio])
                cells.append(f"{ms:.2f}" if label == OURS else f"{ms:.2f} ({short_number(ratio)})")
                if label != OURS and ((target, way) not in best or ms < best[target, way][0]):
                    best[target, way] = (ms, ratio, label)
            if any(cell != "–" for cell in cells):
                lines.append(f"| {label} | " + " | ".join(cells) + " |")
        lines.append("")
        cells = [f"{short_number(best[one][1])} ({best[one][2]})" if one in best else "nobody" for one in ways]
        summary.append(f"| {short} | " + " | ".join(cells) + " |")
    lines += [f"| best peer / FMU |{head}", rule, *summary, ""]
    text = "\n".join(lines)
    print(text)
    (folder / "peers.md").write_text(text)
    with open(folder / "peers.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["work", "solver", "way", "target", "setting", "relative error", "CPU ms", "ratio to FMU"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
