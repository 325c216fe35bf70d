"""`camdrive stability` against a Taylor integration with 25 digits that shares nothing with it."""

import functools
import json
import os
import subprocess
from pathlib import Path

import mpmath as mp
import pytest
import tomllib

ROOT = Path(__file__).resolve().parents[2]
CAMDRIVE = os.environ.get("CAMDRIVE", str(ROOT / "target/release/camdrive"))
MANIPULATOR = ROOT / "examples/transfer_manipulator/hs3.toml"
CRITICAL = "1 ∓ tr M + det M"

DIGITS = 25
# Cells of a turn and order of the Taylor polynomials: J vanishes 0.4 rad off the real axis, five cells away, and 5^-24
# is 2e-17.
CELLS = 80
ORDER = 24


def study(scene, folder, *arguments):
    """The report of a scene."""
    command = [CAMDRIVE, "stability", str(scene), "-o", str(folder), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (report,) = Path(folder).glob("*.json")
    return json.loads(report.read_text())


def harmonics(scene):
    """J3/mean and the harmonics of m U'^2 of a Fourier law as pairs of k and the complex coefficient of e^(i k phi), over the
    mean."""
    text = tomllib.loads(scene.read_text())

    def number(value):
        return mp.mpf(str(value).split()[0])

    a = [number(value) for value in text["cam"]["a"]]
    scale = number(text["cam"]["scale"])
    slope = {}
    for k, value in enumerate(a):
        if k and value:
            # (a cos k phi)' = -k a sin k phi.
            slope[k] = mp.mpc(0, k * value * scale / 2)
            slope[-k] = mp.conj(slope[k])
    inertia = {0: number(text["elasticity"]["J"])}
    for k, x in slope.items():
        for l, y in slope.items():
            inertia[k + l] = inertia.get(k + l, 0) + number(text["elasticity"]["m"]) * x * y
    mean = mp.re(inertia[0])
    return tuple((k, value / mean) for k, value in inertia.items())


@functools.cache
def expansions(inertia, parts):
    """Taylor coefficients of J about the begin of each cell in powers of x = (angle - begin)/step, those of its first derivative and
    of half its second one; they are the same at every speed and damping."""
    count = CELLS // parts
    step = 2 * mp.pi / CELLS
    cells = []
    for cell in range(count):
        waves = [(value * mp.expj(k * cell * step), mp.mpc(0, k) * step) for k, value in inertia]
        j = [mp.re(mp.fsum(wave * rate**n for wave, rate in waves)) / mp.factorial(n) for n in range(ORDER + 3)]
        first = [n * j[n] for n in range(1, ORDER + 2)]
        half = [n * (n - 1) * j[n] / 2 for n in range(2, ORDER + 3)]
        cells.append((j, first, half))
    return cells


def monodromy(inertia, eta, theta, parts):
    """The map of (q, J q') over a period of J q'' + (2 theta/eta + J') q' + (1/eta^2 + J''/2) q = 0."""
    eta, theta = mp.mpf(eta), mp.mpf(theta)
    step = 2 * mp.pi / CELLS
    damping, stiffness = 2 * theta / eta * step, (step / eta) ** 2
    states = [(mp.mpf(1), mp.mpf(0)), (mp.mpf(0), mp.mpf(1))]
    for j, first, half in expansions(inertia, parts):
        for which, (q, v) in enumerate(states):
            # The coefficients of q, q' and q''.
            series, rates, bends = [q, v * step], [v * step], []
            # J q'' = -(d + J') q' - (lambda + J''/2) q, in powers of x.
            for n in range(ORDER - 1):
                right = -damping * rates[n] - stiffness * series[n]
                right -= mp.fdot(zip(first, reversed(rates))) + mp.fdot(zip(half, series[n::-1]))
                bends.append((right - mp.fdot(zip(j[1:], reversed(bends)))) / j[0])
                series.append(bends[n] / ((n + 2) * (n + 1)))
                rates.append((n + 2) * series[n + 2])
            states[which] = (mp.fsum(series), mp.fsum(n * c for n, c in enumerate(series)) / step)
    return mp.matrix([[states[0][0], states[1][0]], [states[0][1], states[1][1]]])


def left(m, n):
    """1 - s tr M + det M with s = (-1)^n: zero where a multiplier is s."""
    return 1 - (-1) ** n * (m[0, 0] + m[1, 1]) + m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    return study(MANIPULATOR, tmp_path_factory.mktemp("stability"), "--orders", "6", "--quick")


def test_boundaries_are_exact(report):
    with mp.workdps(DIGITS):
        inertia = harmonics(MANIPULATOR)
        theta = report["oscillator"]["damping_ratio"]
        parts = report["oscillator"]["periods_per_turn"]
        seen = 0
        for n, order in enumerate(report["orders"], start=1):
            places = [(eta, 0.0) for eta in order["undamped"]]
            places += [(eta, theta) for eta in order["damped"] or []]
            places.append((order["critical_eta"], order["critical_damping"]))
            for eta, damping in places:
                rest = left(monodromy(inertia, eta, damping, parts), n)
                assert abs(rest) <= 1e-12, f"order {n} at eta = {eta}, theta = {damping}: {CRITICAL} = {mp.nstr(rest, 5)}"
                seen += 1
        assert seen >= 18 and parts == 2


def test_critical_damping_is_the_highest(report):
    """Beside the speed at which an instability vanishes it is gone at less damping; to twelve digits."""
    with mp.workdps(DIGITS):
        inertia = harmonics(MANIPULATOR)
        for n, order in enumerate(report["orders"][:3], start=1):
            eta, theta = order["critical_eta"], order["critical_damping"]
            more = left(monodromy(inertia, eta, theta * (1 + 1e-9), 2), n)
            less = left(monodromy(inertia, eta, theta * (1 - 1e-9), 2), n)
            assert less < 0 < more, "theta* is right to nine digits at its speed"
            for part in (-0.01, 0.01):
                beside = left(monodromy(inertia, eta * (1 + part * theta), theta, 2), n)
                assert beside > 0, "no other speed is unstable at theta*"


def test_multipliers_at_the_speed_of_the_scene(report):
    with mp.workdps(DIGITS):
        at = report["speeds"][0]
        m = monodromy(harmonics(MANIPULATOR), at["eta"], report["oscillator"]["damping_ratio"], 1)
        expected = sorted(mp.eig(m, left=False, right=False), key=lambda x: mp.im(x))
        found = sorted((mp.mpc(*pair) for pair in at["multipliers"]), key=lambda x: mp.im(x))
        for x, y in zip(expected, found, strict=True):
            assert abs(x - y) < 1e-12, f"{mp.nstr(x, 15)} {mp.nstr(y, 15)}"
        assert at["stable"] and abs(at["radius"] - abs(found[0])) < 1e-12


def test_speeds_within_and_beside_an_instability(tmp_path):
    """A start from rest at 500 rpm grows without end, at 600 rpm it settles."""
    report = study(MANIPULATOR, tmp_path, "--orders", "2", "--quick", "--speed", "500 rpm", "--speed", "600 rpm")
    inside, outside = report["speeds"]
    assert not inside["stable"] and inside["radius"] > 1 and inside["order"] == 2.0
    assert inside["critical_damping"] > report["oscillator"]["damping_ratio"]
    assert outside["stable"] and outside["critical_damping"] == 0
    assert report["transients"][0]["settled_after"] is None
    assert report["transients"][1]["peak"] >= report["transients"][1]["steady"]["amplitude"] * (1 - 1e-5)
