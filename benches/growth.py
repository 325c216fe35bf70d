"""Times of `camdrive synthesize` and `camdrive stability` over the number of harmonics K, and the exponent between them.

    cargo build --release && python3 benches/growth.py [CAMDRIVE]

The task has three laws with dwells, points and restrictions; the drive has an elastic shaft and a cam of K harmonics. Each time
is the best of two runs.
"""

import math
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CAMDRIVE = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/camdrive")
OUT = ROOT / "target/bench/growth"

LAW = '[[law]]\nname = "{}"\nharmonics = {}\n'
DWELL = '[[law.dwell]]\nfrom = "{} deg"\nto = "{} deg"\nU = "{} mm"\ntolerance = "{} mm"\n'
LIMIT = '[[restriction]]\nfactors = [1, 1, 0]\nof = "U"\nfrom = "{} deg"\nto = "{} deg"\nmax = "65 mm"\n'


def laws(k):
    """Gripper, sley and lifter of a loom."""
    return "".join([
        'name = "three"\nobjective = "peak_acceleration"\n',
        LAW.format("gripper", k), DWELL.format(-42, 42, 0, 2),
        '[[law.bound]]\nof = "dU"\nfrom = "56 deg"\nto = "60 deg"\nmax = "150 mm"\n',
        '[[law.point]]\nphi = "180 deg"\nU = "800 mm"\nddU = "-400 mm"\n',
        LAW.format("sley", k), DWELL.format(67, 291, 0, 0.5),
        '[[law.point]]\nphi = "0 deg"\nU = "90 mm"\ndU = "0 mm"\n',
        LAW.format("lifter", k), DWELL.format(100, 200, 30, 0.3), DWELL.format(270, 350, 0, 0.3),
        LIMIT.format(42, 67), LIMIT.format(291, 318),
    ])


def shaft(k):
    """Amplitudes fall as 1/k³, as those of a law whose acceleration jumps."""
    a = [0.0] + [0.2 * math.cos(1.3 * n) / n**3 for n in range(1, k + 1)]
    b = [0.2 * math.sin(0.7 * n) / n**3 for n in range(1, k + 1)]
    return (
        f'name = "shaft{k}"\nmodel = "ElasticCamDrive"\n[cam]\nlaw = "fourier"\nscale = "1 m"\na = {a}\nb = {b}\n'
        '[drive]\nmode = "constant"\nspeed = "4.8396 rad/s"\n[elasticity]\nplace = "shaft"\n'
        'm = "60 kg"\nJ = "1.5 kg.m2"\nc = "24 kN.m/rad"\nb = "17.85 N.m.s/rad"\n'
    )


def measured(command, content, k, output):
    file = OUT / f"{command}{k}.toml"
    file.write_text(content)
    best = math.inf
    for _ in range(2):
        start = time.perf_counter()
        subprocess.run([CAMDRIVE, command, file, *output], check=True, stdout=subprocess.DEVNULL, cwd=OUT)
        best = min(best, time.perf_counter() - start)
    return best


OUT.mkdir(parents=True, exist_ok=True)
for command, scene, orders, output in [
    ("synthesize", laws, (10, 16, 24), ["-o", OUT / "profile.toml", "--force"]),
    ("stability", shaft, (16, 33, 50, 66), ["-o", OUT / "stability"]),
]:
    last = None
    for k in orders:
        seconds = measured(command, scene(k), k, output)
        growth = "" if last is None else f", exponent {math.log(seconds / last[1]) / math.log(k / last[0]):.2f}"
        print(f"{command} K = {k}: {seconds:.2f} s{growth}", flush=True)
        last = (k, seconds)
