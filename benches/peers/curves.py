"""What one step of 1 ms with three outputs costs over stiffness, communication step, elapsed time and harmonics.

    target/bench/venv/bin/python benches/peers/curves.py target/bench

after benches/peers/run or benches/peers/cost. Nanoseconds are medians of repetitions; instructions, where valgrind is
installed, are the difference of two runs of different length, so that neither start nor tables count in them.
"""

import csv
import math
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CAMDRIVE = ROOT / "target/release/camdrive"
DRIVE = ROOT / "target/bench/drive"
SCENES = {
    "elastic output": ("m1_elastic_output", "q der(q) tau"),
    "elastic shaft": ("m2_elastic_shaft", "q der(q) tau"),
    "backlash": ("m3_backlash", "x1 y der(y)"),
}
# Harmonics of the rows over K: a_k = 1 / k^3, so that the acceleration has all of them.
HARMONICS = (1, 2, 4, 8, 16, 32, 64)


def unpack(folder, scene_file):
    subprocess.run([CAMDRIVE, "export", scene_file, "-o", f"{folder}/"], check=True, stdout=subprocess.DEVNULL)
    target = folder / scene_file.stem
    shutil.rmtree(target, ignore_errors=True)
    with zipfile.ZipFile(folder / f"{scene_file.stem}.fmu") as archive:
        archive.extractall(target)
    return target


def nanoseconds(fmu, outputs, count, *arguments):
    done = subprocess.run([DRIVE, fmu, outputs, str(count), *arguments], capture_output=True, text=True, check=False)
    found = re.match(r"([\d.]+) ns per step", done.stdout)
    return float(found[1]) if found else math.nan


def instructions(fmu, outputs, count, *arguments):
    if not shutil.which("valgrind"):
        return math.nan

    def of(steps):
        tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
        command = [*tool, DRIVE, fmu, outputs, str(steps), *arguments, "repeat=1"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        found = re.search(r"Collected : (\d+)", done.stderr)
        return int(found[1]) if found and done.returncode == 0 else math.nan

    return (of(2 * count) - of(count)) / count


def law(k):
    return ", ".join(["0.0", *(f"{1 / n**3!r}" for n in range(1, k + 1))])


def rows(folder):
    fmus = {name: unpack(folder, ROOT / f"benches/works/{scene}.toml") for name, (scene, _) in SCENES.items()}
    output, shaft = "elastic output", "elastic shaft"
    read = {name: outputs for name, (_, outputs) in SCENES.items()}
    for exponent in range(3, 13):
        yield output, "stiffness [N/m]", 10.0**exponent, fmus[output], read[output], 500, [f"c=1e{exponent}"]
    for exponent in range(3, 13):
        yield shaft, "stiffness [N·m/rad]", 10.0**exponent, fmus[shaft], read[shaft], 400, [f"c=1e{exponent}"]
    for name in (output, shaft):
        for exponent in range(-6, 2):
            yield name, "communication step [s]", 10.0**exponent, fmus[name], read[name], 400, [f"step=1e{exponent}"]
    for exponent in range(0, 7):
        # The start angle stands for the turns gone by.
        turns = 10**exponent
        arguments = [f"drive.phi_start={2 * math.pi * turns!r}"]
        yield output, "turns before", turns, fmus[output], read[output], 500, arguments
    for name in (output, shaft):
        scene, outputs = SCENES[name]
        text = (ROOT / f"benches/works/{scene}.toml").read_text()
        for k in HARMONICS:
            file = folder / f"curve_{name.split()[1]}_{k}.toml"
            changed = re.sub(r"^a = \[.*\]", f"a = [{law(k)}]", text, flags=re.M)
            file.write_text(re.sub(r'^name = ".*"', f'name = "{file.stem}"', changed, flags=re.M))
            yield name, "harmonics K", k, unpack(folder, file), outputs, 400, []


def main():
    folder = Path(sys.argv[1])
    with open(folder / "curves.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["drive", "over", "value", "ns per step", "instructions per step"])
        last = None
        for name, over, value, fmu, outputs, count, arguments in rows(folder):
            if (name, over) != last:
                print(f"\n{name}: {over:<24}{'ns':>10}{'instructions':>14}")
                last = name, over
            # At least some milliseconds for the clock.
            ns = nanoseconds(fmu, outputs, 10 * count, *arguments)
            counted = instructions(fmu, outputs, count, *arguments)
            writer.writerow([name, over, value, ns, counted])
            print(f"{'':<{len(name)}}  {value:<24g}{ns:>10.0f}{counted:>14.0f}", flush=True)


if __name__ == "__main__":
    main()
