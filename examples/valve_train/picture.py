"""Draws lift_off.svg into the folder of the study: how long the valve flies, over speed and preload, with the
lift-off speeds of the rigid and of the elastic valve train. Prints how often both agree. Needs numpy, pandas, pyarrow, matplotlib
and scipy.

    camdrive study study.toml -o lift_off/
    python picture.py lift_off/
"""

import sys

import matplotlib
import numpy as np
import pandas as pd
from scipy.optimize import brentq

matplotlib.use("svg")
import matplotlib.pyplot as plt

matplotlib.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "lift_off", "font.size": 10}
M1, M2, C, SPRING, N = 0.06, 0.12, 20e6, 25e3, 2**13
DAMPING = 2 * 0.03 * np.sqrt(C * M2)

# U and U″ over the turn: 10 mm by the polynomial 3-4-5 from 60° to 120° and back.
phi = 2 * np.pi * np.arange(N) / N
x = 1 - np.minimum(np.abs(phi - 2 * np.pi / 3) / (np.pi / 3), 1)
u = 0.01 * x**3 * (10 - 15 * x + 6 * x**2)
bend = 0.01 / (np.pi / 3) ** 2 * x * (60 - 180 * x + 120 * x**2)
k = np.fft.rfftfreq(N, 1 / N)


def least(speed, preload, elastic):
    """The least contact force of the periodic motion that keeps contact."""
    w = k * speed
    # y over U, and ÿ from U″, whose harmonics are exact.
    y = (C + 1j * w * DAMPING) / (C + SPRING - M2 * w**2 + 1j * w * DAMPING) if elastic else np.ones(len(k))
    inertia = np.fft.irfft((M1 + M2 * y) * np.fft.rfft(bend), N) * speed**2
    at_rest = preload * C / (C + SPRING) if elastic else preload
    return (inertia + at_rest + SPRING * np.fft.irfft(y * np.fft.rfft(u), N)).min()


def lift_off(preload, elastic):
    """The lowest speed (rad/s) at which this force vanishes."""
    speeds = np.pi / 30 * np.arange(1500, 2800, 5)
    first = next(i for i, w in enumerate(speeds) if least(w, preload, elastic) < 0)
    return brentq(least, *speeds[first - 1 : first + 1], args=(preload, elastic))


RPM, PRELOAD = 30 / np.pi, "follower[1].load.preload"
if __name__ == "__main__":
    folder = sys.argv[1]
    runs = pd.read_parquet(f"{folder}/runs")
    runs["rpm"], runs["flight"] = RPM * runs["drive.w"], 100 * (1 - runs["mean follower[1].contact"])
    flight = runs.pivot(index=PRELOAD, columns="rpm", values="flight")
    figure, panel = plt.subplots(figsize=(7.4, 4.4), layout="constrained")
    colours = {"cmap": "YlOrBr", "vmin": 0, "vmax": 100}
    image = panel.pcolormesh(flight.columns, flight.index, flight, rasterized=True, **colours)
    preloads = flight.index.to_numpy()
    for elastic, line, name in ((False, (0, (4, 1.5)), "rigid"), (True, "-", "elastic")):
        speeds = [RPM * lift_off(preload, elastic) for preload in preloads]
        panel.plot(speeds, preloads, color="#1f4e79", lw=1.4, ls=line, label=f"lift-off, {name} valve train")
        runs[name] = runs[PRELOAD].map(dict(zip(preloads, speeds)))
    panel.set(xlabel="speed of the camshaft (rpm)", ylabel="preload of the spring (N)", xlim=(1600, 2800), ylim=(150, 400))
    panel.legend(loc="upper left", frameon=False)
    figure.colorbar(image, label="time in flight (%)")
    figure.savefig(f"{folder}/lift_off.svg", metadata={"Date": None, "Creator": None})

    flies = runs["count follower[1].impacts"] > 0
    for name in ("rigid", "elastic"):
        print(pd.crosstab(runs["rpm"] > runs[name], flies, rownames=[name], colnames=["impacts"]))
    print(runs.groupby(PRELOAD)[["rigid", "elastic"]].first())
