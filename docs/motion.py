"""Draws motion.svg next to this script: a turn of the guide bar of README.md. Needs numpy and matplotlib.

    camdrive steady guide_bar.toml --report motion/
    python docs/motion.py motion/guide_bar.turn.csv
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("svg")
import matplotlib.pyplot as plt

matplotlib.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "motion", "font.size": 10, "font.family": "sans-serif"}
EXAGGERATED = 10

turn = np.genfromtxt(sys.argv[1], delimiter=",", names=True)
angle, x, y, q = (turn[name] for name in ("phi_deg", "x_mm", "y_mm", "q_mm"))

figure, axes = plt.subplots(figsize=(5.7, 3.4), layout="constrained")
for begin, end in ((0, 18), (162, 198), (342, 360)):
    axes.axvspan(begin, end, color="#ececec", lw=0)
axes.plot(angle, x + EXAGGERATED * q, color="#c05a10", lw=1.6, ls=(0, (5, 1.5)))
axes.plot(angle, x, color="#1f4e79", lw=1.8)
axes.text(180, -0.30, "dwell", ha="center", color="#222222")
axes.annotate("cam", (70, np.interp(70, angle, x)), (30, 0.0), arrowprops={"arrowstyle": "-", "lw": 0.6})
axes.annotate(
    f"tool, deformation\ndrawn {EXAGGERATED} times",
    (70, np.interp(70, angle, x + EXAGGERATED * q)),
    (105, 0.40),
    arrowprops={"arrowstyle": "-", "lw": 0.6},
)
axes.set(xlabel="angle of the cam (°)", ylabel="lift (mm)", xlim=(0, 360), xticks=range(0, 361, 45))
dwell = y[(angle > 162) & (angle < 198)]
moved = 1e3 * np.abs(dwell - dwell.mean()).max()
axes.set_title(f"Guide bar at 1800 rpm: the tool moves by {moved:.2f} µm in the dwell", fontsize=10, loc="left")
figure.savefig(Path(__file__).with_suffix(".svg"), metadata={"Date": None, "Creator": None})
