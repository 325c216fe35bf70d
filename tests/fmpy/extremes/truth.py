"""Truths that the closed forms of `reference` do not cover."""

import json
import math
import os
from pathlib import Path

import mpmath as mp
import numpy as np
from scipy.integrate import solve_ivp


STORE = Path(__file__).with_name("stored.json")


REMEMBERED = {}


def remembered(key, compute):
    """What `compute()` yields, once for all cases with the same key."""
    if key not in REMEMBERED:
        REMEMBERED[key] = compute()
    return REMEMBERED[key]


# scipy admits 100 roundings.
FINEST = 2.3e-14


def stored(name, times, compute):
    """The values at `times` that `compute()` yields, from `stored.json`, since they take long. BLESS=1 computes those
    that are missing or for other times; without the file all of them."""
    values = json.loads(STORE.read_text()) if STORE.exists() else {}
    times = [float(t) for t in times]
    if name not in values or values[name]["times"] != times:
        assert os.environ.get("BLESS") == "1", f"`{name}` is not stored for these times"
        values[name] = {"times": times, "values": np.asarray(compute()).tolist()}
        lines = (f"{json.dumps(name)}: {json.dumps(entry)}" for name, entry in values.items())
        STORE.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    return np.array(values[name]["values"])


def integrate(rhs, state, times, scale, longest=np.inf):
    """The states at `times` (the first is the start) by DOP853 at its finest tolerance, on variables divided by `scale`.
    Its steps end at the times: between, it interpolates with fewer digits."""
    scale = np.asarray(scale, dtype=float)
    states, step = [np.asarray(state) / scale], None
    for start, end in zip(times, times[1:]):
        solution = solve_ivp(
            lambda t, s: np.asarray(rhs(t, s * scale)) / scale,
            (start, end), states[-1], method="DOP853", rtol=FINEST, atol=1e-17, max_step=longest,
            first_step=min(step, end - start) if step else None,
        )
        assert solution.success, solution.message
        states.append(solution.y[:, -1])
        # The last step is cut short at the end.
        step = np.diff(solution.t).max()
    return np.array(states) * scale


def free_oscillation(m, b, c, q, v, times):
    """(q, der q) of m q'' + b q' + c q = 0 in 60 digits."""
    with mp.workdps(60):
        m, b, c, q, v = (mp.mpf(x) for x in (m, b, c, q, v))
        delta = b / (2 * m) * (1 + mp.mpf(10) ** -25)
        root = mp.sqrt(mp.mpc(delta**2 - c / m))
        l1, l2 = -delta + root, -delta - root
        c1, c2 = (v - l2 * q) / (l1 - l2), (l1 * q - v) / (l1 - l2)
        result = []
        for t in times:
            e1, e2 = c1 * mp.exp(l1 * mp.mpf(t)), c2 * mp.exp(l2 * mp.mpf(t))
            result.append((float(mp.re(e1 + e2)), float(mp.re(l1 * e1 + l2 * e2))))
        return np.array(result)


class Periodic:
    """The periodic motion of the elastic shaft at constant speed w, by Fourier collocation: q on n equidistant angles,
    Newton's method on the equation of motion. The truncation is below rounding when the spectrum has decayed."""

    def __init__(self, p, series, linear, n=256):
        self.n, self.w = n, p["drive.w"]
        m, inertia, c, b, w = p["m"], p["J"], p["c"], p["b"], self.w
        angles = 2 * math.pi * np.arange(n) / n
        derivative = self.matrix(n)
        first, second = w * derivative, w * w * derivative @ derivative
        of = lambda x, order: np.array([series.derivative(v, order) for v in x])
        if linear:
            u1, u2, u3 = (of(angles, k) for k in (1, 2, 3))
            j = inertia + m * u1 * u1
            matrix = j[:, None] * second + (b + 2 * m * w * u1 * u2)[:, None] * first
            matrix += np.diag(c + m * w * w * (u2 * u2 + u1 * u3))
            q = np.linalg.solve(matrix, -m * w * w * u1 * u2)
        else:
            q = np.zeros(n)
            for _ in range(50):
                u1, u2, u3 = (of(angles + q, k) for k in (1, 2, 3))
                j, speed, acceleration = inertia + m * u1 * u1, w + first @ q, second @ q
                residual = j * acceleration + m * u1 * u2 * speed**2 + b * (first @ q) + c * q
                matrix = j[:, None] * second + (2 * m * u1 * u2 * speed + b)[:, None] * first
                matrix += np.diag(2 * m * u1 * u2 * acceleration + m * (u2 * u2 + u1 * u3) * speed**2 + c)
                change = np.linalg.solve(matrix, residual)
                q = q - change
                if np.abs(change).max() <= 1e-12 * np.abs(q).max():
                    break
        self.modes = np.fft.fft(q) / n
        tail = np.abs(self.modes[n // 3 : n - n // 3]).max()
        assert tail <= 1e-9 * np.abs(q).max(), f"the spectrum has not decayed: {tail:.1e}"

    @staticmethod
    def matrix(n):
        """Differentiation of trigonometric polynomials on n (even) equidistant points."""
        k = np.arange(n)
        distance = (k[:, None] - k[None, :]) * math.pi / n
        with np.errstate(divide="ignore", invalid="ignore"):
            d = 0.5 * (-1.0) ** (k[:, None] - k[None, :]) / np.tan(distance)
        np.fill_diagonal(d, 0.0)
        return d

    def at(self, phi):
        """(q, der q) at the angle phi."""
        order = np.fft.fftfreq(self.n, 1 / self.n)
        wave = self.modes * np.exp(1j * order * phi)
        return float(np.real(wave.sum())), float(np.real((1j * order * self.w * wave).sum()))
