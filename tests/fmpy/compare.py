"""Compares the FMUs of two versions of the tool, OLD and NEW: commits, which it builds below target/compare, or folders of
built trees.

Scenes: every example, tests/fmpy/scenes and benches/works of NEW, or those named. Each FMU runs its default experiment and an
irregular grid of communication points (steps from 1e-6 to 20 times the default one), with a state saved in the middle and
restored at the end, and a reset; both have to repeat the same bits. Then all outputs and local variables of OLD and NEW are
compared bit by bit; what differs is printed with the share of differing values and the largest difference relative to the
largest value of the variable. The instructions of the works (benches/peers/cost) end the list.
"""

import multiprocessing
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy.fmi1 import FMICallException

from conftest import ROOT, Package
from test_every_fmu import step_size, stimulate

FOLDER = ROOT / "target" / "compare"
SCENES = ("examples/*/*.toml", "tests/fmpy/scenes/*.toml", "benches/works/*.toml")


def tree(version):
    """The folder of a built tree."""
    tool = Path(version) / "target" / "release" / "camdrive"
    if tool.is_file():
        sources = [file for folder in ("src", "design/src", "cli/src") for file in Path(version, folder).rglob("*.rs")]
        if any(file.stat().st_mtime > tool.stat().st_mtime for file in sources):
            sys.exit(f"{version}: target/release/camdrive is older than a source; build it by cargo build --release")
        return Path(version).resolve()
    git = ["git", "-C", str(ROOT)]
    commit = subprocess.run([*git, "rev-parse", "--verify", f"{version}^{{commit}}"], capture_output=True, text=True)
    if commit.returncode:
        sys.exit(f"{version}: neither a commit nor a folder with target/release/camdrive")
    folder = FOLDER / commit.stdout.strip()[:12]
    release = folder / "target" / "release"
    if not (release / "camdrive").is_file():
        shutil.rmtree(folder, ignore_errors=True)
        release.mkdir(parents=True)
        # Cargo takes files that are older than its last build for unchanged: hence the time of unpacking (-m).
        archive = subprocess.Popen([*git, "archive", commit.stdout.strip()], stdout=subprocess.PIPE)
        subprocess.run(["tar", "-x", "-m", "-C", str(folder)], stdin=archive.stdout, check=True)
        built = FOLDER / "build"
        environment = os.environ | {"CARGO_TARGET_DIR": str(built)}
        subprocess.run(["cargo", "build", "--release", "--locked", "--quiet"], cwd=folder, env=environment, check=True)
        # Of older commits it is libcamdrive.so.
        for library in (built / "release").glob("libcamdrive*.so"):
            shutil.copy2(library, release)
        # The executable last: it says that the tree is built.
        shutil.copy2(built / "release" / "camdrive", release)
    return folder


def grid(package, irregular):
    """Lengths of the communication steps."""
    size = step_size(package)
    if not irregular:
        return [size] * round(float(package.description.defaultExperiment.stopTime) / size)
    chosen = random.Random(1)
    return [size * 10.0 ** chosen.uniform(-6.0, 1.3) for _ in range(150)]


def run(unit, steps, names):
    rows = []
    for size in steps:
        stimulate(unit, unit.time)
        unit.step(size)
        rows.append(unit.get(*names))
    return np.array(rows, dtype=float)


def trajectory(package, names, irregular):
    """All values at all communication points; a text instead where the FMU refuses or does not repeat itself."""
    steps = grid(package, irregular)
    middle = len(steps) // 2
    with package.unit() as unit:
        try:
            def start():
                unit.time = 0.0
                stimulate(unit, 0.0)
                unit.initialise()
                return np.array([unit.get(*names)], dtype=float)

            first = np.concatenate([start(), run(unit, steps[:middle], names)])
            state, time = unit.slave.getFMUState(), unit.time
            second = run(unit, steps[middle:], names)
            unit.slave.setFMUState(state)
            unit.slave.freeFMUState(state)
            unit.time = time
            if run(unit, steps[middle:], names).tobytes() != second.tobytes():
                return "another motion from the restored state"
            values = np.concatenate([first, second])
            unit.slave.reset()
            if np.concatenate([start(), run(unit, steps, names)]).tobytes() != values.tobytes():
                return "another motion after the reset"
            return values
        except FMICallException:
            return f"refused: {unit.log[-1][2] if unit.log else 'without a message'}"


def measured(argument):
    """The variables of the FMU that a tree writes for a scene, and their values over both grids."""
    folder, scene = argument
    with tempfile.TemporaryDirectory() as place:
        tool = folder / "target" / "release" / "camdrive"
        export = subprocess.run([tool, "export", scene, "-o", place + "/"], capture_output=True, text=True)
        if export.returncode:
            return [], [f"not exported: {export.stderr.strip()}"] * 2
        package = Package(next(Path(place).glob("*.fmu")), Path(place) / "fmu")
        names = [v.name for v in package.description.modelVariables if v.causality in ("output", "local")]
        return names, [trajectory(package, names, irregular) for irregular in (False, True)]


def compare(old, new):
    """Lines on what differs; none if nothing does."""
    lines = []
    (old_names, old_runs), (new_names, new_runs) = old, new
    for version, names in (("OLD", set(old_names) - set(new_names)), ("NEW", set(new_names) - set(old_names))):
        if names:
            lines.append(f"only in {version}: {', '.join(sorted(names))}")
    for what, a, b in zip(("default experiment", "irregular grid"), old_runs, new_runs):
        if isinstance(a, str) or isinstance(b, str):
            if not (isinstance(a, str) and isinstance(b, str) and a == b):
                texts = [x if isinstance(x, str) else "runs" for x in (a, b)]
                lines.append(f"{what}: OLD {texts[0]}; NEW {texts[1]}")
            continue
        for name in (name for name in old_names if name in new_names):
            x, y = a[:, old_names.index(name)], b[:, new_names.index(name)]
            differs = x.view(np.uint64) != y.view(np.uint64)
            if differs.any():
                error = np.abs(x - y).max() / (np.abs(x).max() or 1.0)
                lines.append(f"{what}: {name}: {differs.mean():.1%} of the values differ, by {error:.1e}")
    return lines


def instructions(folder):
    """Of one step of each work with three outputs and with all; none without valgrind."""
    environment = os.environ | {"CAMDRIVE": str(folder / "target" / "release" / "camdrive")}
    text = subprocess.run([ROOT / "benches/peers/cost"], env=environment, capture_output=True, text=True, check=True).stdout
    return {
        tuple(work.split()[:2]): int(re.search(r"(\d+) instructions", count)[1])
        for work, count in zip(text.splitlines(), text.splitlines()[1:])
        if "instructions" in count
    }


def main(old, new, *wanted):
    old, new = tree(old), tree(new)
    scenes = [Path(scene).resolve() for scene in wanted]
    # A task.toml is a motion task, a study.toml a study, a system.toml a system: no scenes.
    scenes = scenes or sorted(f for pattern in SCENES for f in new.glob(pattern) if f.name not in ("task.toml", "study.toml", "system.toml"))
    with multiprocessing.Pool(maxtasksperchild=1) as pool:
        results = pool.map(measured, [(folder, scene) for scene in scenes for folder in (old, new)], chunksize=1)
    different = 0
    for scene, a, b in zip(scenes, results[::2], results[1::2]):
        lines = compare(a, b)
        different += bool(lines)
        failed = [run for run in b[1] if isinstance(run, str)]
        points = " and ".join(str(len(run)) for run in b[1] if not isinstance(run, str))
        summary = failed[0] if failed else f"{len(b[0])} variables at {points} points"
        print(f"{scene.parent.name}/{scene.stem}: {'DIFFERS' if lines else 'same bits'} ({summary})")
        print("".join(f"    {line}\n" for line in lines), end="")
    print(f"{len(scenes) - different} of {len(scenes)} scenes have the same bits")
    if not wanted:
        print("\ninstructions of a step         OLD      NEW")
        before, after = instructions(old), instructions(new)
        for work in after:
            a, b = before.get(work), after[work]
            change = f"{a:9} {b:8} {100.0 * (b - a) / a:+6.1f} %" if a else f"{'-':>9} {b:8}"
            print(f"{' '.join(work):24}{change}")
    return int(different > 0)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit("usage: tests/compare OLD NEW [SCENE …]")
    sys.exit(main(*sys.argv[1:]))
