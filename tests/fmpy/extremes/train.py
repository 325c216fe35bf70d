"""Drive train. Smooth trains against Dormand and Prince, those that leave their cams and hit them by their energy: without motor and
dampers, kinetic energy, that of springs and weights, and what impacts have taken are constant together."""

import math
import tomllib

import mpmath as mp
import numpy as np

import reference
from extremes import truth
from extremes.suite import HERE, case, error, probe, record, refusal, refused

DRIVE = "drive train"
G = 9.81
BASE = {
    "J0": 0.9, "load.b": 0.1, "motor.M_k": 60.0, "motor.s_k": 0.2, "motor.w_s": 15.0, "w_start": 14.0, "phi_start": 0.0,
    "follower[1].m": 3.0, "follower[1].c": 12000.0, "follower[1].b": 20.0, "follower[1].m_roller": 0.4,
    "follower[2].m": 4.0, "follower[2].J": 0.15, "follower[2].c": 900.0, "follower[2].b": 1.5, "follower[3].m": 0.8,
}
NAMES = ("phi", "w", "follower[1].q", "der(follower[1].q)", "follower[2].q", "der(follower[2].q)")
DORMAND = "Dormand-Prince 8(5,3) at 2e-14"


def equations(p, cams):
    """The rates of φ, φ̇, q, q̇ of the output and q, q̇ of the shaft."""

    def load(m, y, v):
        return -m * G - 40.0 - 3000.0 * (y - 0.01) - 15.0 * v

    def rates(t, s):
        phi, w, q1, v1, q2, v2 = s
        psi, speed = phi + q2, w + v2
        u, u1, u2 = (cams[0].derivative(phi, k) for k in range(3))
        _, s1, s2 = (cams[1].derivative(psi, k) for k in range(3))
        r, r1, r2 = (cams[2].derivative(phi, k) for k in range(3))
        force = -(p["follower[1].c"] * q1 + p["follower[1].b"] * v1)
        torque = -(p["follower[2].c"] * q2 + p["follower[2].b"] * v2)
        m, roller, m2, m3 = p["follower[1].m"], p["follower[1].m_roller"], p["follower[2].m"], p["follower[3].m"]
        inertia = p["J0"] + roller * u1 * u1 + m3 * r1 * r1
        driving = reference.kloss(w, p["motor.M_k"], p["motor.s_k"], p["motor.w_s"]) - p["load.b"] * w
        braking = (roller * u1 * u2 + m3 * r1 * r2) * w * w + u1 * force + torque - r1 * load(m3, r, r1 * w)
        a = (driving - braking) / inertia
        tool = (force + load(m, u + q1, u1 * w + v1)) / m
        cam = (torque - m2 * s1 * s2 * speed**2) / (p["follower[2].J"] + m2 * s1 * s1)
        return [w, a, v1, tool - u2 * w * w - u1 * a, v2, cam - a]

    return rates


class From:
    """A law whose angle counts from `start`, a number as the FMU has it."""

    def __init__(self, law, start):
        self.law, self.start = law, start

    def derivative(self, phi, order):
        return self.law.derivative(phi + self.start, order)


def smooth(packages, times, **changes):
    p = BASE | changes
    package = packages["train"]
    with probe(package, p) as unit:
        reached, got = record(unit, times, NAMES)
        with mp.workdps(40):
            turn = float(mp.mpf(p["phi_start"]) % (2 * mp.pi))
        cams = [From(reference.Series.of(package, f"follower[{j}].cam"), turn) for j in (1, 2, 3)]
        # Between them for the sizes.
        between = np.linspace(0.0, reached[-1], 41)
        grid = np.array(sorted({0.0, *between, *reached}))
        w = abs(p["w_start"]) or 1.0
        start = [0.0, p["w_start"], 0.0, 0.0, 0.0, 0.0]
        states = truth.integrate(equations(p, cams), start, grid, [1.0, w, 1e-3, 1e-3 * w, 1e-2, 1e-2 * w])
        sizes = np.abs(states).max(axis=0)
        # As a number the angle is rounded.
        sizes[0] = max(sizes[0], 1e-3 * p["phi_start"])
        got[:, 0] -= p["phi_start"]
        expected = states[[int(np.argmin(np.abs(grid - t))) for t in reached]]
        return unit.outcome(error(got, expected, sizes))


def declare(extreme, times, bound=1e-9, **changes):
    @case(DRIVE, extreme, DORMAND, bound)
    def run(packages):
        return smooth(packages, times, **changes)


def both(name, factor):
    return {f"follower[{j}].{name}": factor * BASE[f"follower[{j}].{name}"] for j in (1, 2)}


TURN = 2 * math.pi / 14.0
declare("stiffness × 1e9, first vibrations", [1e-6, 1e-5], **both("c", 1e9))
declare("stiffness × 1e-9", [0.1, 0.5, 1.0], **both("c", 1e-9))
declare("damping 0", [0.1, 0.5, 1.0], **both("b", 0.0))
declare("damping 1e6 × critical, first decay", [1e-10, 1e-9, 1e-8], **{"follower[1].b": 3.8e8, "follower[2].b": 2.3e7})
declare("follower of 1e-6 kg", [1e-4, 5e-4], **{"follower[1].m": 1e-6, "follower[1].m_roller": 1e-6, "follower[1].b": 2e-3})
declare("J0 = 1e6 kg·m²", [0.1, 0.5, 1.0], J0=1e6)
declare("J0 = 1e-6 kg·m²", [1e-4, 1e-3, 5e-3], J0=1e-6)
declare("speed 1e5 rad/s, two turns", [2e-5, 1e-4], w_start=1e5)
declare("speed −14 rad/s against the motor", [0.1, 0.5], w_start=-14.0)
declare("speed 0, run-up", [1e-6, 0.1, 1.0], w_start=0.0)
declare("phase start 1e12 rad", [0.1, 0.5], phi_start=1e12)
declare("ten revolutions in one step", [10 * TURN])
declare("steps of 1 µs", [0.3 + 1e-6 * i for i in range(1000)])
declare("communication steps 1e-12 … 1 s in one run", np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1e-1, 1.0, 1e-3, 1e-6, 1e-9]))

ENERGY = "kinetic energy, springs, weights and losses of impacts together are constant; 0 ≤ gap ≤ s"


class Energy:
    """Of a train without motor and dampers, from its scene and changes of it."""

    def __init__(self, name, changes):
        followers = tomllib.loads((HERE / "scenes" / f"{name}.toml").read_text())["follower"]
        self.followers = list(enumerate(followers, 1))
        self.changes = changes

    def of(self, j, section, key):
        value = section.get(key, 0.0)
        value = float(value.split()[0]) * (1e-3 if "mm" in value else 1.0) if isinstance(value, str) and value != "inf" else value
        return self.changes.get(f"follower[{j}].{key}", value)

    def at(self, unit):
        """All of it, and that of the followers without their shares of the shaft's inertia."""
        shaft, w = unit.get("E", "w")
        own = 0.0
        for j, follower in self.followers:
            get = lambda *names: unit.get(*(name.replace("#", f"follower[{j}]") for name in names))
            y, v = get("#.y", "der(#.y)")
            elastic, backlash, load = (follower.get(key, {}) for key in ("elasticity", "backlash", "load"))
            m, roller, x1 = self.of(j, follower, "m"), 0.0, 0.0
            if elastic:
                m, (q, rate) = self.of(j, elastic, "m"), get("#.q", "der(#.q)")
                own += self.of(j, elastic, "c") * q * q / 2 + m * v * v / 2
                if elastic["place"] == "shaft":
                    own += self.of(j, elastic, "J") * (w + rate) ** 2 / 2
            elif backlash:
                m, roller = self.of(j, backlash, "m2"), self.of(j, backlash, "m1")
                x1, v1, q, gap, contact, lost = get("#.x1", "der(#.x1)", "#.q", "#.gap", "#.contact", "#.energy_loss")
                s = self.of(j, backlash, "s")
                assert lost >= 0.0 and gap >= -1e-15 and (s == "inf" or gap <= s * (1 + 1e-12) + 1e-15), (j, gap, lost)
                own += lost + self.of(j, backlash, "c") * q * q / 2 + m * v * v / 2
                # In contact it is a part of J.
                own += 0.0 if contact else roller * v1 * v1 / 2
            spring = load.get("spring", {})
            preload = self.changes.get(f"follower[{j}].load.preload", self.of(j, spring, "preload"))
            c = self.changes.get(f"follower[{j}].load.c", spring.get("c", 0.0))
            own += preload * y + c * (y - spring.get("at", 0.0)) ** 2 / 2
            own += (G if "gravity" in load else 0.0) * (m * y + roller * x1)
        return shaft + own, own


def conserved(packages, name, times, **changes):
    energy = Energy(name, changes)
    with probe(packages[name], changes) as unit:
        start, own = energy.at(unit)
        largest, worst = abs(own), 0.0
        for time in times:
            unit.step_to(time)
            now, own = energy.at(unit)
            largest, worst = max(largest, abs(own)), max(worst, abs(now - start))
        return unit.outcome(worst / largest)


def declare_energy(extreme, times, bound=1e-9, scene="train_lift", **changes):
    @case(DRIVE, extreme, ENERGY, bound)
    def run(packages):
        return conserved(packages, scene, times, **changes)


def springs(preload, c):
    return {"follower[1].load.preload": preload, "follower[1].load.c": c}


ROUND = 2 * math.pi / 150.0
EVEN = np.arange(1, 101) * 0.1 * ROUND
declare_energy("lift-off and clearance, ten turns", EVEN)
declare_energy("lift-off and clearance, ten revolutions in one step", [10 * ROUND])
declare_energy("lift-off and clearance, steps of 1 µs", [0.01 + 1e-6 * i for i in range(2000)])
declare_energy("clearance 1e-12 m", EVEN[:20], **{"follower[2].s": 1e-12})
declare_energy("clearance of one stroke", EVEN, **{"follower[2].s": 0.02})
declare_energy("preload 1e-9 N, no spring", EVEN, **springs(1e-9, 0.0))
declare_energy("preload 1e6 N", EVEN, **springs(1e6, 2500.0))
declare_energy("mass ratio m1/m2 = 1e-6", EVEN[:30], **{"follower[1].m1": 5e-7, "follower[2].m1": 6e-7})
declare_energy("mass ratio m1/m2 = 1e6", EVEN, **{"follower[1].m1": 15.0, "follower[1].m2": 1.5e-5})
declare_energy("restitution 1", EVEN, **{"follower[1].e": 1.0, "follower[2].e": 1.0})
declare_energy("restitution 1 − 1e-9", EVEN, **{"follower[1].e": 1 - 1e-9, "follower[2].e": 1 - 1e-9})
declare_energy("restitution 0.99", EVEN[:40], **{"follower[1].e": 0.99, "follower[2].e": 0.99})
declare_energy("clearance, stiffness × 1e6", [1e-5 * i for i in range(1, 21)], **{"follower[1].c": 4e11, "follower[2].c": 3e11})
declare_energy("lift-off and clearance, J0 = 1e-6 kg·m²", EVEN[:20], J0=1e-6)
declare_energy("lift-off and clearance, speed 1e4 rad/s", EVEN * 150.0 / 1e4, w_start=1e4)
declare_energy("lift-off and clearance, speed −150 rad/s", EVEN, w_start=-150.0)
SIXTEEN = np.arange(1, 51) * 0.1 * 2 * math.pi / 60.0
declare_energy("sixteen followers, five turns", SIXTEEN, scene="train_sixteen")
declare_energy("sixteen followers, five turns in one step", SIXTEEN[-1:], scene="train_sixteen")
declare_energy("sixteen followers, J0 = 1e-6 kg·m²", SIXTEEN[:10], scene="train_sixteen", J0=1e-6)


@refusal(DRIVE, "clearance 0", "without clearance it is an elastic output", "no flight and no impact would be left")
def no_clearance(packages):
    return refused(packages["train_lift"], {"follower[2].s": 0.0})


@refusal(DRIVE, "mass 0", "`follower[1].m`: 0 kg is not admissible", "the equation would have no acceleration")
def no_mass(packages):
    return refused(packages["train"], {"follower[1].m": 0.0})


@refusal(DRIVE, "J0 = 0 where U′ = 0", "the moment of inertia that follows the shaft must be positive", "no torque could be accelerated")
def no_inertia(packages):
    return refused(packages["train"], {"J0": 0.0})


@refusal(DRIVE, "a step of 1e6 s", "need more work than one call may take", "nobody waits for it")
def endless(packages):
    return refused(packages["train"], run=lambda unit: unit.step(1e6))
