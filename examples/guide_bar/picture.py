"""Draws spread.svg into the folder of the study: the vibration of its runs and of the cam without
waves. Prints quantiles, and the mean squares with their values from superposition of the waves. Needs numpy, pandas, pyarrow and
matplotlib.

    camdrive study study.toml -o spread/
    python picture.py spread/
"""

import sys
import tomllib
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd

matplotlib.use("svg")
import matplotlib.pyplot as plt

matplotlib.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "spread", "font.size": 10}
folder = sys.argv[1]
runs = pd.read_parquet(f"{folder}/runs")
scene = tomllib.loads(Path(__file__).with_name("wavy.toml").read_text())["cam"]

# Harmonics of U, and of q and ÿ relative to them.
k, own, damping = np.arange(1, 31), 2 * np.pi * 270, 0.03
u = 0.94e-3 * (np.array(scene["a"][1:]) - 1j * np.array(scene["b"]))
w = k * 2 * np.pi * 30
q = w**2 / (own**2 - w**2 + 2j * damping * own * w)
turn = np.exp(1j * np.outer(np.linspace(0, 2 * np.pi, 36001), k))
# ½ (a² + b²) of a harmonic, and its expectation with waves.
square = np.abs(u) ** 2 / 2
with_waves = square + np.where(k > 5, 0.19e-6**2, 0)

rows = {
    "max |q|": (1e6, "greatest |q| in a turn (µm)", np.abs((turn @ (q * u)).real).max(), None),
    "rms der(y,2)": (1, "rms of ÿ (m/s²)", *(np.sqrt(np.abs(w**2 * (1 + q)) ** 2 @ s) for s in (square, with_waves))),
}
figure, panels = plt.subplots(1, 2, figsize=(9.6, 3.4), layout="constrained")
for panel, (name, (unit, label, without, expected)) in zip(panels, rows.items()):
    values = unit * runs[name]
    low, middle, high = values.quantile([0.05, 0.5, 0.95])
    panel.hist(values, 60, color="#e0a878", edgecolor="#222222", lw=0.3)
    panel.axvline(unit * without, color="#1f4e79", lw=1.6, label="cam without waves")
    for value in (low, middle, high):
        panel.axvline(value, color="#222222", lw=1, ls=(0, (4, 1.5)))
    panel.set(xlabel=label, ylabel="runs")
    print(f"{name}: without waves {unit * without:.4g}, quantiles 5, 50, 95 %: {low:.4g} {middle:.4g} {high:.4g}", end="")
    print(f", largest {values.max():.4g}", end="")
    if expected:
        squares = values**2
        error = squares.std() / np.sqrt(len(squares))
        print(f"; mean square {squares.mean():.5g} ± {error:.2g}, expected {(unit * expected) ** 2:.5g}", end="")
    print()
panels[1].plot([], [], color="#222222", lw=1, ls=(0, (4, 1.5)), label="5, 50, 95 % of the runs")
panels[1].legend(frameon=False, loc="upper right")
figure.savefig(f"{folder}/spread.svg", metadata={"Date": None, "Creator": None})
