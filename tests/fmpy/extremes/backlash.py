"""Drive with backlash: exact phases with switching instants by bisection in 25 digits, limits, and the balances of
momentum and energy where neither exists."""

import math

import mpmath as mp
import numpy as np

import reference
from extremes import truth
from extremes.suite import Moved, case, error, probe, record, refusal, refused

DRIVE = "drive with backlash"
NAMES = ("x1", "der(x1)", "y", "der(y)")
A, B = [0.0, -1e-2, 1.2e-3, 5e-4, -2e-4], [0.0, 8e-4, -3e-4, 0.0, 1e-4]
BASE = {
    "m1": 2.0, "m2": 8.0, "c": 2e6, "b": 0.0, "s": 5e-5, "e": 0.0, "drive.w": 25.0, "drive.phi_start": math.radians(200),
    "start.q": 3.0244121706142e-5, "start.q_dot": 1.6775059931619e-3,
}
CRITICAL = 2 * math.sqrt(BASE["c"] * BASE["m2"])
PHASES = "exact phases, switching instants by bisection, 25 digits"
BALANCES = "momentum m1 ẋ1 + m2 ẏ and energy balances, 0 ≤ gap ≤ s"


def law(package, cosines, sines):
    """`sines` starts with b₁."""
    values = {name: 0.0 for name in package.variables if name.startswith("cam.")}
    values |= {f"cam.a[{k}]": v for k, v in enumerate(cosines)} | {f"cam.b[{k + 1}]": v for k, v in enumerate(sines)}
    return values, reference.Series(cosines, [0.0, *sines])


def settings(package, values, p):
    """The values that the FMU has, and the motion for one that follows inputs."""
    motion = None if "drive.w" in package.variables else Moved(p["drive.phi_start"], p["drive.w"])
    return {k: v for k, v in (values | p | {"start.mode": 2}).items() if k in package.variables}, motion


def started(package, values, p):
    """An instance at its start, and what sets its inputs before each step."""
    values, motion = settings(package, values, p)
    return probe(package, values, inputs=motion and motion.inputs(0.0)), motion and motion.drive


def exact(packages, name, times, cosines=A, sines=B, wide=False, inputs=False, digits=25, **changes):
    """State and count of impacts against the reference; relative to the stroke and the largest speed of the cam."""
    p = BASE | changes
    package = packages["backlash" + "_wide" * wide + "_input" * inputs]
    values, series = law(package, cosines, sines)
    unit, drive = started(package, values, p)
    with unit:
        reached, got = record(unit, times, (*NAMES, "impacts"), before=drive)

        def compute():
            machine = reference.Backlash(p, series, digits)
            rows = []
            for time in reached:
                events, state = machine.run(time)
                rows.append([*state, sum(kind == "impact" for _, kind, _ in events)])
            return rows

        expected = truth.stored(f"backlash, {name}", reached, compute)
        assert got[-1, 4] == expected[-1, 4], f"{got[-1, 4]} impacts instead of {expected[-1, 4]}"
        stroke = 2 * max(abs(x) for x in [*cosines, *sines])
        speed = max(abs(p["drive.w"]) * stroke, np.abs(expected[:, [1, 3]]).max())
        return unit.outcome(error(got[:, :4], expected[:, :4], [stroke, speed, stroke, speed]))


def declare(extreme, times, bound=1e-10, also_on_inputs=True, store=None, **options):
    """The case at constant speed, and on inputs that say the same."""

    @case(DRIVE, extreme, PHASES, bound)
    def run(packages):
        return exact(packages, store or extreme, times, **options)

    if also_on_inputs:

        @case(DRIVE, f"inputs: {extreme}", PHASES, bound)
        def run_on_inputs(packages):
            return exact(packages, store or extreme, times, inputs=True, **options)


def balances(packages, sizes, scene="backlash", **changes):
    """The largest error of both balances, relative to the largest momentum and to the energy exchanged."""
    p = BASE | changes
    package = packages[scene]
    values = {} if scene == "backlash_cycle" else law(package, A, B)[0]
    unit, drive = started(package, values, p)
    with unit:

        def state():
            v1, v2, q = unit.get("der(x1)", "der(y)", "q")
            return p["m1"] * v1 + p["m2"] * v2, (p["m1"] * v1 * v1 + p["m2"] * v2 * v2 + p["c"] * q * q) / 2

        momentum, energy = start = state()
        largest, exchanged, received, work = abs(momentum), energy, 0.0, 0.0
        for size in sizes:
            if drive:
                drive(unit)
            unit.step(size)
            force, torque, gap = unit.get("force_mean", "tau_mean", "gap")
            # The gap is a difference of places.
            assert -1e-15 <= gap <= p["s"] * (1 + 1e-12) + 1e-15, gap
            received, work = received + size * force, work + size * torque * p["drive.w"]
            momentum, energy = state()
            largest, exchanged = max(largest, abs(momentum)), max(exchanged, energy) + size * abs(torque * p["drive.w"])
        lost = sum(unit.get("energy_loss", "damping_loss"))
        assert unit.get("energy_loss") >= 0.0 and unit.get("damping_loss") >= 0.0
        errors = [abs(momentum - start[0] - received) / largest, abs(energy - start[1] - work + lost) / exchanged]
        return unit.outcome(max(errors))


def declare_balances(extreme, size, count, bound=1e-10, **options):
    @case(DRIVE, extreme, BALANCES, bound)
    def run(packages):
        return balances(packages, [size] * count, **options)


TURN = 2 * math.pi / 25.0

declare_balances("stiffness × 1e9", 1e-3, 30, m1=0.5, m2=2.0, c=5e14, **{"start.q": 0.0, "start.q_dot": 0.0})
declare("stiffness × 1e-9", [0.1, 0.25], c=1e-9 * BASE["c"])
declare("damping 0, restitution 0", [0.1, 0.25])
declare("damping critical", [0.1, 0.25], b=CRITICAL)
declare_balances("damping 1e6 × critical", 2e-3, 500, b=1e6 * CRITICAL)
declare_balances("mass ratio m1/m2 = 1e-9", 2e-3, 100, m1=1e-9 * BASE["m2"])
declare_balances("mass ratio m1/m2 = 1e-4", 2e-3, 500, m1=1e-4 * BASE["m2"])
declare("mass ratio m1/m2 = 1e9", [0.1, 0.25], m1=8e8, m2=0.8, c=2e5)
# Not much longer: until 0.6 s the impacts multiply a deviation of the start, and thus its rounding, by 2e6.
declare("clearance of one stroke", [0.1, 0.25, 0.4], s=2e-2)
declare("restitution 1 − 1e-9", [0.05, 0.1], e=1 - 1e-9)
declare("restitution 1", [0.05, 0.1], e=1.0)
declare_balances("restitution 1, 100 turns", TURN / 10, 1000, e=1.0)
declare_balances("restitution 1 − 1e-9, 100 turns", TURN / 10, 1000, e=1 - 1e-9)
declare("speed 0, free vibration", [0.01, 0.02], **{"drive.w": 0.0, "start.q": 1e-4})
# On inputs the rounding of the angle would be a jump larger than the motion.
declare("speed 1e-9 rad/s", [0.01, 0.05], also_on_inputs=False, **{"drive.w": 1e-9, "start.q": 0.0, "start.q_dot": 0.0})
declare("speed −25 rad/s", [0.1, 0.25], **{"drive.w": -25.0})
declare("speed 1e5 rad/s", [2e-5, 1e-4], **{"drive.w": 1e5})
declare_balances("speed 1e5 rad/s, 1000 turns", 2 * math.pi / 1e5, 1000, **{"drive.w": 1e5})
declare_balances("1e4 revolutions", TURN / 2, 20000)


@case(DRIVE, "1e6 revolutions", "a turn by exact phases, 25 digits, leads back to its beginning", 1e-10)
def many_turns(packages):
    """On a motion that attracts all others, with three switchings in each turn."""
    p = BASE | {"c": 2e5, "b": 0.06 * CRITICAL, "s": 2e-4}
    package = packages["backlash"]
    values, series = law(package, A, B)
    with probe(package, values | p | {"start.mode": 2}) as unit:
        for turns in range(1000, 1_000_001, 1000):
            unit.step_to(turns * TURN)
        (x1, v1, x2, v2), impacts = unit.get(*NAMES), unit.get("impacts")
        assert unit.get("gap") in (0.0, p["s"]), "the turn begins in contact"
        with mp.workdps(40):
            phase = float(mp.fmod(mp.mpf(p["drive.phi_start"]) + mp.mpf(p["drive.w"]) * mp.mpf(unit.time), 2 * mp.pi))
        begin = {"drive.phi_start": phase, "start.q": x2 - x1, "start.q_dot": v2 - v1}
        events, end = reference.Backlash(p | begin, series).run(TURN)
        assert impacts == 1e6 * sum(kind == "impact" for _, kind, _ in events)
        return unit.outcome(error([[x1, v1, x2, v2]], [end], [2e-2, 0.5, 2e-2, 0.5]))


# Dwells, in which mass 1 rests, and the jumps of the third derivative at their ends.
CYCLE = {"scene": "backlash_cycle", "drive.phi_start": 0.0, "start.q": 0.0, "start.q_dot": 0.0}
declare_balances("dwells", TURN / 50, 500, **CYCLE)
declare_balances("dwells, restitution 1 − 1e-9", TURN / 50, 500, e=1 - 1e-9, **CYCLE)
declare_balances("dwells, damping critical", TURN / 50, 500, b=CRITICAL, **CYCLE)
declare_balances("dwells, clearance of one stroke", TURN / 50, 500, s=0.1, **CYCLE)


@case(DRIVE, "communication steps 1e-12 … 1e3 s in one run, with impacts", BALANCES, 1e-10)
def mixed_balances(packages):
    return balances(packages, [1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6, 1e-9])


# Not at 25 rad/s, where harmonic 20 meets the undamped natural frequency.
declare("64 harmonics", [0.05, 0.15], wide=True, **{"drive.w": 24.7}, cosines=A + [1e-4 / k**3 for k in range(5, 65)], sines=B + [1e-4 / k**3 for k in range(6, 65)])
# 25 digits beyond those of the angle.
declare("phase start 1e12 rad", [0.1, 0.25], also_on_inputs=False, digits=38, **{"drive.phi_start": 1e12})
# In one step: from step to step the rounding of the angle, 1e-4 rad, would be a jump of the inputs.
declare("inputs: phase start 1e12 rad", [0.1], also_on_inputs=False, inputs=True, digits=38, **{"drive.phi_start": 1e12})
for scale in (1e-10, 1e5):
    declare(
        f"amplitude {1e-2 * scale:g} m", [0.1, 0.25], cosines=[scale * x for x in A], sines=[scale * x for x in B], s=scale * BASE["s"],
        **{"start.q": scale * BASE["start.q"], "start.q_dot": scale * BASE["start.q_dot"]},
    )


def as_elastic_output(packages, times, s, inputs=False, **changes):
    p = BASE | {"s": s, "start.q": 0.0, "start.q_dot": 0.0} | changes
    package = packages["backlash_input" if inputs else "backlash"]
    values, series = law(package, A, B)
    unit, drive = started(package, values, p)
    with unit:
        reached, got = record(unit, times, ("q",), before=drive)
        closed = lambda times: reference.elastic_output_closed(
            p["m2"], p["c"], p["b"], series, p["drive.w"], p["drive.phi_start"], 0.0, 0.0, times
        )[:, :1]
        scale = np.abs(closed(np.random.default_rng(1).uniform(0, reached[-1], 100))).max(axis=0)
        return unit.outcome(error(got, closed(reached), scale))


@case(DRIVE, "clearance 0", "closed form of the elastic output, 60 digits", 1e-11)
def no_clearance(packages):
    return as_elastic_output(packages, [0.1, 0.5, 2.0], 0.0, b=0.02 * CRITICAL)


@case(DRIVE, "clearance 1e-15 m", "limit s → 0, the elastic output; remainder m1 (U‴Ω³ s²)^⅓ of the momentum, 1e-6", 1e-5)
def tiny_clearance(packages):
    return as_elastic_output(packages, [0.1, 0.5, 2.0], 1e-15, b=0.02 * CRITICAL)


@case(DRIVE, "clearance 0, 1e3 revolutions", "closed form of the elastic output, 60 digits", 1e-9)
def million(packages):
    return as_elastic_output(packages, TURN * 1e3 * np.arange(1, 101) / 100, 0.0, b=0.02 * CRITICAL)


@case(DRIVE, "clearance 0, communication steps 1e-12 … 1e3 s in one run", "closed form of the elastic output, 60 digits", 1e-10)
def mixed(packages):
    return as_elastic_output(packages, np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6]), 0.0, b=0.02 * CRITICAL)


# The rounding of an angle of 2.5e4 rad, 4e-12 rad, is a jump of the inputs, by which mass 1 jumps beside mass 2.
@case(DRIVE, "inputs: clearance 0, communication steps 1e-12 … 1e3 s in one run", "closed form of the elastic output, 60 digits", 1e-8)
def mixed_on_inputs(packages):
    return as_elastic_output(packages, np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6]), 0.0, inputs=True, b=0.02 * CRITICAL)


@case(DRIVE, "inputs: communication steps 1e-12 … 1e3 s in one run, with impacts", BALANCES, 1e-8)
def mixed_balances_on_inputs(packages):
    return balances(packages, [1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6, 1e-9], scene="backlash_input")


declare("communication steps 1e-12 … 1e-1 s in one run", np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1e-1, 1e-3]), store="mixed steps")


@case(DRIVE, "inputs: reversal within a step of 1 s, clearance 0", "Dormand-Prince 8(5,3) at 1e-13", 1e-9)
def reversal(packages):
    motion, p = Moved(0.3, 25.0, -50.0), BASE | {"s": 0.0, "b": 0.02 * CRITICAL}
    package = packages["backlash_input"]
    values, series = law(package, A, B)
    values |= {k: v for k, v in p.items() if k in package.variables and not k.startswith("start")}
    with probe(package, values, inputs=motion.inputs(0.0)) as unit:
        reached, got = record(unit, [1.0], ("q", "der(q)"), before=motion.drive)
        rhs = reference.elastic_output(p["m2"], p["c"], p["b"], series, motion)
        states = reference.integrate(rhs, [0.0, 0.0], np.linspace(0.0, reached[0], 101))
        return unit.outcome(error(got, states[-1:], np.abs(states).max(axis=0)))


@case(DRIVE, "inputs: from rest through reversals to 1e3 rad/s", "momentum m1 ẋ1 + m2 ẏ, 0 ≤ gap ≤ s", 1e-10)
def swinging(packages):
    package = packages["backlash_input"]
    values, _ = law(package, A, B)
    # The rounding of the angle at the ends of the steps is that of the inputs.
    motion = Moved(0.3, 0.0, 2.0)
    with probe(package, values | {"m1": 2.0, "m2": 8.0, "c": 2e6, "s": 5e-5}, inputs=motion.inputs(0.0)) as unit:
        momentum = lambda: 2.0 * unit.get("der(x1)") + 8.0 * unit.get("der(y)")
        start, received, largest, pieces = momentum(), 0.0, 0.0, 0.0
        phi, w, step = 0.3, 0.0, 0.02
        for i in range(200):
            a = 50.0 * (-1.2) ** (i // 20)
            unit.set(phi=phi, w=w, a=a)
            unit.step(step)
            force, gap = unit.get("force_mean", "gap")
            assert -1e-15 <= gap <= 5e-5 * (1 + 1e-12) + 1e-15, gap
            received, pieces = received + step * force, pieces + abs(step * force)
            phi, w = phi + w * step + a * step * step / 2, w + a * step
            largest = max(largest, abs(momentum()))
        return unit.outcome(abs(momentum() - start - received) / (largest + pieces))


@refusal(DRIVE, "mass 0", "`m1`: 0 kg is not admissible", "the equation would have no acceleration")
def no_mass(packages):
    return refused(packages["backlash"], {"m1": 0.0})


@refusal(DRIVE, "clearance −1e-15 m", "`s`: -1e-15 m is not admissible", "flank B would lie before flank A")
def negative_clearance(packages):
    return refused(packages["backlash"], {"s": -1e-15})


@refusal(DRIVE, "restitution 1 + 1e-9", "`e`: 1.000000001 is not admissible", "an impact would bring energy")
def creating(packages):
    return refused(packages["backlash"], {"e": 1 + 1e-9})


@refusal(DRIVE, "inputs: acceleration 1e300 rad/s²", "`a`: 1e300 rad/s2 is not admissible", "the motion overflows")
def overflow(packages):
    return refused(packages["backlash_input"], run=lambda unit: (unit.set(a=1e300), unit.step(1.0)))
