"""Runs the guide bar up from standstill to 1800 rpm within 0.5 s: how to feed phi, w and a.

    camdrive export examples/guide_bar/run_up.toml
    python examples/guide_bar/run_up.py guide_bar_run_up.fmu
"""

import sys

import fmpy
import numpy as np

RAMP, STOP, STEP = 0.5, 0.6, 1e-4  # s
SPEED = 1800 * 2 * np.pi / 60  # rad/s


def signals():
    """One row per communication point: within a step the FMU continues phi with the w and a of its start."""
    t = np.arange(round(STOP / STEP) + 1) * STEP
    a = np.where(t < RAMP - STEP / 2, SPEED / RAMP, 0.0)
    w = SPEED * np.minimum(t / RAMP, 1.0)
    phi = np.where(t < RAMP, 0.5 * SPEED / RAMP * t**2, SPEED * (t - RAMP / 2))
    columns = [("time", float), ("phi", float), ("w", float), ("a", float)]
    return np.array(list(zip(t, phi, w, a)), dtype=columns)


def run(fmu):
    return fmpy.simulate_fmu(
        fmu, stop_time=STOP, step_size=STEP, output_interval=STEP, input=signals(), output=["x", "y", "q", "force", "tau"]
    )


if __name__ == "__main__":
    result = run(sys.argv[1])
    print(f"largest |q|     {1e6 * np.abs(result['q']).max():.2f} um")
    print(f"largest |force| {np.abs(result['force']).max():.0f} N")
