"""Elastic output: a closed form exists for every constant speed, so each extreme has an exact truth."""

import math

import mpmath as mp
import numpy as np

import reference
from extremes import truth
from extremes.suite import Moved, case, error, probe, record, refusal, refused

DRIVE = "elastic output"
CLOSED = "closed form, 60 digits"
NAMES = ("q", "der(q)")
M, C = 2.0, 1.3e5
CRITICAL = 2 * math.sqrt(M * C)
HARMONICS = [0.0, 6e-3, 0.0, -1e-3, 0.0, 2e-4]


def law(harmonics, sines=(), length=5):
    """The coefficients as parameters of an FMU."""
    a = list(harmonics) + [0.0] * (length + 1 - len(harmonics))
    b = [0.0, *sines] + [0.0] * (length - len(sines))
    values = {f"cam.a[{k}]": v for k, v in enumerate(a)}
    return values | {f"cam.b[{k}]": v for k, v in enumerate(b) if k > 0}, reference.Series(a, b)


def closed(p, series, times, q0=0.0, v0=0.0):
    return reference.elastic_output_closed(
        p["m"], p["c"], p["b"], series, p["drive.w"], p["drive.phi_start"], q0, v0, times
    )


def against_the_closed_form(packages, times, harmonics=HARMONICS, sines=(), wide=False, start=(0.0, 0.0), **changes):
    p = {"m": M, "c": C, "b": 0.02 * CRITICAL, "drive.w": 50.0, "drive.phi_start": 0.3} | changes
    package = packages["output_wide" if wide else "output"]
    values, series = law(harmonics, sines, 64 if wide else 5)
    values = {k: v for k, v in values.items() if k in package.variables} | p
    if start != (0.0, 0.0):
        values |= {"start.mode": 2, "start.q": start[0], "start.q_dot": start[1]}
    with probe(package, values) as unit:
        reached, got = record(unit, times, NAMES)
        scale = np.abs(closed(p, series, scale_times(p, reached[-1]), *start)).max(axis=0)
        return unit.outcome(error(got, closed(p, series, reached, *start), scale))


def scale_times(p, stop):
    """Irregular instants over the whole run, the early ones in close order, where the largest values may be."""
    spread = np.random.default_rng(1).uniform(0.0, 1.0, 100)
    return np.concatenate([stop * spread, stop * 10.0 ** (-18 * spread)])


def turns(w, count, points=20):
    return [2 * math.pi / abs(w) * count * (i + 1) / points for i in range(points)]


def declare(extreme, bound=1e-12, times=None, **options):
    @case(DRIVE, extreme, CLOSED, bound)
    def run(packages):
        return against_the_closed_form(packages, turns(50.0, 3) if times is None else times, **options)


declare("stiffness × 1e9", c=C * 1e9)
declare("stiffness × 1e-9", c=C * 1e-9)
declare("stiffness 0, damping 0", c=0.0, b=0.0)
declare("mass 1e-12 kg", m=1e-12)
declare("mass 1e12 kg", m=1e12)
declare("damping 0", b=0.0)
declare("damping critical", b=CRITICAL)
declare("damping 1e6 × critical", b=1e6 * CRITICAL)
declare("damping 1e6 × critical, stiffness × 1e9", c=1e9 * C, b=1e6 * CRITICAL * math.sqrt(1e9))
declare("speed 0, free vibration", bound=1e-12, start=(1e-3, 0.2), **{"drive.w": 0.0})
declare("speed 1e-9 rad/s", **{"drive.w": 1e-9})
declare("speed 1e5 rad/s", times=turns(1e5, 3), **{"drive.w": 1e5})
declare("speed −1e5 rad/s over 1 s", times=[0.1, 1.0], **{"drive.w": -1e5})
declare("1e6 revolutions", times=turns(50.0, 1e6, 7), b=0.0)
declare(
    "1e6 revolutions in resonance, damping 0", times=turns(50.0, 1e6, 7), b=0.0, c=M * 250.0**2,
)
declare(
    "communication steps 1e-12 … 1e3 s in one run",
    times=np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6, 1e-9]),
)
declare(
    "64 harmonics", wide=True, harmonics=[0.0] + [1e-2 / k**2 for k in range(1, 65)], sines=[1e-3 / k for k in range(1, 65)],
)
declare("amplitude 1e-12 m", harmonics=[h * 1e-10 for h in HARMONICS])
declare("amplitude 1e3 m", harmonics=[h * 1e5 for h in HARMONICS])
declare("phase start 1e12 rad", **{"drive.phi_start": 1e12})


def moved(packages, motion, times, expected, harmonics=HARMONICS, sines=(), wide=False, **changes):
    p = {"m": M, "c": C, "b": 0.02 * CRITICAL} | changes
    values, series = law(harmonics, sines, 64 if wide else 5)
    package = packages["output_wide_input" if wide else "output_input"]
    values = {k: v for k, v in values.items() if k in package.variables} | p
    with probe(package, values, inputs=motion.inputs(0.0)) as unit:
        reached, got = record(unit, times, NAMES, before=motion.drive)
        wanted, scale = expected(p, series, reached)
        return unit.outcome(error(got, wanted, scale))


def uniform(w, phi):
    def expected(p, series, times):
        p = p | {"drive.w": w, "drive.phi_start": phi}
        return closed(p, series, times), np.abs(closed(p, series, scale_times(p, times[-1]))).max(axis=0)

    return expected


def declare_moved(extreme, w=50.0, phi=0.3, times=None, bound=1e-11, **changes):
    @case(DRIVE, f"inputs: {extreme}", CLOSED, bound)
    def run(packages):
        instants = turns(50.0, 3) if times is None else times
        return moved(packages, Moved(phi, w), instants, uniform(w, phi), **changes)


declare_moved("stiffness × 1e9", c=C * 1e9)
declare_moved("stiffness × 1e-9", c=C * 1e-9)
declare_moved("damping 0", b=0.0)
declare_moved("damping critical", b=CRITICAL)
declare_moved("damping 1e6 × critical", b=CRITICAL * 1e6)
# In one step: q is so small that the rounding of the angle from step to step would be a large jump of the inputs.
declare_moved("speed 1e-9 rad/s", w=1e-9, times=[0.1])
declare_moved("speed 1e5 rad/s", w=1e5, times=turns(1e5, 3))
declare_moved("64 harmonics", wide=True, harmonics=[0.0] + [1e-2 / k**2 for k in range(1, 65)], sines=[1e-3 / k for k in range(1, 65)])
declare_moved("amplitude 1e-12 m", harmonics=[h * 1e-10 for h in HARMONICS])
declare_moved("amplitude 1e3 m", harmonics=[h * 1e5 for h in HARMONICS])
# The rounding of an angle of 1e5 rad, 1e-11 rad, is a jump of the inputs.
declare_moved("communication steps 1e-12 … 1e3 s in one run", bound=1e-9, times=np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3]))
# One step: from step to step the rounding of the angle, 1e-4 rad, would be a jump of the inputs.
declare_moved("phase start 1e12 rad", phi=1e12, times=[0.1])


@case(DRIVE, "inputs: reversal within a step of 1 s", "Dormand-Prince 8(5,3) at 1e-13", 1e-10)
def reversal(packages):
    motion = Moved(0.3, 30.0, -60.0)

    def expected(p, series, times):
        rhs = reference.elastic_output(p["m"], p["c"], p["b"], series, motion)
        states = reference.integrate(rhs, [0.0, 0.0], np.linspace(0.0, 1.0, 41))
        return states[-1:], np.abs(states).max(axis=0)

    return moved(packages, motion, [1.0], expected)


@case(DRIVE, "inputs: speed 0 → 1e5 rad/s within one step of 1 s", "closed form of a chirp, 30 digits", 1e-9)
def chirp(packages):
    """One harmonic, no damping: q = -Im[e^(iwt) ∫ e^(-iws) x''(s) ds]/w, by mpmath's quadrature of the Fresnel type."""
    motion = Moved(0.0, 0.0, 2e3)
    stop = 0.5

    def expected(p, series, times):
        with mp.workdps(25):
            w0 = mp.sqrt(mp.mpf(p["c"]) / p["m"])
            alpha = mp.mpf(2e3)

            def integrals(k, a):
                # After integration by parts twice, ∫ sin(w0 (T-s)) cos(k φ(s)) ds is what remains.
                total = mp.mpc(0)
                for sign in (1, -1):
                    # ∫ exp(i (sign k α s²/2 - w0 s)) ds by completing the square.
                    g = sign * k * alpha / 2
                    root = mp.sqrt(mp.mpc(0, -1) * g)
                    shift = w0 / (2 * g)
                    factor = mp.expj(-g * shift**2) * mp.sqrt(mp.pi) / (2 * root)
                    total += factor * (mp.erf(root * (stop - shift)) - mp.erf(root * (-shift)))
                return a * total / 2

            total = sum(integrals(k, mp.mpf(a)) for k, a in enumerate(series.a) if k and a)
            t = mp.mpf(stop)
            u = [sum(mp.mpf(a) * f(k) for k, a in enumerate(series.a) if k) for f in (
                lambda k: mp.cos(k * alpha * t * t / 2),
                lambda k: -k * alpha * t * mp.sin(k * alpha * t * t / 2),
                lambda k: mp.mpf(1))]
            # y'' + w0² y = w0² x from y(0) = x(0), y'(0) = 0.
            rotation = mp.expj(w0 * t)
            y = u[2] * mp.cos(w0 * t) + w0 * mp.im(rotation * total)
            v = -u[2] * w0 * mp.sin(w0 * t) + w0**2 * mp.re(rotation * total)
            q = [[float(y - u[0]), float(v - u[1])]]
        return q, np.array([abs(series.a[1]), abs(series.a[1]) * 1e3])

    return moved(packages, motion, [stop], expected, b=0.0)


# Within the upper dwell of the cycle, from 150° to 210°, q vibrates freely.
def declare_dwell(extreme, **changes):
    @case(DRIVE, f"in a dwell: {extreme}", "damped oscillation, 60 digits", 1e-12)
    def run(packages):
        p = {"m": M, "c": C, "b": 0.02 * CRITICAL} | changes
        start = (1e-3, 0.2)
        values = p | {"drive.w": 1.0, "drive.phi_start": math.radians(155), "start.mode": 2}
        values |= {"start.q": start[0], "start.q_dot": start[1]}
        with probe(packages["output_cycle"], values) as unit:
            reached, got = record(unit, np.arange(1, 17) * 0.05, NAMES)
            expected = truth.free_oscillation(p["m"], p["b"], p["c"], *start, reached)
            scale = [start[0] + start[1] / math.sqrt(p["c"] / p["m"]), start[1] + start[0] * math.sqrt(p["c"] / p["m"])]
            return unit.outcome(error(got, expected, scale))


declare_dwell("damping 0", b=0.0)
declare_dwell("damping critical", b=CRITICAL)
declare_dwell("stiffness × 1e9, damping 0", c=1e9 * C, b=0.0)
declare_dwell("damping 1e6 × critical", b=1e6 * CRITICAL)


@refusal(DRIVE, "steady state in resonance, damping 0", "harmonic 5 of the cam meets the undamped natural frequency", "no periodic motion exists")
def resonance(packages):
    values, _ = law(HARMONICS)
    values = {k: v for k, v in values.items() if k in packages["output"].variables}
    return refused(packages["output"], values | {"m": M, "c": M * 250.0**2, "b": 0.0, "drive.w": 50.0, "start.mode": 3})


@refusal(DRIVE, "mass 0", "`m`: 0 kg is not admissible", "the equation would have no acceleration")
def no_mass(packages):
    return refused(packages["output"], {"m": 0.0})


@refusal(DRIVE, "inputs: acceleration 1e300 rad/s²", "`a`: 1e300 rad/s2 is not admissible", "the motion overflows")
def overflow(packages):
    return refused(packages["output_input"], run=lambda unit: (unit.set(a=1e300), unit.step(1.0)))
