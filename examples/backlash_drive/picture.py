"""Draws map.svg into the folder of the study: the impacts of its runs over K and μ with the borders of
the formulas. Prints how often both agree. Needs numpy, pandas, pyarrow and matplotlib.

    camdrive study study.toml -o map/
    camdrive clearance map.toml -o map/
    python picture.py map/
"""

import sys

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.path import Path

matplotlib.use("svg")
import matplotlib.pyplot as plt

matplotlib.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "map", "font.size": 10}
K_UNIT, M2 = 0.8e-6, 8.0

folder = sys.argv[1]
runs = pd.read_parquet(f"{folder}/runs")
runs["K"], runs["mu"] = runs["s"] / K_UNIT, runs["m1"] / M2
borders = list(pd.read_csv(f"{folder}/backlash_map.map.csv").groupby("border", sort=False))

points = np.log(runs[["K", "mu"]])
runs["formula"] = "none"
for name, curve in borders:
    if name == "elastic":
        inside = runs.K > np.interp(runs.mu, curve.mu, curve.K)
    else:
        inside = Path(np.log(curve[["K", "mu"]])).contains_points(points)
    runs.loc[inside & (runs.formula != "at once"), "formula"] = "elastic" if name == "elastic" else "at once"

figure, panels = plt.subplots(1, 2, figsize=(9.6, 4.4), sharey=True, layout="constrained")
cases = [(0.0, "First passage, undamped"), (160.0, "Settled motion, damping ratio 0.02")]
for panel, (b, title) in zip(panels, cases):
    case = runs[runs.b == b]
    more = case["count impacts"].sub(1).clip(0, 4)
    table = case.assign(more=more).pivot(index="mu", columns="K", values="more")
    colours = {"cmap": plt.get_cmap("YlOrBr", 5), "vmin": -0.5, "vmax": 4.5}
    image = panel.pcolormesh(table.columns, table.index, table, rasterized=True, **colours)
    for name, curve in borders:
        panel.plot(curve.K, curve.mu, color="#1f4e79", lw=1.2, ls="-" if name == "elastic" else (0, (4, 1.5)))
    panel.set(xscale="log", yscale="log", xlim=(0.1, 100), ylim=(0.0125, 3), title=title, xlabel="dynamic clearance K (1)")
    print(title, pd.crosstab(case.formula, more > 0).to_string(), sep="\n", end="\n\n")
panels[0].set_ylabel("mass ratio μ = m1/m2 (1)")
for name, line in [("elastic", "-"), ("at once", (0, (4, 1.5)))]:
    panels[0].plot([], [], color="#1f4e79", lw=1.2, ls=line, label=f"formula: border of release {name}")
panels[0].legend(loc="upper left", frameon=False, fontsize=9)
bar = figure.colorbar(image, ax=panels, ticks=range(5), label="further impacts in the passage")
bar.set_ticklabels(["0", "1", "2", "3", "≥ 4"])
figure.savefig(f"{folder}/map.svg", metadata={"Date": None, "Creator": None})
