"""Draws motion.svg beside this script: a turn of the cam's side and of the elastic tool. Takes numpy and matplotlib.

    camdrive run examples/guide_bar/traditional.toml --output x,q --stop "0.2 s" --step "0.1 ms" -o motion.csv
    python docs/motion.py motion.csv
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("svg")
import matplotlib.pyplot as plt

matplotlib.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "motion", "font.size": 10, "font.family": "sans-serif"}
EXAGGERATED = 10
TURN = 1 / 30

time, x, q = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1).T
# The last whole turn, behind the transient.
last = time >= time[-1] - TURN * (1 + 1e-9)
angle, x, q = 360 * (time[last] - time[last][0]) / TURN, 1e3 * x[last], 1e3 * q[last]

figure, axes = plt.subplots(figsize=(5.7, 3.4), layout="constrained")
for begin, end in ((0, 32), (148, 212), (328, 360)):
    axes.axvspan(begin, end, color="#ececec", lw=0)
axes.plot(angle, x + EXAGGERATED * q, color="#c05a10", lw=1.6, ls=(0, (5, 1.5)))
axes.plot(angle, x, color="#1f4e79", lw=1.8)
axes.text(180, 0.50, "dwell", ha="center", color="#222222")
axes.annotate("cam", (100, np.interp(100, angle, x)), (112, 0.35), arrowprops={"arrowstyle": "-", "lw": 0.6})
axes.annotate(
    f"tool, vibration\ndrawn {EXAGGERATED} times",
    (254, np.interp(254, angle, x + EXAGGERATED * q)),
    (270, 0.82),
    arrowprops={"arrowstyle": "-", "lw": 0.6},
)
axes.set(xlabel="angle of the cam (°)", ylabel="lift (mm)", xlim=(0, 360), xticks=range(0, 361, 45))
in_dwell = 1e3 * np.abs(q[(angle > 150) & (angle < 210)]).max()
axes.set_title(f"Guide bar at 1800 rpm: the tool vibrates by {in_dwell:.1f} µm in the dwell", fontsize=10, loc="left")
figure.savefig(Path(__file__).with_suffix(".svg"), metadata={"Date": None, "Creator": None})
