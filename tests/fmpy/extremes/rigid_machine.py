"""Rigid machine. Without a motor ½Jφ̇² is constant and the time to an angle a quadrature (an elliptic integral for one
harmonic); with constant J the run-up on Kloss' characteristic is Lambert's function."""

import math

import mpmath as mp
import numpy as np

import reference
from extremes.suite import FIXED_COST, case, probe, record, refusal, refused

DRIVE = "rigid machine"
NAMES = ("phi", "w", "J", "E")
J0, M, STROKE = 0.5, 15.0, 6e-3


def one_harmonic(amplitude, package, harmonic=1):
    """U = amplitude cos kφ."""
    names = [name for name in package.variables if name.startswith("follower[1].cam.")]
    return {name: 0.0 for name in names} | {f"follower[1].cam.a[{harmonic}]": amplitude}


def time_of_passage(j0, added, phi_start, w_start, phi):
    """The time at which a machine without motor, J = j0 + added sin²φ, passes `phi`: ∫√(J/2E) dφ."""
    with mp.workdps(40):
        j0, added = mp.mpf(j0), mp.mpf(added)
        energy = (j0 + added * mp.sin(mp.mpf(phi_start)) ** 2) * mp.mpf(w_start) ** 2 / 2
        span = mp.ellipe(mp.mpf(phi), -added / j0) - mp.ellipe(mp.mpf(phi_start), -added / j0)
        return span * mp.sqrt(j0 / (2 * energy)) * mp.sign(mp.mpf(w_start)), energy


def free_machine(packages, times, j0=J0, m=M, amplitude=STROKE, phi_start=0.4, w_start=20.0, inputs=False, **more):
    """Errors of the position in the turn (cos φ = U/A; the true angle from the time of passage by Newton's method), of
    the angle relative to itself, and of the energy."""
    package = packages["machine_torque" if inputs else "machine"]
    values = one_harmonic(amplitude, package) | {
        "J0": j0, "follower[1].m": m, "phi_start": phi_start, "w_start": w_start,
        **more,
    }
    # A motor without torque, said by an input.
    with probe(package, values, inputs={"M_an": 0.0} if inputs else None) as unit:
        reached, got = record(unit, times, (*NAMES, "U[1]"))
        worst = 0.0
        with mp.workdps(40):
            added = mp.mpf(m) * mp.mpf(amplitude) ** 2
            for time, (phi, w, _, energy, lift) in zip(reached, got):
                angle = mp.mpf(phi)
                for _ in range(3):
                    passed, expected = time_of_passage(j0, added, phi_start, w_start, angle)
                    speed = mp.sign(w_start) * mp.sqrt(2 * expected / (j0 + added * mp.sin(angle) ** 2))
                    angle += (mp.mpf(time) - passed) * speed
                # The energy at the angle of the drive itself: its speed there is wrong by the error of the energy alone.
                at = j0 + added * (1 - (mp.mpf(lift) / amplitude) ** 2)
                errors = [
                    mp.mpf(lift) / amplitude - mp.cos(angle),
                    (mp.mpf(phi) - angle) / max(1, abs(angle)),
                    energy / expected - 1,
                    (at * mp.mpf(w) ** 2 / (2 * expected) - 1) / 2,
                ]
                worst = max(worst, *(abs(float(e)) for e in errors))
        return unit.outcome(worst)


ELLIPTIC = "elliptic integral for the time of passage, ½Jφ̇² constant; 40 digits"


def declare(extreme, bound=1e-10, times=None, turns=3, **changes):
    @case(DRIVE, extreme, ELLIPTIC, bound)
    def run(packages):
        speed = abs(changes.get("w_start", 20.0))
        span = turns * 2 * math.pi / speed
        return free_machine(packages, span * np.arange(1, 11) / 10 if times is None else times, **changes)


declare("speed 1e-9 rad/s", w_start=1e-9)
declare("speed 1e5 rad/s", w_start=1e5)
declare("speed −1e5 rad/s over 1 s", times=[0.1, 1.0], w_start=-1e5)
# The angle relative to itself within 1e-13: its place in the turn within 1e-7.
declare("1e6 revolutions", times=np.linspace(0.0, 2 * math.pi * 1e6 / 20.0, 21)[1:], bound=1e-6)
declare(
    "communication steps 1e-12 … 1e3 s in one run",
    times=np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6, 1e-9]),
)
declare("amplitude 1e-12 m", amplitude=1e-12)
declare("amplitude 1e3 m (J from 0.5 to 1.5e7 kg·m²)", amplitude=1e3, turns=0.7)
declare("J_red dynamic range 1e9", j0=1e-9 * M * STROKE**2)
declare("J_red dynamic range 1e12", j0=1e-12 * M * STROKE**2)
declare("J0 1e12 kg·m²", j0=1e12)
declare("phase start 1e12 rad", phi_start=1e12)
MIXED = np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6, 1e-9])
declare("inputs: speed 1e-9 rad/s", w_start=1e-9, inputs=True)
declare("inputs: speed 1e5 rad/s", w_start=1e5, inputs=True)
declare("inputs: communication steps 1e-12 … 1e3 s in one run", times=MIXED, inputs=True)
declare("inputs: amplitude 1e-12 m", amplitude=1e-12, inputs=True)
declare("inputs: amplitude 1e3 m (J from 0.5 to 1.5e7 kg·m²)", amplitude=1e3, turns=0.7, inputs=True)
declare("inputs: J_red dynamic range 1e9", j0=1e-9 * M * STROKE**2, inputs=True)
declare("inputs: phase start 1e12 rad", phi_start=1e12, inputs=True)


@case(DRIVE, "64 harmonics", "Gauss-Legendre quadrature for the time of passage, ½Jφ̇² constant", 1e-10)
def many_harmonics(packages):
    package = packages["machine_wide"]
    a = [0.0] + [1e-2 / k**2 for k in range(1, 65)]
    b = [0.0] + [1e-3 / k for k in range(1, 65)]
    values = {f"follower[1].cam.a[{k}]": v for k, v in enumerate(a)}
    values |= {f"follower[1].cam.b[{k}]": v for k, v in enumerate(b) if k} | {"phi_start": 0.4, "w_start": 20.0}
    k = np.arange(65)[:, None]

    def inertia(phi):
        slope = (np.array(b)[:, None] * k * np.cos(k * phi) - np.array(a)[:, None] * k * np.sin(k * phi)).sum(axis=0)
        return J0 + M * slope**2

    with probe(package, values) as unit:
        reached, got = record(unit, np.arange(1, 7) * 0.15, NAMES)
        energy = inertia(np.array([0.4]))[0] * 200.0
        worst = 0.0
        for time, (phi, w, _, _) in zip(reached, got):
            nodes, weights = np.polynomial.legendre.leggauss(20)
            edges = np.linspace(0.4, phi, 401 * math.ceil((phi - 0.4) / 6))
            half = np.diff(edges) / 2
            points = (edges[:-1] + half)[:, None] + half[:, None] * nodes
            values = np.sqrt(inertia(points.ravel()) / (2 * energy)).reshape(points.shape)
            passed = float(np.sum(half[:, None] * weights * values))
            worst = max(worst, abs(passed / time - 1), abs(inertia(np.array([phi]))[0] * w * w / (2 * energy) - 1))
        return unit.outcome(worst)


def dwells(packages, ratio, w_start):
    """Through the rise, the dwells and the return of a cycle, J0 the part `ratio` of m U′²max: the time of passage by
    quadrature on panels graded towards the ends of the rise and the return, where J falls to J0."""
    package, law = packages["machine_cycle"], reference.Cycle()
    # The inclined sine has U′ = 2 · 0.1 m/120° at most.
    j0, start = ratio * M * (0.3 / math.pi) ** 2, math.radians(90)
    inertia = lambda phi: j0 + M * law.derivative(phi, 1) ** 2
    energy = inertia(start) * w_start**2 / 2
    nodes, weights = np.polynomial.legendre.leggauss(20)

    def passage(low, high):
        borders = {b + 2 * math.pi * n for b in law.breakpoints for n in range(-3, 4)}
        graded = {b + sign * 10.0**-e for b in borders for sign in (-1, 1) for e in np.arange(1, 8, 0.5)}
        even = set(np.linspace(low, high, 30))
        edges = np.array(sorted(e for e in borders | graded | even if low <= e <= high))
        half = np.diff(edges)[:, None] / 2
        points = edges[:-1, None] + half * (1 + nodes)
        values = np.array([math.sqrt(inertia(p) / (2 * energy)) for p in points.ravel()]).reshape(points.shape)
        return float((half * weights * values).sum())

    with probe(package, {"J0": j0, "phi_start": start, "w_start": w_start}) as unit:
        worst = 0.0
        # The rise and the return take nearly all the time where J falls to next to nothing in the dwells.
        step = 0.2 if ratio < 1.0 else 0.4
        reached, got = record(unit, np.arange(1, 13) * step / abs(w_start), NAMES)
        for time, (phi, w, _, stated) in zip(reached, got):
            passed = passage(min(start, phi), max(start, phi))
            worst = max(worst, abs(passed / time - 1), abs(inertia(phi) * w * w / (2 * energy) - 1), abs(stated / energy - 1))
        assert abs(got[-1, 0] - start) > math.pi
        return unit.outcome(worst)


for exponent in (6, -3, -9, -12):
    for w in (2.0, -2.0):
        @case(
            DRIVE, f"J0/(m U′²max) = 1e{exponent}, dwells{', backwards' if w < 0 else ''}",
            "Gauss-Legendre quadrature for the time of passage, ½Jφ̇² constant", 1e-9,
        )
        def through_dwells(packages, exponent=exponent, w=w):
            return dwells(packages, 10.0**exponent, w)


@refusal(DRIVE, "J0/(m U′²max) = 1e-12, 2e7 rad/s in the dwells", "its speed exceeds 1e7 rad/s", "the speed leaves the range of the model")
def too_fast(packages):
    values = {"J0": 1e-12 * M * (0.3 / math.pi) ** 2, "phi_start": math.radians(90), "w_start": 20.0}
    return refused(packages["machine_cycle"], values, run=lambda unit: unit.step(0.1))


@case(DRIVE, "speed 0, no torque", "the machine stays where it is", 0.0)
def rest(packages):
    with probe(packages["machine"], {"phi_start": 0.4, "w_start": 0.0}) as unit:
        _, got = record(unit, [1e-9, 1.0, 1e3], ("phi", "w"))
        return unit.outcome(np.abs(got - [0.4, 0.0]).max())


def kloss_run_up(j, breakdown, slip, synchronous, w_start, t):
    """φ and w at t: σ²/2 + ln σ = C − κt with σ = (w_s − w)/(w_s s_k), κ = 2M_k/(J w_s s_k)."""
    with mp.workdps(50):
        j, breakdown, slip, synchronous, w_start, t = (mp.mpf(v) for v in (j, breakdown, slip, synchronous, w_start, t))
        kappa = 2 * breakdown / (j * abs(synchronous) * slip)
        start = (synchronous - w_start) / (synchronous * slip)
        exponent = start**2 + 2 * mp.log(start) - 2 * kappa * t
        # W(e^x): for large x by Newton's method on y + ln y = x, since e^x has no use.
        if exponent > 100:
            y = exponent - mp.log(exponent)
            for _ in range(20):
                y -= (y + mp.log(y) - exponent) * y / (1 + y)
        else:
            y = mp.lambertw(mp.exp(exponent))
        sigma = mp.sqrt(mp.re(y))
        area = ((start**3 - sigma**3) / 3 + (start - sigma)) / kappa
        return float(synchronous * t - synchronous * slip * area), float(synchronous * (1 - slip * sigma))


LAMBERT = "run-up at constant J in closed form (Lambert's function), 50 digits"


def run_up(packages, scene, times, slip, bound_names=("phi", "w"), j=J0, m=0.0, breakdown=60.0, synchronous=60.0, w_start=0.0, **more):
    values = {
        "J0": j, "follower[1].m": m, "motor.M_k": breakdown, "motor.s_k": slip, "motor.w_s": synchronous,
        "w_start": w_start, "phi_start": 0.0, **more,
    }
    with probe(packages[scene], values) as unit:
        reached, got = record(unit, times, bound_names)
        expected = np.array([kloss_run_up(j, breakdown, slip, synchronous, w_start, t) for t in reached])
        angle, speed = np.abs(got - expected).T
        # While the machine passes its breakdown torque, w changes by 1e-9 of itself within the rounding of the time; the
        # error is there that of the instant at which it has the speed.
        acceleration = [abs(reference.kloss(w, breakdown, slip, synchronous)) / j for w in expected[:, 1]]
        instant = speed / np.maximum(acceleration, 1e-300) / reached
        return unit.outcome(max((angle / np.abs(expected[:, 0])).max(), np.minimum(speed / abs(synchronous), instant).max()))


def declare_run_up(extreme, times, bound=1e-9, scene="machine_motor", truth=LAMBERT, **changes):
    @case(DRIVE, extreme, truth, bound)
    def run(packages):
        return run_up(packages, scene, times, **changes)


# The machine is at speed when κ t is near σ²/2; the later times lie on the stiff part.
declare_run_up("breakdown slip 1e-6, run-up and stiff run", [1.0, 100.0, 249.0, 250.0, 251.0, 300.0], slip=1e-6, j=1e-3)
declare_run_up("breakdown slip 1e-6, from synchronism + 1e-6", [1e-9, 1e-6, 1e-3, 1.0, 100.0], slip=1e-6, w_start=60.0 * (1 - 1e-6), j=1e-3)
declare_run_up("breakdown slip 1e3", [1e-3, 1.0, 100.0, 300.0, 600.0, 900.0], slip=1e3)
declare_run_up("motor, communication steps 1e-12 … 1e3 s in one run", np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e-3, 1e-6]), slip=0.12)
declare_run_up("motor, J0 1e9 kg·m² at speed 1e-9 rad/s", [1.0, 1e3, 1e6], slip=0.12, j=1e9, w_start=1e-9)
declare_run_up("reversed motor, breakdown slip 0.12", [0.01, 0.3, 1.0, 30.0], slip=0.12, synchronous=-60.0)
EQUAL = {"solver.method": FIXED_COST}
declare("fixed cost: speed 1e5 rad/s", bound=1e-5, w_start=1e5, **EQUAL)
declare("fixed cost: amplitude 1e-12 m", bound=1e-5, amplitude=1e-12, **EQUAL)
declare("fixed cost: J_red dynamic range 1e3", bound=1e-5, j0=1e-3 * M * STROKE**2, **EQUAL)
declare("fixed cost: J0 1e12 kg·m²", bound=1e-5, j0=1e12, **EQUAL)
declare("fixed cost: speed 1e-9 rad/s", bound=1e-5, w_start=1e-9, **EQUAL)
declare("fixed cost: phase start 1e12 rad", bound=1e-5, phi_start=1e12, **EQUAL)
# Equal internal steps for 1e3 s are more than the work of one call.
FEWER = np.cumsum([1e-12, 1e-9, 1e-6, 1e-3, 1.0, 3e2, 1e-3, 1e-6, 1e-9])
declare("fixed cost: communication steps 1e-12 … 3e2 s in one run", bound=1e-5, times=FEWER, **EQUAL)
declare("fixed cost, inputs: communication steps 1e-12 … 3e2 s in one run", bound=1e-5, times=FEWER, inputs=True, **EQUAL)
declare_run_up("fixed cost: breakdown slip 1e3", [1e-3, 1.0, 100.0], bound=1e-5, slip=1e3, **EQUAL)
declare_run_up("fixed cost: reversed motor, breakdown slip 0.12", [0.01, 0.3, 1.0, 30.0], bound=1e-5, slip=0.12, synchronous=-60.0, **EQUAL)


@refusal(DRIVE, "fixed cost: internal steps of 10 turns", "shorten solver.step_size, or set solver.method = adaptive", "the steps pass over the inertia")
def coarse(packages):
    values = {"w_start": 20.0, "solver.step_size": 20 * math.pi / 20.0, **EQUAL}
    return refused(packages["machine"], one_harmonic(STROKE, packages["machine"]) | values, run=lambda unit: [unit.step(10.0) for _ in range(5)])


@refusal(DRIVE, "fixed cost: breakdown slip 1e-3", "shorten solver.step_size, or set solver.method = adaptive", "the steps pass over the motor's response")
def steep(packages):
    values = {"motor.M_k": 60.0, "motor.s_k": 1e-3, "motor.w_s": 60.0, "J0": 1e-3, "follower[1].m": 0.0, "w_start": 0.0, **EQUAL}
    return refused(packages["machine_motor"], values, run=lambda unit: [unit.step(0.1) for _ in range(10)])


@refusal(DRIVE, "fixed cost: J_red dynamic range 1e9", "need more work than one call may take", "the default step follows the range")
def fine(packages):
    values = {"J0": 1e-9 * M * STROKE**2, "follower[1].m": M, "w_start": 20.0, "phi_start": 0.4, **EQUAL}
    return refused(packages["machine"], one_harmonic(STROKE, packages["machine"]) | values, run=lambda unit: unit.step(0.3))


declare_run_up(
    "motor lag 1e-9 s", [1e-3, 1e-2, 0.3, 1.0, 30.0], slip=0.12, scene="machine_lag", bound=1e-5,
    truth="run-up without lag (Lambert); remainder 2 T_el/t = 2e-6", **{"motor.T_el": 1e-9},
)


def slow_manifold(j0, followers, breakdown, slip, synchronous, phi):
    """The speed w(φ) of the stationary run of a stiff motor, from ½J′w² + J w w′ = M(w) by iteration on the slip:
    σ ↦ the root of 2M_k σ/(1 + σ²) = ½J′w² + J w w′, w = w_s (1 − s_k σ); Fourier differentiation over a turn."""
    n = 512
    angles = 2 * math.pi * np.arange(n) / n
    j = np.array([j0 + sum(m * f.derivative(p, 1) ** 2 for m, f in followers) for p in angles])
    j1 = np.array([sum(2 * m * f.derivative(p, 1) * f.derivative(p, 2) for m, f in followers) for p in angles])
    order = np.fft.fftfreq(n, 1 / n)
    sigma = np.zeros(n)
    for _ in range(60):
        w = synchronous * (1 - slip * sigma)
        slope = -synchronous * slip * np.real(np.fft.ifft(1j * order * np.fft.fft(sigma)))
        load = (j1 * w * w / 2 + j * w * slope) / breakdown
        sigma = load / (1 + np.sqrt(1 - load * load))
    value = np.real(np.sum(np.fft.fft(sigma)[:, None] * np.exp(1j * order[:, None] * np.atleast_1d(phi)), axis=0)) / n
    return synchronous * (1 - slip * value)


@case(DRIVE, "breakdown slip 1e-6, varying inertia, 100 turns", "stationary run by Fourier series; error of w", 1e-9)
def stiff_motor(packages):
    package = packages["machine_motor"]
    values = package.parameters()
    series = reference.Series.of(package, "follower[1].cam")
    of = lambda phi: slow_manifold(J0, [(M, series)], 60.0, 1e-6, 60.0, phi)
    changes = {"motor.s_k": 1e-6, "phi_start": 0.0, "w_start": float(of(0.0)[0])}
    with probe(package, changes) as unit:
        _, got = record(unit, np.linspace(0.0, 10.5, 60)[1:], ("phi", "w"))
        expected = of(got[:, 0])
        return unit.outcome(np.abs(got[:, 1] - expected).max() / 60.0)


@case(DRIVE, "J_red dynamic range 1e9 on a motor", "Dormand-Prince 8(5,3) at 1e-13 for E and t over the angle", 1e-9)
def range_on_a_motor(packages):
    package = packages["machine_motor"]
    j0, amplitude = 1e-9 * M, 1.0
    values = one_harmonic(amplitude, package) | {
        "J0": j0, "phi_start": 1.0, "w_start": 20.0, "motor.w_s": 60.0, "motor.s_k": 0.12, "motor.M_k": 60.0
    }

    def inertia(phi):
        return j0 + M * amplitude**2 * math.sin(phi) ** 2

    def rhs(phi, state):
        w = math.sqrt(2 * state[0] / inertia(phi))
        return [reference.kloss(w, 60.0, 0.12, 60.0), 1 / w]

    with probe(package, values) as unit:
        reached, got = record(unit, np.linspace(0.0, 5.0, 11)[1:], ("phi", "w"))
        # Steps that end where J is smallest, which they must not overlook.
        stops = [k * math.pi + d for k in range(1, int(got[-1, 0] / math.pi) + 2) for d in (-1e-3, 0.0, 1e-3)]
        states = reference.integrate_pieces(
            rhs, [inertia(1.0) * 200.0, 0.0], [1.0, *got[:, 0]], [s for s in stops if s < got[-1, 0]]
        )
        energies = np.array([inertia(p) * w * w / 2 for p, w in got])
        worst = np.abs(states[1:, 1] / np.array(reached) - 1).max()
        return unit.outcome(max(worst, np.abs(energies / states[1:, 0] - 1).max()))


@case(DRIVE, "reversal at constant torque, one step of 10 s", "φ = φ₀ + w₀ t − τ t²/2J", 1e-12)
def reversal(packages):
    package = packages["machine_torque"]
    with probe(package, {"follower[1].m": 0.0, "phi_start": 0.0, "w_start": 20.0, "J0": 0.5}, inputs={"tau": 4.0}) as unit:
        _, got = record(unit, [2.5, 10.0], ("phi", "w"))
        return unit.outcome(np.abs(got - [[25.0, 0.0], [-200.0, -60.0]]).max() / 200.0)


@case(DRIVE, "reversal with J_red dynamic range 1e9", "E is linear in the angle; quadrature over √E for the time", 1e-9)
def reversal_of_a_range(packages):
    """E = E0 − τ (φ − φ0); with v = √E: t = ∫ √(2 J(φ(v)))/τ dv, which is regular at the reversal."""
    package = packages["machine_torque"]
    j0, load, phi_start, w_start = 1e-9 * M, 4.0, 1.0, 3.0
    inertia = lambda phi: j0 + M * np.sin(phi) ** 2
    values = one_harmonic(1.0, package) | {"J0": j0, "phi_start": phi_start, "w_start": w_start}
    start = inertia(phi_start) * w_start**2 / 2
    with probe(package, values, inputs={"tau": load}) as unit:
        reached, got = record(unit, [1.0, 3.0, 6.0, 9.0, 12.0], ("phi", "w"))
        worst = 0.0
        for time, (phi, w) in zip(reached, got):
            energy = start - load * (phi - phi_start)
            worst = max(worst, abs(inertia(phi) * w * w / 2 - energy) / start)
            end = math.copysign(math.sqrt(max(energy, 0.0)), w)
            angles = lambda v: phi_start + (start - v * v) / load
            # Panels between the zeros of sin φ, graded towards them: √J is |sin φ| there down to 3e-5.
            edges = {math.sqrt(start), end}
            for k in range(-40, 40):
                square = start - load * (k * math.pi - phi_start)
                if square > 0.0:
                    middle = math.sqrt(square)
                    for sign in (-1.0, 1.0):
                        edges |= {sign * middle + d * 10.0**-e for d in (-1, 1) for e in range(1, 9)} | {sign * middle}
            edges = sorted(e for e in edges if end <= e <= math.sqrt(start))
            nodes, weights = np.polynomial.legendre.leggauss(24)
            total = 0.0
            for low, high in zip(edges[:-1], edges[1:]):
                for part in range(4):
                    a, b = low + (high - low) * part / 4, low + (high - low) * (part + 1) / 4
                    v = (a + b) / 2 + (b - a) / 2 * nodes
                    total += (b - a) / 2 * np.sum(weights * np.sqrt(2 * inertia(angles(v)))) / load
            worst = max(worst, abs(total / time - 1))
        return unit.outcome(worst)


@refusal(DRIVE, "phase start 1e16 rad", "`phi_start`: 1e16 rad is not admissible; expected -1e15 to 1e15 rad", "numbers of this size are 2 rad apart")
def phase(packages):
    return refused(packages["machine"], {"phi_start": 1e16})


@refusal(DRIVE, "J = 0 where U′ = 0", "the reduced moment of inertia J(phi) = J0 + sum m U'^2 must be", "no torque could be accelerated")
def no_inertia(packages):
    return refused(packages["machine"], {"J0": 0.0})


@refusal(DRIVE, "breakdown slip 0", "`motor.s_k`: 0 is not admissible", "the characteristic has no slope")
def no_slip(packages):
    return refused(packages["machine_motor"], {"motor.s_k": 0.0})


@refusal(DRIVE, "torque 1e300 N·m", "the machine runs away", "the speed leaves the range of the model")
def overflow(packages):
    return refused(packages["machine_torque"], run=lambda unit: (unit.set(M_an=1e300), unit.step(1.0)))
