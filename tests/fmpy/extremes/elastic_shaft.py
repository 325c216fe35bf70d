"""Elastic input shaft, nonlinear and linearised."""

import math

import mpmath as mp
import numpy as np

import reference
from extremes import suite, truth
from extremes.suite import FIXED_COST, Moved, case, error, probe, record, refusal, refused

DRIVE = "elastic shaft"
NAMES = ("q", "der(q)")
M, INERTIA, C, B, W = 20.0, 0.05, 2000.0, 0.6, 20.0
HARMONICS = [0.0, 0.06, 0.0, -0.011, 0.0, 0.0017]
DORMAND = "Dormand-Prince 8(5,3) at 2e-14"
FOURIER = "periodic motion by Fourier collocation"
# U′² at its largest for the law above, and J̄ = J + m · mean of U′².
SLOPE = max(reference.Series(HARMONICS).derivative(x, 1) ** 2 for x in np.linspace(0, math.pi, 2001))
MEAN = sum((k * a) ** 2 for k, a in enumerate(HARMONICS)) / 2


def settings(package, p, harmonics, sines, linear):
    length = 64 if "cam.a[64]" in package.variables else 5
    a = list(harmonics) + [0.0] * (length + 1 - len(harmonics))
    b = [0.0, *sines] + [0.0] * (length - len(sines))
    values = {f"cam.a[{k}]": v for k, v in enumerate(a)} | {f"cam.b[{k}]": v for k, v in enumerate(b) if k}
    values = {k: v for k, v in values.items() if k in package.variables} | {"shaft.linear": linear}
    return values | {k: v for k, v in p.items() if k in package.variables}, reference.Series(a, b)


def parameters(changes):
    return {"m": M, "J": INERTIA, "c": C, "b": B, "drive.w": W, "drive.phi_start": 0.3} | changes


def integrated(p, linear, reached, harmonics, series, start, scale, store):
    with mp.workdps(40):
        phi, w = float(mp.fmod(p["drive.phi_start"], 2 * mp.pi)), p["drive.w"]
    rhs = reference.elastic_shaft(p["m"], p["J"], p["c"], p["b"], series, lambda t: (phi + w * t, w, 0.0), linear)
    compute = lambda: truth.integrate(rhs, start or [0.0, 0.0], [0.0, *reached], scale or estimate(p, harmonics))
    if store:
        return truth.stored(f"shaft, linear={linear}, {store}", reached, compute)[1:]
    physical = {k: v for k, v in p.items() if not k.startswith("solver.")}
    key = "shaft", linear, *sorted(physical.items()), *series.a, *series.b, *(start or ()), *reached
    return truth.remembered(key, compute)[1:]


def against_integration(packages, linear, times, harmonics=HARMONICS, sines=(), wide=False, start=None, scale=None, store=None, **changes):
    p = parameters(changes)
    package = packages["shaft_wide" if wide else "shaft"]
    values, series = settings(package, p, harmonics, sines, linear)
    if start:
        values |= {"start.mode": 2, "start.q": start[0], "start.q_dot": start[1]}
    with probe(package, values) as unit:
        reached, got = record(unit, times, NAMES)
        return unit.outcome(error(got, integrated(p, linear, reached, harmonics, series, start, scale, store)))


def on_inputs(packages, linear, times, harmonics=HARMONICS, sines=(), wide=False, start=None, scale=None, store=None, **changes):
    """The end of the same run, reached by one step on inputs: from step to step the rounding of the angle would be a jump
    of the inputs, which is nothing to a twist of a milliradian only."""
    p = parameters(changes)
    package = packages["shaft_wide_input" if wide else "shaft_input"]
    values, series = settings(package, p, harmonics, sines, linear)
    if start:
        values |= {"start.mode": 2, "start.q": start[0], "start.q_dot": start[1]}
    motion = Moved(p["drive.phi_start"], p["drive.w"])
    with probe(package, values, inputs=motion.inputs(0.0)) as unit:
        _, got = record(unit, [times[-1]], NAMES, before=motion.drive)
        expected = integrated(p, linear, suite.reach(times), harmonics, series, start, scale, store)
        return unit.outcome(error(got, expected[-1:], np.abs(expected).max(axis=0)))


def estimate(p, harmonics):
    """The order of magnitude of q and der q."""
    slope = sum((k * abs(a)) ** 2 for k, a in enumerate(harmonics))
    rate = math.sqrt(p["c"] / (p["J"] + p["m"] * MEAN))
    q = min(p["m"] * p["drive.w"] ** 2 * slope / p["c"], 1.0) or 1.0
    return [q, q * rate]


def against_the_periodic_motion(packages, linear, turns, points=40, harmonics=HARMONICS, n=256, tolerance=None, **changes):
    p = parameters(changes)
    package = packages["shaft"]
    values, series = settings(package, p, harmonics, (), linear)
    periodic = truth.Periodic(p, series, linear, n)
    with probe(package, values | {"start.mode": 3}) as unit:
        names = (*NAMES, "phi")
        reached, got = record(unit, np.arange(1, points + 1) * 2 * math.pi * turns / points / abs(p["drive.w"]), names)
        expected = [periodic.at(math.remainder(p["drive.phi_start"] + p["drive.w"] * t, 2 * math.pi)) for t in reached]
        scale = np.abs([periodic.at(x) for x in np.linspace(0, 2 * math.pi, 200)]).max(axis=0)
        return unit.outcome(error(got[:, :2], expected, scale))


def both(extreme, text, bound, function, **options):
    """The case for the nonlinear and the linearised equation."""
    for linear in (False, True):
        kind = "linear" if linear else "nonlinear"

        @case(f"{DRIVE}, {kind}", extreme, text, bound)
        def run(packages, linear=linear):
            return function(packages, linear, **options)


def periods(count, c=C, j=INERTIA + M * MEAN, points=24):
    """Instants over `count` natural periods."""
    return np.arange(1, points + 1) * count * 2 * math.pi * math.sqrt(j / c) / points


def dwell(packages, linear, ratio):
    """Within the upper dwell only J moves, at 1/√ratio of the frequency with the mass."""
    package = packages["shaft_cycle"]
    # The inclined sine of 0.1 m over 120° has U′ = 2 · 0.1/(2π/3) at most; ten times the mass as J ends at 1e-12.
    mass, stiffness = 10 * M, 10 * C
    inertia = mass * (0.3 / math.pi) ** 2 * ratio
    rate = math.sqrt(stiffness / inertia)
    damping, start = 1e-4 * 2 * inertia * rate, (1e-3, 0.0)
    values = {"m": mass, "J": inertia, "c": stiffness, "b": damping, "drive.w": 1.0, "drive.phi_start": math.radians(155)}
    values |= {"shaft.linear": linear, "start.mode": 2, "start.q": start[0], "start.q_dot": start[1]}
    with probe(package, values) as unit:
        reached, got = record(unit, np.arange(1, 11) * min(200 / rate, math.radians(5)), NAMES)
        # The dwell ends at 210°, 55° from the start.
        assert max(reached) < math.radians(55)
        expected = truth.free_oscillation(inertia, damping, stiffness, *start, reached)
        return unit.outcome(error(got, expected, [start[0], start[0] * rate]))


def through_zero(packages, linear, ratio):
    """From rest 0.1 rad before U′ = 0 to 0.1 rad behind it; ten times the mass, as J ends at 1e-12 kg·m²."""
    p = parameters({"m": 10 * M, "c": 10 * C, "J": 10 * M * SLOPE * ratio, "b": 0.0, "drive.phi_start": -0.1})
    values, series = settings(packages["shaft"], p, HARMONICS, (), linear)
    zero = 0.1 / W
    with probe(packages["shaft"], values) as unit:
        reached, got = record(unit, zero * np.array([0.5, 0.9, 1.1, 1.5, 2.0]), NAMES)
        rhs = reference.elastic_shaft(p["m"], p["J"], p["c"], p["b"], series, lambda t: (W * t, W, 0.0), linear)
        compute = lambda: truth.integrate(rhs, [0.0, 0.0], [-zero, *(np.array(reached) - zero)], estimate(p, HARMONICS))
        expected = truth.stored(f"shaft, linear={linear}, through zero, {ratio:.0e}", reached, compute)
        return unit.outcome(error(got, expected[1:]))


def constant_inertia(packages, linear):
    package = packages["shaft"]
    values, _ = settings(package, parameters({"m": 0.0}), HARMONICS, (), linear)
    with probe(package, values | {"start.mode": 2, "start.q": 0.05, "start.q_dot": 1.0}) as unit:
        reached, got = record(unit, periods(10, j=INERTIA), NAMES)
        return unit.outcome(error(got, truth.free_oscillation(INERTIA, B, C, 0.05, 1.0, reached)))


def mixed_steps(packages, linear, inputs=False, longest=1e3, **solver):
    # A hundred times softer and ten times slower than the scene: 1e3 s are 318 turns.
    p = parameters({"b": 0.5, "c": C / 100, "drive.w": W / 10} | solver)
    package = packages["shaft_input" if inputs else "shaft"]
    values, series = settings(package, p, HARMONICS, (), linear)
    periodic = truth.Periodic(p, series, linear, 512)
    motion = Moved(0.3, W / 10)
    q, v = periodic.at(0.3)
    start = {"start.mode": 2, "start.q": q, "start.q_dot": v} if inputs else {"start.mode": 3}
    with probe(package, values | start, inputs=motion.inputs(0.0) if inputs else None) as unit:
        times = np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, longest, 1e-3, 1e-6, 1e-9])
        reached, got = record(unit, times, NAMES, before=motion.drive if inputs else None)
        expected = [periodic.at(math.remainder(0.3 + W / 10 * t, 2 * math.pi)) for t in reached]
        scale = np.abs([periodic.at(x) for x in np.linspace(0, 2 * math.pi, 200)]).max(axis=0)
        return unit.outcome(error(got, expected, scale))


CREEP = "force of the cam over the stiffness; remainder ω b/c, 1e-12"


def creeping(packages, linear, end=1e4, steps=20, **solver):
    """At 1e-9 rad/s nothing is left of the vibration of the start after some seconds: −c q = m ω² U′U″, and its rate; relative
    to them, not to the vibration, 1e10 times as fast."""
    w = 1e-9
    p = parameters({"drive.w": w} | solver)
    values, series = settings(packages["shaft"], p, HARMONICS, (), linear)
    with probe(packages["shaft"], values) as unit:
        reached, got = record(unit, np.linspace(0.0, end, steps + 1)[1:], NAMES)
        with mp.workdps(40):
            expected = []
            for t in reached[steps // 2:]:
                u1, u2, u3 = (series.derivative(mp.mpf(0.3) + w * mp.mpf(t), n, mp.sin, mp.cos) for n in (1, 2, 3))
                unit_force = -p["m"] * mp.mpf(w) ** 2 / p["c"]
                expected.append([float(unit_force * u1 * u2), float(unit_force * w * (u2 * u2 + u1 * u3))])
        return unit.outcome(error(got[steps // 2:], expected))


TURN = 2 * math.pi / W
STIFF = dict(c=1e9 * C)
CRITICAL = 2 * math.sqrt(C * (INERTIA + M * MEAN))

both("stiffness × 1e9, first vibrations", DORMAND, 1e-8, against_integration, times=periods(30, 1e9 * C), **STIFF)
both("stiffness × 1e9, three turns, damping critical", FOURIER, 1e-8, against_the_periodic_motion, turns=3, b=CRITICAL * math.sqrt(1e9), **STIFF)
both("stiffness × 1e-9", DORMAND, 1e-8, against_integration, times=np.arange(1, 21) * TURN / 10, c=1e-9 * C)
both("J3/(m U′²max) = 0.05, from rest", DORMAND, 1e-9, against_integration, times=np.arange(1, 13) * 0.01, harmonics=[0.0, 0.1], J=0.01)
both("damping 0", DORMAND, 1e-8, against_integration, times=np.arange(1, 21) * TURN / 10, b=0.0)
both("damping critical", DORMAND, 1e-8, against_integration, times=np.arange(1, 21) * TURN / 10, b=CRITICAL)
both("damping 1e6 × critical, first decay", DORMAND, 1e-8, against_integration, times=np.arange(1, 21) * 1e-8, b=1e6 * CRITICAL, scale=[1e-13, 1e-6], store="damping 1e6")
both("damping 1e6 × critical, three turns", FOURIER, 1e-8, against_the_periodic_motion, turns=3, b=1e6 * CRITICAL, n=128)
for exponent in (-4, -8, -12):
    both(
        f"J/(m U′²max) = 1e{exponent}, b = 0, through U′ = 0", "Dormand-Prince 8(5,3) at 2e-14, time from the zero of U′", 1e-7,
        through_zero, ratio=10.0**exponent,
    )
    both(f"J/(m U′²max) = 1e{exponent}, in a dwell", "damped oscillation, 60 digits", 1e-8, dwell, ratio=10.0**exponent)
both("J/(m U′²max) = 1e6, in a dwell", "damped oscillation, 60 digits", 1e-8, dwell, ratio=1e6)
both("J/(m U′²max) = 1e6", DORMAND, 1e-8, against_integration, J=M * SLOPE * 1e6, times=np.arange(1, 21) * TURN / 10)
both("mass 0", "damped oscillation, 60 digits", 1e-9, constant_inertia)
both("speed 0, free vibration", DORMAND, 1e-8, against_integration, start=(0.05, 1.0), scale=[0.05, 5.0], times=periods(10), **{"drive.w": 0.0})
both("speed 1e-9 rad/s", DORMAND, 1e-8, against_integration, times=periods(10), **{"drive.w": 1e-9})
both("speed 1e5 rad/s, two turns", DORMAND, 1e-8, against_integration, times=np.arange(1, 21) * 2 * math.pi / 1e6, **{"drive.w": 1e5})
both("speed −20 rad/s", DORMAND, 1e-8, against_integration, times=np.arange(1, 21) * TURN / 10, **{"drive.w": -W})
# The tolerance of the nonlinear shaft is relative to the vibration too, as long as that is remembered.
for linear, bound in ((False, 1e-3), (True, 1e-6)):

    @case(f"{DRIVE}, {'linear' if linear else 'nonlinear'}", "speed 1e-9 rad/s, 1e4 s; relative to the creep", CREEP, bound)
    def slow(packages, linear=linear):
        return creeping(packages, linear)


# The nonlinear shaft has no map of a turn: fifty steps in each, seventeen where the law has one harmonic.
for linear, turns, harmonics, extreme in (
    (False, 1e4, HARMONICS, "1e4 revolutions (1e6 take ten minutes of steps)"),
    (False, 3e4, [0.0, 0.06], "3e4 revolutions, one harmonic (1e6 take two minutes of steps)"),
    (True, 1e6, HARMONICS, "1e6 revolutions"),
):

    @case(f"{DRIVE}, {'linear' if linear else 'nonlinear'}", extreme, FOURIER, 1e-8)
    def many_turns(packages, linear=linear, turns=turns, harmonics=harmonics):
        return against_the_periodic_motion(packages, linear, turns=turns, points=20, harmonics=harmonics, b=CRITICAL / 5, J=5.0)


both(
    "communication steps 1e-12 … 1e3 s in one run", FOURIER, 1e-8,
    mixed_steps,
)
both(
    "64 harmonics", DORMAND, 1e-8, against_integration, wide=True, times=np.arange(1, 11) * TURN / 10, store="64 harmonics",
    harmonics=[0.0] + [5e-2 / k**2.5 for k in range(1, 65)], sines=[1e-3 / k**2 for k in range(1, 65)],
)
both("amplitude 1e-12 m", DORMAND, 1e-8, against_integration, harmonics=[h * 1e-11 for h in HARMONICS], times=np.arange(1, 21) * TURN / 10)
both(
    "amplitude 1e3 m (c grown likewise)", DORMAND, 1e-8, against_integration, harmonics=[h * 1e4 for h in HARMONICS],
    times=np.arange(1, 21) * TURN / 10, c=C * 1e8, b=B * 1e8, J=INERTIA * 1e8,
)
both(
    "phase start 1e12 rad", DORMAND, 1e-8, against_integration, times=np.arange(1, 21) * TURN / 10,
    **{"drive.phi_start": 1e12},
)


def moved(packages, linear, motion, stop, **changes):
    """One communication step on inputs of constant acceleration."""
    p = parameters(changes)
    values, series = settings(packages["shaft_input"], p, HARMONICS, (), linear)
    with probe(packages["shaft_input"], values, inputs=motion.inputs(0.0)) as unit:
        reached, got = record(unit, [stop], NAMES, before=motion.drive)
        rhs = reference.elastic_shaft(p["m"], p["J"], p["c"], p["b"], series, motion, linear)
        # An input shaft in uniform acceleration starts with q = 0 at rest relative to the drive.
        states = truth.integrate(rhs, [0.0, 0.0], np.linspace(0.0, reached[0], 101), estimate(p, HARMONICS))
        return unit.outcome(error(got, states[-1:], np.abs(states).max(axis=0)))


TENTHS = np.arange(1, 21) * TURN / 10
both("inputs: stiffness × 1e9, first vibrations", DORMAND, 1e-8, on_inputs, times=periods(30, 1e9 * C), **STIFF)
both("inputs: stiffness × 1e-9", DORMAND, 1e-8, on_inputs, times=TENTHS, c=1e-9 * C)
both("inputs: damping 0", DORMAND, 1e-8, on_inputs, times=TENTHS, b=0.0)
both("inputs: damping critical", DORMAND, 1e-8, on_inputs, times=TENTHS, b=CRITICAL)
both("inputs: damping 1e6 × critical, first decay", DORMAND, 1e-8, on_inputs, times=np.arange(1, 21) * 1e-8, b=1e6 * CRITICAL, scale=[1e-13, 1e-6], store="damping 1e6")
both("inputs: J/(m U′²max) = 1e6", DORMAND, 1e-8, on_inputs, J=M * SLOPE * 1e6, times=TENTHS)
both("inputs: speed 1e-9 rad/s", DORMAND, 1e-8, on_inputs, times=periods(10), **{"drive.w": 1e-9})
both("inputs: speed 1e5 rad/s, two turns", DORMAND, 1e-8, on_inputs, times=np.arange(1, 21) * 2 * math.pi / 1e6, **{"drive.w": 1e5})
both("inputs: amplitude 1e-12 m", DORMAND, 1e-8, on_inputs, harmonics=[h * 1e-11 for h in HARMONICS], times=TENTHS)
both("inputs: amplitude 1e3 m (c grown likewise)", DORMAND, 1e-8, on_inputs, harmonics=[h * 1e4 for h in HARMONICS], times=TENTHS, c=C * 1e8, b=B * 1e8, J=INERTIA * 1e8)
both("inputs: phase start 1e12 rad", DORMAND, 1e-8, on_inputs, times=TENTHS, **{"drive.phi_start": 1e12})
both(
    "inputs: 64 harmonics", DORMAND, 1e-8, on_inputs, wide=True, times=np.arange(1, 11) * TURN / 10, store="64 harmonics",
    harmonics=[0.0] + [5e-2 / k**2.5 for k in range(1, 65)], sines=[1e-3 / k**2 for k in range(1, 65)],
)
# The rounding of an angle of 2e3 rad, 2e-13 rad, is a jump of the inputs.
both("inputs: communication steps 1e-12 … 1e3 s in one run", FOURIER, 1e-8, mixed_steps, inputs=True)
both("inputs: reversal within a step of 1 s", DORMAND, 1e-8, moved, motion=Moved(0.3, 20.0, -40.0), stop=1.0)
both("inputs: speed 0 → 1e3 rad/s within one step of 0.5 s", DORMAND, 1e-7, moved, motion=Moved(0.3, 0.0, 2e3), stop=0.5, b=CRITICAL)
both("inputs: speed 0, acceleration 0", DORMAND, 0.0, moved, motion=Moved(0.3), stop=1.0)


@refusal(f"{DRIVE}, linear", "parametric instability until overflow", "the twist q grows without bound", "the solution grows without bound")
def unstable(packages):
    values, _ = settings(packages["shaft"], parameters({"b": 0.0, "drive.w": UNSTABLE}), HARMONICS, (), True)

    def run(unit):
        for _ in range(100):
            unit.step(10 * 2 * math.pi / UNSTABLE)
            unit.get(*NAMES)

    return refused(packages["shaft"], values, run)


@refusal(f"{DRIVE}, linear", "inputs: parametric instability until overflow", "the twist q grows without bound", "the solution grows without bound")
def unstable_on_inputs(packages):
    values, _ = settings(packages["shaft_input"], parameters({"b": 0.0}), HARMONICS, (), True)
    motion = Moved(0.3, UNSTABLE)

    def run(unit):
        for _ in range(100):
            motion.drive(unit)
            unit.step(10 * 2 * math.pi / UNSTABLE)
            unit.get(*NAMES)

    return refused(packages["shaft_input"], values, run, motion.inputs(0.0))


# In the middle of the range of instability above twice the mean natural frequency the motion grows by 2.3 a turn.
UNSTABLE = 2.3 * math.sqrt(C / (INERTIA + M * MEAN))


@case(f"{DRIVE}, linear", "parametric instability, growth by 1e20", DORMAND, 1e-8)
def growth(packages):
    return against_integration(
        packages, True, np.arange(1, 57) * 2 * math.pi / UNSTABLE, b=0.0, store="growth", **{"drive.w": UNSTABLE}
    )


@case(f"{DRIVE}, nonlinear", "where the linearised shaft is unstable", DORMAND, 1e-7)
def saturated(packages):
    return against_integration(
        packages, False, np.arange(1, 41) * 2 * math.pi / UNSTABLE / 4, b=0.0, store="unstable", **{"drive.w": UNSTABLE}
    )


def fixed(extreme, bound, times, text=DORMAND, function=against_integration, step=0.0, **options):
    """A nonlinear shaft with equal internal steps; their error is at most their estimate."""

    @case(f"{DRIVE}, nonlinear", f"fixed cost: {extreme}", text, bound)
    def run(packages):
        solver = {"solver.method": FIXED_COST, "solver.step_size": step}
        return function(packages, False, times, **options, **solver) if times is not None else function(packages, False, **options, **solver)


FEW = np.arange(1, 21) * TURN / 10
fixed("stiffness × 1e9, first vibrations", 1e-6, periods(30, 1e9 * C), **STIFF)
fixed("stiffness × 1e-9", 1e-6, FEW, c=1e-9 * C)
fixed("damping 0", 1e-6, FEW, b=0.0)
fixed("damping critical", 1e-6, FEW, b=CRITICAL)
fixed("J/(m U′²max) = 1e6", 1e-6, FEW, J=M * SLOPE * 1e6)
fixed("speed 1e5 rad/s, two turns", 1e-6, np.arange(1, 21) * 2 * math.pi / 1e6, **{"drive.w": 1e5})
fixed("speed 1e-9 rad/s", 1e-6, periods(10), **{"drive.w": 1e-9})
fixed("speed 1e-9 rad/s, 1e2 s; relative to the creep", 1e-2, None, CREEP, creeping, end=1e2)
fixed("64 harmonics", 1e-6, np.arange(1, 11) * TURN / 10, wide=True, store="64 harmonics", harmonics=[0.0] + [5e-2 / k**2.5 for k in range(1, 65)], sines=[1e-3 / k**2 for k in range(1, 65)])
# Equal internal steps for 1e3 s are more than the work of one call.
fixed("communication steps 1e-12 … 3e2 s in one run", 1e-6, None, FOURIER, mixed_steps, longest=3e2)
fixed("inputs, communication steps 1e-12 … 3e2 s in one run", 1e-6, None, FOURIER, mixed_steps, longest=3e2, inputs=True)
fixed("inputs, damping critical", 1e-6, FEW, function=on_inputs, b=CRITICAL)
fixed("inputs, speed 1e-9 rad/s", 1e-6, periods(10), function=on_inputs, **{"drive.w": 1e-9})
fixed("inputs, phase start 1e12 rad", 1e-6, FEW, function=on_inputs, **{"drive.phi_start": 1e12})
fixed("amplitude 1e-12 m", 1e-6, FEW, harmonics=[h * 1e-11 for h in HARMONICS])
fixed("phase start 1e12 rad", 1e-6, FEW, **{"drive.phi_start": 1e12})
fixed("internal steps of 1e-12 s", 1e-6, np.arange(1, 11) * 1e-8, step=1e-12)
fixed("internal steps twice as long as the default", 1e-1, FEW, step=0.005)
fixed("where the linearised shaft is unstable", 1e-4, np.arange(1, 41) * 2 * math.pi / UNSTABLE / 4, b=0.0, store="unstable, fixed", **{"drive.w": UNSTABLE})


@refusal(f"{DRIVE}, nonlinear", "fixed cost: internal steps of 1 s", "shorten solver.step_size, or set solver.method = adaptive", "the steps pass over the motion")
def coarse(packages):
    values = {"solver.method": FIXED_COST, "solver.step_size": 1.0}
    return refused(packages["shaft"], values, run=lambda unit: [unit.step(0.5) for _ in range(20)])


for damping in (0.0, B):
    @refusal(DRIVE, f"J = 0, b = {damping:g}", "`J`: 0 kg.m2 is not admissible", "algebraic or unbounded where U′ = 0")
    def no_inertia(packages, damping=damping):
        return refused(packages["shaft"], {"J": 0.0, "b": damping})


@refusal(DRIVE, "inputs: acceleration 1e300 rad/s²", "`a`: 1e300 rad/s2 is not admissible", "the motion overflows")
def overflow(packages):
    return refused(packages["shaft_input"], run=lambda unit: (unit.set(a=1e300), unit.step(1.0)))
