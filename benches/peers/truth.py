"""The truth about the works: closed forms in 40 digits, or two integrations in 80-bit numbers that must agree."""

import ctypes
from pathlib import Path

import mpmath as mp
import numpy as np

STEPS = [12500, 33333, 10000, 10000, 10000, 10000, 10000]
M1, M2, M3, M4, RAMP, M5, M6 = range(7)
LAW = ((1, 0.59404), (3, -0.11066), (5, 0.01667))

# The largest disagreement of the two integrations, relative to the largest value: a tenth of the strictest accuracy.
AGREEMENT = 1e-13


def doubles(array):
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def truth(work, library, cache):
    """(outputs, rates) at the milliseconds; rates is None where they do not matter."""
    file = Path(cache) / f"truth_{work}.npz"
    if file.exists():
        stored = np.load(file)
        return stored["values"], stored["rates"]
    if work == M3:
        values = backlash()
        rates = np.zeros_like(values)
    else:
        # Steps per millisecond. The angle of a train grows without bound: finer steps only add its rounding.
        finest = 16 if work in (M5, M6) else 32
        (values, rates), (coarse, _) = (integrate(work, library, n) for n in (finest, finest // 2))
        difference = np.max(np.abs(values - coarse), axis=0) / np.max(np.abs(values), axis=0)
        assert difference.max() < AGREEMENT, f"work {work}: the references differ by {difference}"
        if work == M1:
            check = elastic_output(range(0, STEPS[M1], 250))
            difference = np.max(np.abs(values[::250] - check), axis=0) / np.max(np.abs(values), axis=0)
            assert difference.max() < AGREEMENT, f"closed form and integration differ by {difference}"
    np.savez(file, values=values, rates=rates)
    return values, rates


def integrate(work, library, n):
    values, rates = np.zeros((STEPS[work], 2)), np.zeros((STEPS[work], 2))
    assert library.reference(work, n, doubles(values), doubles(rates)) == 0
    return values, rates


def harmonics(stroke, frequency, m, b, c):
    """The steady q of m q'' + b q' + c q = -m x'': the complex amplitude for each angular frequency."""
    result = []
    for k, amplitude in LAW:
        nu = k * frequency
        result.append((nu, m * nu**2 * mp.mpf(amplitude) * stroke / (c - m * nu**2 + 1j * nu * b)))
    return result


def elastic_output(indices):
    with mp.workdps(40):
        c, b, w = mp.mpf(142122.30337568672), mp.mpf(15.079644737231007), mp.mpf(50.26548245743669)
        steady = harmonics(mp.mpf(0.01), w, 1, b, c)
        root = -b / 2 + 1j * mp.sqrt(c - b * b / 4)
        q0 = -sum(mp.re(q) for _, q in steady)
        v0 = -sum(mp.re(1j * nu * q) for nu, q in steady)
        # q = Re(z exp(root t)): Re z = q0, Re(root z) = v0.
        z = mp.mpc(q0, (mp.re(root) * q0 - v0) / mp.im(root))
        rows = []
        for i in indices:
            t = mp.mpf((i + 1) * 1e-3)
            free = z * mp.exp(root * t)
            forced = [(nu, q * mp.expj(nu * t)) for nu, q in steady]
            q = mp.re(free) + sum(mp.re(f) for _, f in forced)
            v = mp.re(root * free) + sum(mp.re(1j * nu * f) for nu, f in forced)
            rows.append((float(q), float(v)))
        return np.array(rows)


def backlash(turns=5):
    """x1, x2 of the drive with backlash: closed forms from event to event. Events are bracketed on a grid of 5
    microseconds in double precision and found in 40 digits."""
    with mp.workdps(40):
        m1, m2, c, s, w = (mp.mpf(v) for v in (2.0, 8.0, 505323.74533577514, 1e-4, 31.41592653589793))
        steady = harmonics(mp.mpf(0.02), w, m2, 0, c)
        bound, loose, mass = mp.sqrt(c / m2), mp.sqrt(c * (1 / m1 + 1 / m2)), m1 + m2

        def u(t, order, cos=mp.cos, stroke=mp.mpf(0.02), w=w, pi=mp.pi):
            return sum(mp.mpf(a) * stroke * (k * w) ** order * cos(k * w * t + order * pi / 2) for k, a in LAW)

        def contact(t0, q, v):
            h = q - sum(mp.re(z * mp.expj(nu * t0)) for nu, z in steady)
            h1 = v - sum(mp.re(1j * nu * z * mp.expj(nu * t0)) for nu, z in steady)

            def at(t):
                free = (h - 1j * h1 / bound) * mp.expj(bound * (t - t0))
                forced = [(nu, z * mp.expj(nu * t)) for nu, z in steady]
                return (
                    mp.re(free) + sum(mp.re(f) for _, f in forced),
                    mp.re(1j * bound * free) + sum(mp.re(1j * nu * f) for nu, f in forced),
                )

            return at

        def flight(t0, x1, v1, x2, v2):
            place, speed = (m1 * x1 + m2 * x2) / mass, (m1 * v1 + m2 * v2) / mass
            q, dq = x2 - x1, v2 - v1

            def at(t):
                d = t - t0
                e = (q - 1j * dq / loose) * mp.expj(loose * d)
                qt, vt = mp.re(e), mp.re(1j * loose * e)
                middle = place + speed * d
                return middle - m2 / mass * qt, speed - m2 / mass * vt, middle + m1 / mass * qt, speed + m1 / mass * vt

            return at

        # The same guards on arrays of doubles, to bracket the next event.
        def u_array(t, order):
            return sum(a * 0.02 * (k * float(w)) ** order * np.cos(k * float(w) * t + order * np.pi / 2) for k, a in LAW)

        def contact_guard_array(t0, q, v, side):
            f = [(float(nu), complex(z)) for nu, z in steady]
            h = float(q) - sum((z * np.exp(1j * nu * t0)).real for nu, z in f)
            h1 = float(v) - sum((1j * nu * z * np.exp(1j * nu * t0)).real for nu, z in f)
            om = float(bound)

            def g(t):
                qt = h * np.cos(om * (t - t0)) + h1 / om * np.sin(om * (t - t0))
                qt = qt + sum((z * np.exp(1j * nu * t)).real for nu, z in f)
                return side * (2.0 * u_array(t, 2) - float(c) * qt)

            return g

        def gap_array(t0, x1, v1, x2, v2):
            place, speed = float((m1 * x1 + m2 * x2) / mass), float((m1 * v1 + m2 * v2) / mass)
            q, dq, om = float(x2 - x1), float(v2 - v1), float(loose)

            def z(t):
                d = t - t0
                return place + speed * d - 0.8 * (q * np.cos(om * d) + dq / om * np.sin(om * d)) - u_array(t, 0)

            return z

        end, grid = turns * 0.2, 5e-6
        t = mp.mpf(0)
        side = 1 if u(t, 2) > 0 else -1
        q = v = mp.mpf(0)
        rows, i, state = [], 0, None
        count = round(end * 1e3)
        while i < count:
            start = float(t)
            times = start + grid * np.arange(1, 60001)
            if state is None:
                motion = contact(t, q, v)
                guards = [(side, contact_guard_array(start, q, v, side)(times))]
                exact = {side: lambda t, s=side, at=motion: s * (m1 * u(t, 2) - c * at(t)[0])}
            else:
                motion = flight(t, *state)
                z = gap_array(start, *state)(times)
                guards = [(1, z), (-1, float(s) - z)]
                exact = {
                    1: lambda t, at=motion: at(t)[0] - u(t, 0),
                    -1: lambda t, at=motion: u(t, 0) + s - at(t)[0],
                }
            found = None
            for which, g in guards:
                # A flight begins with a gap of zero that grows with the cube of time; below 1e-13 its sign is noise.
                below = np.nonzero(g < (-1e-13 if state is not None else 0.0))[0]
                if below.size and (found is None or times[below[0]] < found[1]):
                    found = (which, times[below[0]])
            low, high = mp.mpf(found[1]) - 3 * grid, mp.mpf(found[1]) + grid
            event = mp.findroot(exact[found[0]], (max(low, t), high), solver="anderson", tol=1e-60, verify=False)
            while i < count and (i + 1) * 1e-3 <= event:
                now = mp.mpf((i + 1) * 1e-3)
                if state is None:
                    x1 = u(now, 0) + (0 if side > 0 else s)
                    rows.append((float(x1), float(x1 + motion(now)[0])))
                else:
                    x1, _, x2, _ = motion(now)
                    rows.append((float(x1), float(x2)))
                i += 1
            t = event
            if state is None:
                x1, v1 = u(t, 0) + (0 if side > 0 else s), u(t, 1)
                q, v = motion(t)
                state = (x1, v1, x1 + q, v1 + v)
            else:
                _, _, x2, v2 = motion(t)
                side = found[0]
                x1, v1 = u(t, 0) + (0 if side > 0 else s), u(t, 1)
                if side * (m1 * u(t, 2) - c * (x2 - x1)) > 0:
                    q, v, state = x2 - x1, v2 - v1, None
                else:
                    state = (x1, v1, x2, v2)
        return np.array(rows)
