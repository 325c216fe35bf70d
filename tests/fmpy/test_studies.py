"""The studies of the examples, with fewer runs, against closed forms, formulas and densely sampled runs."""

import subprocess
import tomllib

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from conftest import CAMDRIVE, ROOT

EXAMPLES = ROOT / "examples"


def study(name, folder, *changes):
    """The table of the study of an example, its text changed by pairs of old and new."""
    text = (EXAMPLES / name / "study.toml").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    scene = tomllib.loads(text)["scene"]
    (folder / "study.toml").write_text(text.replace(f'"{scene}"', f"'{EXAMPLES / name / scene}'"))
    subprocess.run([CAMDRIVE, "study", folder / "study.toml", "-o", folder / "store"], check=True, capture_output=True)
    table = pd.read_parquet(folder / "store" / "runs")
    assert (table.status == "ok").all()
    return table


def test_waves_of_a_cam_are_superposed(tmp_path):
    runs = study("guide_bar", tmp_path, ("10_000", "400"))
    scene = tomllib.loads((EXAMPLES / "guide_bar" / "wavy.toml").read_text())["cam"]
    k, own, damping, deviation = np.arange(1, 31), 2 * np.pi * 270, 0.03, 0.19e-6
    w = k * 2 * np.pi * 30
    q = w**2 / (own**2 - w**2 + 2j * damping * own * w)
    square = np.abs(w**2 * (1 + q)) ** 2
    u = np.tile(0.94e-3 * (np.array(scene["a"][1:]) - 1j * np.array(scene["b"])), (len(runs), 1))
    without = square @ np.abs(u[0]) ** 2 / 2
    for i in k[5:]:
        u[:, i - 1] = runs[f"cam.a[{i}]"] - 1j * runs[f"cam.b[{i}]"]

    # Each run.
    np.testing.assert_allclose(runs["rms der(y,2)"], np.sqrt(np.abs(u) ** 2 @ square / 2), rtol=1e-6)
    grid = 2 * np.pi * np.arange(7200) / 7200
    course = np.abs(((q * u) @ np.exp(1j * np.outer(k, grid))).real)
    largest, place = course.max(axis=1), course.argmax(axis=1)
    # The parabola through the largest of the samples and its neighbours.
    low, high = (course[range(len(runs)), (place + i) % len(grid)] for i in (-1, 1))
    largest += (high - low) ** 2 / (8 * (2 * largest - high - low))
    np.testing.assert_allclose(runs["max |q|"], largest, rtol=1e-6)

    # All runs: expectation and variance of Σ g_k ½ (a_k² + b_k²), for which both squares have the variance 2 σ⁴.
    squares = runs["rms der(y,2)"] ** 2
    expected = without + square[5:].sum() * deviation**2
    variance = (square[5:] ** 2).sum() * deviation**4
    assert abs(squares.mean() - expected) < 4 * np.sqrt(variance / len(runs))
    # The standard error of a variance, for the exponential distribution of the greatest wave: √(8/n).
    assert abs(squares.var() / variance - 1) < 4 * np.sqrt(8 / len(runs))


def is_interrupted(clearance, mu):
    """Whether m1 leaves the flank again after an impact, at once or within a natural period; Kaltofen's formulas (15) to (26)."""
    a = np.sqrt(mu / (mu + 1))
    tau = brentq(lambda t: t**3 - 6 * clearance + 6 / (mu + 1) * (t - a * np.sin(t / a)), 0, 1.001 * (6 * clearance) ** (1 / 3))
    cosine, sine = tau**2 / 2 - mu / (mu + 1) * (1 - np.cos(tau / a)), a * np.sin(tau / a) - tau
    after = np.linspace(0, 2 * np.pi, 2001)
    return ((mu + 1) * (tau + after) + cosine * np.sin(after) + sine * np.cos(after)).min() < 0


def test_impacts_follow_where_the_formulas_say(tmp_path):
    runs = study("backlash_drive", tmp_path, ("count = 61", "count = 31"), ("count = 51", "count = 26"))
    predicted = np.array([is_interrupted(s / 0.8e-6, m1 / 8) for s, m1 in zip(runs["s"], runs["m1"])])
    followed, undamped = runs["count impacts"] > 1, runs["b"] == 0
    assert (followed == predicted)[undamped].all() and predicted.mean() > 0.2
    # Damping prevents some, and makes none.
    assert not (followed & ~predicted).any() and 0.5 < followed[~undamped].sum() / predicted[~undamped].sum() < 0.9


def test_the_valve_leaves_its_cam_where_the_linear_force_is_none(tmp_path):
    runs = study("valve_train", tmp_path, ("count = 121", "count = 13"), ("count = 26", "count = 6"))
    # Harmonics of the law: 10 mm by the polynomial 3-4-5 from 60° to 120° and back. Jumps of the jerk need many.
    n, m1, m2, c, spring = 2**16, 0.06, 0.12, 20e6, 25e3
    damping = 2 * 0.03 * np.sqrt(c * m2)
    x = 1 - np.minimum(np.abs(2 * np.pi * np.arange(n) / n - 2 * np.pi / 3) / (np.pi / 3), 1)
    u = np.fft.rfft(0.01 * x**3 * (10 - 15 * x + 6 * x**2))
    bend = np.fft.rfft(0.01 / (np.pi / 3) ** 2 * x * (60 - 180 * x + 120 * x**2))
    w = np.outer(runs["drive.w"], np.fft.rfftfreq(n, 1 / n))
    y = (c + 1j * w * damping) / (c + spring - m2 * w**2 + 1j * w * damping)
    force = np.fft.irfft((m1 + m2 * y) * bend * runs["drive.w"].to_numpy()[:, None] ** 2 + spring * y * u, n)
    least = force.min(axis=1) + runs["follower[1].load.preload"] * c / (c + spring)
    flies = runs["count follower[1].impacts"] > 0
    assert ((least < 0) == flies).all() and 10 < flies.sum() < 60
    error = (runs["min follower[1].force"] - least)[~flies] / runs["max follower[1].force"][~flies]
    assert error.abs().max() < 2e-6
    # A count, the time on the cam and the greatest gap say the same.
    assert ((runs["mean follower[1].contact"] < 1) == flies).all() and ((runs["max follower[1].gap"] > 0) == flies).all()
