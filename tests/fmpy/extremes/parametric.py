"""Parametric drive: series and parallel crank."""

import math

import mpmath as mp
import numpy as np

import reference
from extremes import truth
from extremes.suite import FIXED_COST, Moved, case, error, probe, reach, record, refusal, refused

DRIVE = "parametric drive"
NAMES = ("q", "der(q)")
DORMAND = "Dormand-Prince 8(5,3) at 2e-14"
# The scenes that turn by inputs.
ON_INPUTS = {"parametric": "parametric_input", "parametric_wide": "parametric_wide_input", "crank": "crank_loaded_input"}
START = {"start.mode": 2, "start.q": 0.1, "start.q_dot": 0.02}


def so_far(got, expected):
    """The largest deviation relative to the largest motion so far."""
    scale = np.maximum.accumulate(np.abs(expected), axis=0)
    return error(got[:, :] / scale, expected / scale, [1.0, 1.0])


def integrated(package, reached, values, scale):
    """The states of the drive at constant speed."""
    law = reference.Parametric(package, values)
    p = law.p
    with mp.workdps(40):
        phi = float(mp.fmod(p["drive.phi_start"], 2 * mp.pi))
    w = p["drive.w"]
    rhs = law.rhs(lambda t: (phi + w * t, w, 0.0))
    m, _, c, _ = law.at(1.0)
    first = [p["start.q"], p["start.q_dot"]]
    scale = scale or [abs(first[0]), abs(first[0]) * math.sqrt(abs(c) / m)]
    compute = lambda: truth.integrate(rhs, first, [0.0, *reached], scale)
    physical = {k: v for k, v in values.items() if not k.startswith("solver.")}
    return truth.remembered((*sorted(package.parameters().items()), *sorted(physical.items()), *reached), compute)[1:]


def against_integration(packages, name, times, start=START, scale=None, **changes):
    package, values = packages[name], dict(start) | changes
    with probe(package, values) as unit:
        reached, got = record(unit, times, NAMES)
        return unit.outcome(so_far(got, integrated(package, reached, values, scale)))


def on_inputs(packages, name, times, start=START, scale=None, **changes):
    """The end of the same run, reached by one step on inputs."""
    package, values = packages[ON_INPUTS[name]], dict(start) | changes
    p = packages[name].parameters() | values
    motion = Moved(p["drive.phi_start"], p["drive.w"])
    with probe(package, {k: v for k, v in values.items() if k in package.variables}, inputs=motion.inputs(0.0)) as unit:
        _, got = record(unit, [times[-1]], NAMES, before=motion.drive)
        expected = integrated(packages[name], reach(times), values, scale)
        return unit.outcome(error(got, expected[-1:], np.abs(expected).max(axis=0)))


def turns(count, w, points=40):
    return np.arange(1, points + 1) * count * 2 * math.pi / points / abs(w)


def sampled(extreme, name, bound=1e-9, also=("inputs",), **options):
    """The case at constant speed, on inputs that say the same and, with `also`, on these at fixed cost."""

    @case(DRIVE, extreme, DORMAND, bound)
    def run(packages):
        return against_integration(packages, name, **options)

    if "inputs" in also:

        @case(DRIVE, f"inputs: {extreme}", DORMAND, bound)
        def run_on_inputs(packages):
            return on_inputs(packages, name, **options)

    if "fixed cost" in also:

        @case(DRIVE, f"fixed cost, inputs: {extreme}", DORMAND, 1e-6)
        def run_at_fixed_cost(packages):
            return on_inputs(packages, name, **options, **{"solver.method": FIXED_COST})


W, CRANK = 5.0, 0.7
sampled("stiffness × 1e9, first vibrations", "parametric", also=("inputs", "fixed cost"), times=np.arange(1, 41) * 1e-5, **{f"c.{k}": v * 1e9 for k, v in {"a[0]": 40.0, "a[1]": 5.0, "a[3]": 8.0, "b[1]": -6.0}.items()})
sampled("stiffness × 1e-9", "parametric", times=turns(3, W), **{f"c.{k}": v * 1e-9 for k, v in {"a[0]": 40.0, "a[1]": 5.0, "a[3]": 8.0, "b[1]": -6.0}.items()})
sampled("stiffness below 0 all around", "parametric", times=turns(3, W), **{"c.a[0]": -40.0})
sampled("damping 0", "parametric", also=("inputs", "fixed cost"), times=turns(10, W), **{f"b.{k}": 0.0 for k in ("a[0]", "a[1]", "b[2]")})
sampled("damping critical", "parametric", also=("inputs", "fixed cost"), times=turns(3, W), **{"b.a[0]": 2 * math.sqrt(2.0 * 40.0)})
sampled("damping 1e6 × critical, first decay", "parametric", times=np.arange(1, 21) * 2.5e-8, scale=[1e-8, 0.02], **{"b.a[0]": 2e7, "start.q": 0.0})
sampled("damping below 0, growth by 1e40", "parametric", times=turns(40, W), **{"b.a[0]": -8.0})
sampled("mass 1e12 kg·m² (c, b, f grown likewise)", "parametric", times=turns(10, W), **{k: v * 5e11 for k, v in {
    "m.a[0]": 2.0, "m.a[1]": 0.3, "m.a[2]": -0.4, "m.b[1]": 0.2, "b.a[0]": 0.3, "b.a[1]": 0.05, "b.b[2]": -0.1, "c.a[0]": 40.0, "c.a[1]": 5.0,
    "c.a[3]": 8.0, "c.b[1]": -6.0, "f.a[0]": 1.0, "f.a[2]": 3.0, "f.b[1]": 2.0}.items()})
for part in (1e-3, 1e-9):
    light = {"m.a[0]": 2.0, "m.a[1]": -2.0 * (1 - part), "m.a[2]": 0.0, "m.b[1]": 0.0}
    sampled(f"mass falls to {part:.0e} of its mean".replace("e-0", "e-"), "parametric", bound=1e-8, times=turns(1, W), **light)
sampled("speed 0", "parametric", times=np.arange(1, 41) * 0.3, **{"drive.w": 0.0})
sampled("speed 1e-9 rad/s", "parametric", also=("inputs", "fixed cost"), times=np.arange(1, 41) * 0.3, **{"drive.w": 1e-9})
sampled("speed 1e5 rad/s, ten turns", "parametric", also=("inputs", "fixed cost"), times=turns(10, 1e5), **{"drive.w": 1e5})
sampled("speed −5 rad/s", "parametric", times=turns(10, W), **{"drive.w": -W})
sampled("amplitude 1e-12 rad", "parametric", times=turns(10, W), **{"start.q": 1e-12, "start.q_dot": 2e-13, "f.a[0]": 1e-11, "f.a[2]": 3e-11, "f.b[1]": 2e-11})
sampled("amplitude 1e3 rad", "parametric", times=turns(10, W), **{"start.q": 1e3, "start.q_dot": 2e2, "f.a[0]": 1e4, "f.a[2]": 3e4, "f.b[1]": 2e4})
sampled("phase start 1e12 rad", "parametric", also=("inputs", "fixed cost"), times=turns(10, W), **{"drive.phi_start": 1e12})
sampled("64 harmonics", "parametric_wide", also=("inputs", "fixed cost"), times=turns(3, 3.0))
sampled("parametric instability, growth by 1e30", "parametric", bound=1e-9, times=turns(120, 8.9, points=60), **{"drive.w": 8.9, "b.a[0]": 0.0, "c.a[1]": 30.0})
sampled("crank, stiffness × 1e9, first vibrations", "crank", times=np.arange(1, 41) * 1e-5, **{"c_T1": 2e9, "c_T2": 2e9, "c_AB": 1e10})
sampled("crank, stiffness × 1e-9", "crank", times=turns(3, CRANK), **{"c_T1": 2e-9, "c_T2": 2e-9, "c_AB": 1e-8})
sampled("crank, damping critical", "crank", times=turns(3, CRANK), b_T=2.0)
sampled("crank, damping 1e6 × critical, first decay", "crank", times=np.arange(1, 21) * 2.5e-7, scale=[1e-8, 0.02], **{"b_T": 2e6, "start.q": 0.0})
for exponent in (4, 0, -4, -8):
    sampled(f"crank, σ = 1e{exponent}".replace("1e0", "1"), "crank", times=turns(10, CRANK), **{"c_AB": 10.0 ** -exponent})


@case(DRIVE, "crank, σ = 1e-12: rods all but rigid", "constant stiffness with a kick π √σ c q/(J ω) at each dead centre; remainder σ", 1e-9)
def rigid_rods(packages):
    values = START | {"c_AB": 1e12, "b_T": 0.0, "f.a[0]": 0.0, "f.a[1]": 0.0}
    kick = math.pi * 1e-6 / CRANK

    def exact(t):
        # J = c = 1; the run starts at a dead centre, in the middle of its kick.
        q, v, at = START["start.q"], START["start.q_dot"] + 0.5 * kick * START["start.q"], 0.0
        while at < t:
            step = min(math.pi / CRANK, t - at)
            q, v = q * math.cos(step) + v * math.sin(step), v * math.cos(step) - q * math.sin(step)
            at += step
            if step == math.pi / CRANK:
                v += kick * q
        return q, v

    with probe(packages["crank"], values) as unit:
        reached, got = record(unit, turns(3.01, CRANK, points=37), NAMES)
        return unit.outcome(error(got, [exact(t) for t in reached]))


@case(DRIVE, "damping 1e6 × critical, three turns", "b q̇ + c q = −m q̈ in closed form; remainder (m ω/b)², 1e-12", 1e-10)
def overdamped(packages):
    values = {"b.a[0]": 2e7, "b.a[1]": 0.0, "b.b[2]": 0.0, "f.a[0]": 0.0, "f.a[2]": 0.0, "f.b[1]": 0.0}
    stiffness = reference.Parametric(packages["parametric"]).at
    integral = lambda t: 40 * t + (5 * math.sin(W * t) + 8 / 3 * math.sin(3 * W * t) + 6 * (math.cos(W * t) - 1)) / W
    with probe(packages["parametric"], values | {"start.mode": 2, "start.q": 0.1, "start.q_dot": 0.0}) as unit:
        reached, got = record(unit, turns(3, W), NAMES)
        q = [0.1 * math.exp(-integral(t) / 2e7) for t in reached]
        slope = lambda x: -5 * math.sin(x) - 24 * math.sin(3 * x) - 6 * math.cos(x)
        # q̈ = −c′ ω q/b.
        rates = [-(stiffness(W * t)[2] - stiffness(W * t)[0] * slope(W * t) * W / 2e7) / 2e7 * x for t, x in zip(reached, q)]
        return unit.outcome(error(got, np.array([q, rates]).T))


def disguised(e, w, w0, times):
    """q = p z, p = 1 + e cos φ, z = cos ω₀t: a closed form of an equation in which everything varies."""
    square = [1 + e * e / 2, 2 * e, e * e / 2]
    values = {"m.a[0]": square[0], "m.a[1]": square[1], "m.a[2]": square[2], "m.b[1]": 0.0}
    values |= {"b.a[0]": 0.0, "b.a[1]": 0.0, "b.b[1]": 2 * w * e, "b.b[2]": w * e * e}
    values |= {"c.a[0]": w0 * w0 * square[0] + 1.5 * (w * e) ** 2, "c.a[1]": w0 * w0 * square[1] + w * w * e}
    values |= {"c.a[2]": w0 * w0 * square[2] - 0.5 * (w * e) ** 2, "c.a[3]": 0.0, "c.b[1]": 0.0}
    values |= {"f.a[0]": 0.0, "f.a[2]": 0.0, "f.b[1]": 0.0, "drive.w": w, "drive.phi_start": 0.0}
    values |= {"start.mode": 2, "start.q": 1.0, "start.q_dot": 0.0}

    def exact(t):
        with mp.workdps(40):
            t, w_, w0_ = mp.mpf(t), mp.mpf(w), mp.mpf(w0)
            p, rate = 1 + e * mp.cos(w_ * t), -e * w_ * mp.sin(w_ * t)
            z, speed = mp.cos(w0_ * t) / (1 + e), -w0_ * mp.sin(w0_ * t) / (1 + e)
            return float(p * z), float(rate * z + p * speed)

    return values, [exact(t) for t in times]


@case(DRIVE, "a harmonic oscillation in disguise, 100 turns", "closed form, 40 digits", 1e-10)
def hundred_turns(packages):
    values, _ = disguised(0.5, 1.7, 3.0, [])
    with probe(packages["parametric"], values) as unit:
        reached, got = record(unit, turns(100, 1.7), NAMES)
        return unit.outcome(error(got, disguised(0.5, 1.7, 3.0, reached)[1]))


@case(DRIVE, "the same after 1e6 turns", "closed form, 40 digits", 1e-8)
def million_turns(packages):
    values, _ = disguised(0.5, 1.7, 3.0, [])
    with probe(packages["parametric"], values) as unit:
        reached, got = record(unit, turns(1e6, 1.7, points=20), NAMES)
        _, expected = disguised(0.5, 1.7, 3.0, reached)
        return unit.outcome(error(got, expected, [1.0, 3.0]))


def mixed_steps(packages, inputs=False, **solver):
    values, _ = disguised(0.5, 1.7, 3.0, [])
    package = packages["parametric_input" if inputs else "parametric"]
    values = {k: v for k, v in (values | solver).items() if k in package.variables}
    motion = Moved(0.0, 1.7)
    with probe(package, values, inputs=motion.inputs(0.0) if inputs else None) as unit:
        times = np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6, 1e-9])
        reached, got = record(unit, times, NAMES, before=motion.drive if inputs else None)
        return unit.outcome(error(got, disguised(0.5, 1.7, 3.0, reached)[1], [1.0, 3.0]))


@case(DRIVE, "communication steps 1e-12 … 1e3 s in one run", "closed form, 40 digits", 1e-10)
def mixed_at_constant_speed(packages):
    return mixed_steps(packages)


@case(DRIVE, "inputs: communication steps 1e-12 … 1e3 s in one run", "closed form, 40 digits", 1e-9)
def mixed_on_inputs(packages):
    return mixed_steps(packages, inputs=True)


@case(DRIVE, "fixed cost, inputs: communication steps 1e-12 … 1e3 s in one run", "closed form, 40 digits", 1e-6)
def mixed_at_fixed_cost(packages):
    return mixed_steps(packages, inputs=True, **{"solver.method": FIXED_COST})


def moved(packages, motion, stop, **changes):
    """One communication step on inputs of constant acceleration."""
    package = packages["crank_input"]
    law = reference.Parametric(package, changes)
    with probe(package, changes, inputs=motion.inputs(0.0)) as unit:
        reached, got = record(unit, [stop], NAMES, before=motion.drive)
        states = truth.integrate(law.rhs(motion), [0.0, 0.0], np.linspace(0.0, reached[0], 201), [1.0, 1.0])
        return unit.outcome(error(got, states[-1:], np.abs(states).max(axis=0)))


@case(DRIVE, "inputs: reversal within a step of 10 s", DORMAND, 1e-9)
def reversal(packages):
    return moved(packages, Moved(0.3, 5.0, -1.0), 10.0)


@case(DRIVE, "inputs: speed 0 → 100 rad/s within one step of 1 s", DORMAND, 1e-9)
def ramp(packages):
    return moved(packages, Moved(0.3, 0.0, 100.0), 1.0)


@case(DRIVE, "inputs: speed 0, acceleration 0", DORMAND, 0.0)
def standing(packages):
    return moved(packages, Moved(0.3), 1.0)


@refusal(DRIVE, "parametric instability until overflow", "q grows without bound", "the solution grows without bound")
def unstable(packages):
    def run(unit):
        for _ in range(100):
            unit.step(100.0)
            unit.get(*NAMES)

    return refused(packages["parametric"], START | {"drive.w": 8.9}, run)


@refusal(DRIVE, "inputs: parametric instability until overflow", "q grows without bound", "the solution grows without bound")
def unstable_on_inputs(packages):
    motion = Moved(0.0, 8.9)

    def run(unit):
        for _ in range(100):
            motion.drive(unit)
            unit.step(100.0)
            unit.get(*NAMES)

    return refused(packages["parametric_input"], START, run, motion.inputs(0.0))


@refusal(DRIVE, "mass 0 at one angle", "`m`: m(φ) is 0 kg·m² at φ = 0 rad", "the equation would have no acceleration")
def massless(packages):
    return refused(packages["parametric"], {"m.a[0]": 2.0, "m.a[1]": -2.0, "m.a[2]": 0.0, "m.b[1]": 0.0})


@refusal(DRIVE, "crank without rod", "`c_AB`: 0 N/m is not admissible", "the drive would transmit nothing")
def rodless(packages):
    return refused(packages["crank"], {"c_AB": 0.0})


@refusal(DRIVE, "steady state in a tongue", "the periodic solution is unstable", "a periodic motion that all others leave")
def in_a_tongue(packages):
    return refused(packages["parametric"], {"drive.w": 8.9, "start.mode": 3})


@refusal(DRIVE, "inputs: acceleration 1e300 rad/s²", "`a`: 1e300 rad/s2 is not admissible", "the motion overflows")
def overflow(packages):
    return refused(packages["crank_input"], run=lambda unit: (unit.set(a=1e300), unit.step(1.0)))
