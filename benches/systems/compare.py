"""Time of coupled FMUs: `camdrive run` against run.py and fmpy.ssp, and the cost of the exchange for each step and FMU.

    python benches/systems/compare.py [CAMDRIVE]

Each time is the least of five of a long run without that of a short one, so that start and files do not count.
"""

import re
import runpy
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from fmpy.ssp.simulation import simulate_ssp

ROOT = Path(__file__).resolve().parents[2]
CAMDRIVE = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target" / "release" / "camdrive")
STEP = 1e-3

MACHINE = ROOT / "examples" / "two_cams"
THREE = f"""name = "three_drives"
stop = 1
step = {STEP}
[part.machine]
scene = "{MACHINE / "machine.toml"}"
start = {{ w_start = "200 rpm" }}
""" + "".join(
    f'[part.drive_{i}]\nscene = "{MACHINE / "pusher.toml"}"\nshaft = "machine"\noffset = "{120 * i} deg"\n' for i in range(3)
)
# The cheapest FMU there is: a flywheel on a torque.
FLYWHEEL = 'name = "wheel"\nmodel = "RigidMachine"\nmachine = { J0 = 1 }\nmotor = { kind = "input" }\n'


def least(call, short, long):
    """Seconds of a long run without a short one."""
    times = {length: [] for length in (short, long)}
    for _ in range(5):
        for length, all in times.items():
            begin = time.perf_counter()
            call(length)
            all.append(time.perf_counter() - begin)
    return min(times[long]) - min(times[short])


def tool(file, *options):
    def call(steps):
        command = [CAMDRIVE, "run", file, "--stop", str(steps * STEP), "--step", str(STEP), *options]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    return call


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        per_step = {}
        for repeat in (0, 1, 2):
            file = folder / f"three_{repeat}.toml"
            file.write_text(THREE.replace("[part.machine]", f"repeat = {repeat}\n[part.machine]", 1))
            per_step[repeat] = least(tool(file, "--output", "machine.w"), 1000, 41000) / 40000
        subprocess.run([CAMDRIVE, "system", folder / "three_0.toml", "-o", folder / "fmus"], check=True, stdout=subprocess.DEVNULL)
        text = (folder / "fmus" / "run.py").read_text()

        def by_fmpy(steps):
            file = folder / "fmus" / "timed.py"
            file.write_text(re.sub(r"^STOP, STEP = .*$", f"STOP, STEP = {steps * STEP}, {STEP}", text, flags=re.M))
            runpy.run_path(str(file))["simulate"]()

        fmpy = least(by_fmpy, 100, 1100) / 1000
        print(f"three drives on a machine, {STEP * 1e3:g} ms, interpolated: run.py by FMPy {fmpy * 1e6:.0f} us a step")
        for repeat, seconds in per_step.items():
            print(f"  camdrive run, repeat = {repeat}: {seconds * 1e6:.2f} us a step, 1/{fmpy / seconds:.0f}")
        file = folder / "held.toml"
        file.write_text(THREE.replace("[part.machine]", 'exchange = "held"\n[part.machine]', 1))
        held = least(tool(file, "--output", "machine.w"), 1000, 41000) / 40000
        subprocess.run([CAMDRIVE, "system", file, "-o", folder / "held"], check=True, stdout=subprocess.DEVNULL)
        ssp = str(folder / "held" / "three_drives.ssp")
        by_ssp = least(lambda steps: simulate_ssp(ssp, stop_time=steps * STEP, step_size=STEP), 100, 5100) / 5000
        print(f"  camdrive run, held: {held * 1e6:.2f} us a step; fmpy.ssp {by_ssp * 1e6:.1f}")

        wheels = {}
        (folder / "wheel.toml").write_text(FLYWHEEL)
        for count in (1, 9):
            parts = "".join(f'[part.wheel_{i}]\nscene = "wheel.toml"\n' for i in range(count))
            wires = "".join(
                f'[[connection]]\nfrom = "wheel_{i}.E"\nto = "wheel_{i + 1}.M_an"\nfactor = {{}}\n' for i in range(count - 1)
            ).replace("{}", "-1e-3")
            file = folder / f"wheels_{count}.toml"
            file.write_text(f'name = "wheels"\nstop = 1\nstep = {STEP}\nexchange = "held"\n{parts}{wires}')
            wheels[count] = least(tool(file, "--output", "wheel_0.w"), 1000, 401000) / 400000
        more = (wheels[9] - wheels[1]) / 8
        alone = least(tool(folder / "wheel.toml", "--output", "w"), 1000, 401000) / 400000
        print(f"a flywheel more: {more * 1e6:.2f} us a step, of which its own step takes {alone * 1e6:.2f} at most")


if __name__ == "__main__":
    main()
