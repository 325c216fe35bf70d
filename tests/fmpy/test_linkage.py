"""Mechanisms between cam and tool, against places of the links from circles that intersect and against energies of the
single links, both computed here."""

import cmath
import json
import math
import subprocess

import mpmath as mp
import numpy as np
import pytest

import reference
from conftest import CAMDRIVE, ROOT


def end(first, second, reach, length, sense):
    """Where two links of these lengths from the joints `first` and `second` meet; `sense` = 1: to the left of the way."""
    way = second - first
    distance = abs(way)
    along = (reach**2 - length**2 + distance**2) / (2 * distance)
    across = mp.sqrt(reach**2 - along**2)
    return first + way / distance * mp.mpc(along, sense * across)


class Link:
    def __init__(self, values, name):
        self.length, self.m, self.J, self.x, self.y = (
            mp.mpf(values[f"{name}.{key}"]) for key in ("length", "m", "J", "x", "y")
        )

    def place(self, first, second):
        """Centre of mass and direction."""
        direction = (second - first) / self.length
        return self, first + direction * mp.mpc(self.x, self.y), direction


class Chain:
    """The mechanisms of a follower, by the parameters of the FMU; both branches are plus in the test scene."""

    def __init__(self, package, j):
        self.values = package.parameters()
        self.prefix = f"follower[{j}]."
        self.cam = reference.Series.of(package, f"{self.prefix}cam")
        self.inertia = mp.mpf(self.values.get(f"{self.prefix}m", self.values.get(f"{self.prefix}J")))

    def moved(self, phi):
        """The tool's coordinate, the places of the links, and the masses that move along a line with their places."""
        y = self.cam.derivative(phi, 0, mp.sin, mp.cos)
        places, masses = [], []
        i = 1
        while f"{self.prefix}linkage[{i}].input_offset" in self.values:
            name = f"{self.prefix}linkage[{i}]"
            v = {key[len(name) + 1 :]: value for key, value in self.values.items() if key.startswith(name + ".")}
            theta = y + mp.mpf(v["input_offset"])
            zero = mp.mpc(0)
            if "ground" in v:
                bars = [Link(v, key) for key in ("input", "coupler", "output")]
                ground, pin = mp.mpc(v["ground"]), bars[0].length * mp.expj(theta)
                joint = end(ground, pin, bars[2].length, bars[1].length, -1)
                y = mp.arg(joint - ground)
                places += [bars[0].place(zero, pin), bars[1].place(pin, joint), bars[2].place(ground, joint)]
            else:
                bars = [Link(v, key) for key in ("crank", "rod")]
                pin = bars[0].length * mp.expj(theta)
                y = pin.real + mp.sqrt(bars[1].length ** 2 - (pin.imag - v["offset"]) ** 2)
                places += [bars[0].place(zero, pin), bars[1].place(pin, mp.mpc(y, v["offset"]))]
                masses.append((mp.mpf(v["slider_m"]), y))
            y -= mp.mpf(v["output_offset"])
            i += 1
        return y, places, masses + [(self.inertia, y)]

    def tool(self, phi):
        return self.moved(phi)[0]

    def energy(self, phi):
        """Twice the kinetic energy of everything at unit speed of the shaft, link by link."""
        h = mp.mpf(10) ** -12
        (_, before, masses_before), (_, after, masses_after) = (self.moved(phi + part * h) for part in (-1, 1))
        total = mp.mpf(0)
        for (link, start, start_direction), (_, place, direction) in zip(before, after, strict=True):
            # A direction is a unit vector.
            velocity, turn = ((b - a) / (2 * h) for a, b in ((start, place), (start_direction, direction)))
            total += link.m * abs(velocity) ** 2 + link.J * abs(turn) ** 2
        for (m, start), (_, place) in zip(masses_before, masses_after, strict=True):
            total += m * ((place - start) / (2 * h)) ** 2
        return total


@pytest.fixture(scope="module")
def chains(fmu):
    package = fmu("machine_linkage")
    return package, [Chain(package, j) for j in (1, 2)]


@pytest.fixture(scope="module", autouse=True)
def precision():
    with mp.workdps(40):
        yield


@pytest.mark.parametrize("degrees", [0.0, 33.0, 97.5, 180.0, 251.0, 340.0])
def test_tools_levers_and_inertia_at_an_angle(chains, degrees):
    package, followers = chains
    phi = math.radians(degrees)
    with package.unit() as unit:
        unit.initialise(values={"phi_start": phi, "w_start": 30.0, "start.mode": 1})
        w, a = unit.get("w", "a")
        for j, chain in enumerate(followers, start=1):
            y = [mp.diff(chain.tool, mp.mpf(phi), n, h=mp.mpf(10) ** -10) for n in range(3)]
            u = [chain.cam.derivative(phi, n) for n in range(3)]
            for name, f in ((f"U[{j}]", y), (f"lever[{j}]", u)):
                expected = [f[0], f[1] * w, f[2] * w**2 + f[1] * a]
                got = unit.get(name, f"der({name})", f"der({name},2)")
                scales = [0.05, 0.05 * 30, 0.05 * 30**2]
                assert all(abs(g - e) <= 2e-14 * s for g, e, s in zip(got, expected, scales)), (name, got, expected)
        inertia = package.parameters()["J0"] + sum(chain.energy(mp.mpf(phi)) for chain in followers)
        assert abs(unit.get("J") - inertia) <= 1e-14 * inertia


def test_the_tool_moves_over_a_turn_as_the_scene_says(chains):
    """The scene gives the motion of the first tool; the lever's law was found by turning the mechanisms back."""
    package, (chain, _) = chains
    tool = reference.Series([1e-3, -36e-3, 3e-3, -2e-3], [0.0, 0.0, 2e-3, 1e-3])
    for k in range(24):
        phi = math.radians(15 * k)
        for n, scale in enumerate((0.04, 0.04, 0.08)):
            error = mp.diff(chain.tool, mp.mpf(phi), n, h=mp.mpf(10) ** -10) - tool.derivative(phi, n)
            assert abs(error) < 1e-12 * scale
    assert len(chain.cam.a) < 60


@pytest.fixture(scope="module")
def run_up(chains):
    """Waves of J over the turn, the trigonometric polynomial of 128 energies, whose harmonics have died away by then; the
    angle and the speed after a second."""
    package, followers = chains
    p = package.parameters()
    n = 128
    samples = [p["J0"] + sum(float(chain.energy(mp.mpf(2 * math.pi * i / n))) for chain in followers) for i in range(n)]
    spectrum = np.fft.rfft(samples) / n
    assert np.abs(spectrum[-20:]).max() < 1e-12 * samples[0]
    orders = np.arange(len(spectrum))
    spectrum[1:] *= 2

    waves = lambda phi: spectrum * np.exp(1j * orders * phi)

    def rhs(_, state):
        phi, w = state
        there = waves(phi)
        inertia, slope = there.real.sum(), (1j * orders * there).real.sum()
        torque = reference.kloss(w, p["motor.M_k"], p["motor.s_k"], p["motor.w_s"])
        return [w, (torque - 0.5 * slope * w * w) / inertia]

    return waves, reference.integrate(rhs, [0.0, 0.0], np.linspace(0.0, 1.0, 101))[-1]


@pytest.mark.parametrize("size", [1e-3, 0.1])
def test_run_up_from_standstill(chains, run_up, size):
    package, _ = chains
    p = package.parameters()
    waves, expected = run_up
    with package.unit() as unit:
        unit.initialise(values={"phi_start": 0.0, "w_start": 0.0, "start.mode": 1})
        for k in range(round(1.0 / size)):
            unit.step_to((k + 1) * size)
        phi, w, j = unit.get("phi", "w", "J")
    assert abs(phi - expected[0]) <= 1e-9 * expected[0] and abs(w - expected[1]) <= 1e-9 * p["motor.w_s"]
    assert abs(j - waves(phi).real.sum()) <= 1e-11 * j


def test_the_periodic_motion_that_steady_finds(chains):
    """The period of the command is that of the FMU, and the energy over a turn is balanced."""
    package, _ = chains
    scene = ROOT / "tests" / "fmpy" / "scenes" / "machine_linkage.toml"
    told = subprocess.run([CAMDRIVE, "steady", "--json", str(scene)], check=True, capture_output=True, text=True).stdout
    (motion,) = json.loads(told)["motions"]
    assert motion["stable"]
    period = motion["period"]
    with package.unit() as unit:
        unit.initialise(values={"start.mode": 2})
        assert abs(unit.get("start.period") - period) <= 1e-12 * period
        before = np.array(unit.get("w", "E", "U[1]", "U[2]"))
        unit.step_to(period)
        assert np.allclose(unit.get("w", "E", "U[1]", "U[2]"), before, rtol=1e-9, atol=1e-12)


def test_lengths_are_parameters_that_are_checked(chains):
    package, _ = chains
    with package.unit() as unit:
        unit.initialise(values={"follower[2].linkage[1].output.length": 0.15, "follower[2].J": 0.2, "phi_start": 0.5})
        position = unit.get("U[2]")
    # The longer output link turns less.
    theta = math.radians(95) + reference.Series.of(package, "follower[2].cam").derivative(0.5, 0)
    joint = end(mp.mpc(0.3), 0.1 * mp.expj(theta), mp.mpf(0.15), mp.mpf(0.29), -1)
    assert abs(position + math.radians(98.75771365194596) - cmath.phase(complex(joint) - 0.3)) < 1e-13
    with package.unit() as unit:
        with pytest.raises(Exception):
            unit.initialise(values={"follower[2].linkage[1].coupler.length": 0.1})
        assert any("follower[2].linkage[1]" in text and "do not reach" in text for _, _, text in unit.log)
