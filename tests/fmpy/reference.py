"""Independent solutions of the drives' equations: closed forms in multiple precision (mpmath) and
Dormand-Prince 8(5,3) of scipy at the limit of double precision. Nothing here is taken from the Rust code."""

import math
from pathlib import Path

import mpmath as mp
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline


class Series:
    """U(phi) = a0 + sum a_k cos k phi + b_k sin k phi."""

    def __init__(self, a, b=()):
        n = max(len(a), len(b))
        self.a = list(a) + [0.0] * (n - len(a))
        self.b = list(b) + [0.0] * (n - len(b))

    @classmethod
    def of(cls, package, prefix="cam"):
        """The law from the start values of the parameters of an FMU."""
        values = package.parameters()
        a, b = [], [0.0]
        while f"{prefix}.a[{len(a)}]" in values:
            a.append(values[f"{prefix}.a[{len(a)}]"])
        while f"{prefix}.b[{len(b)}]" in values:
            b.append(values[f"{prefix}.b[{len(b)}]"])
        return cls(a, b)

    def derivative(self, phi, order, sin=math.sin, cos=math.cos):
        """d^n U / d phi^n by shifting the phase of every harmonic by n quarter turns."""
        shifted = [(cos, sin, 1, 1), (sin, cos, -1, 1), (cos, sin, -1, -1), (sin, cos, 1, -1)][order % 4]
        f, g, sf, sg = shifted
        total = self.a[0] if order == 0 else 0
        for k in range(1, len(self.a)):
            total += k**order * (sf * self.a[k] * f(k * phi) + sg * self.b[k] * g(k * phi))
        return total


class Cycle:
    """The cycle of the test scenes: inclined sine over 120 deg from 30 deg on, dwell of 60 deg, return by the modified
    sine over 100 deg, 0.1 m."""

    STROKE, START, RISE, DWELL, RETURN = 0.1, math.radians(30), math.radians(120), math.radians(60), math.radians(100)

    def __init__(self):
        back = self.START + self.RISE + self.DWELL
        self.breakpoints = [self.START, self.START + self.RISE] + [back + f * self.RETURN for f in (0, 1 / 8, 7 / 8, 1)]

    def derivative(self, phi, order):
        angle = (phi - self.START) % (2 * math.pi)
        if angle < self.RISE:
            return self.STROKE * self.inclined_sine(angle / self.RISE)[order] / self.RISE**order
        angle -= self.RISE
        if angle < self.DWELL:
            return self.STROKE if order == 0 else 0.0
        angle -= self.DWELL
        if angle >= self.RETURN:
            return 0.0
        fall = -self.STROKE * self.modified_sine(angle / self.RETURN)[order] / self.RETURN**order
        return fall + (self.STROKE if order == 0 else 0.0)

    @staticmethod
    def inclined_sine(z):
        turn = 2 * math.pi
        s, c = math.sin(turn * z), math.cos(turn * z)
        return z - s / turn, 1 - c, turn * s, turn**2 * c

    @staticmethod
    def modified_sine(z):
        """The acceleration is a sine of period 1/2 over the first and last eighth and of period 3/2 between."""
        pi, factor = math.pi, math.pi / (4 + math.pi)
        if 1 / 8 < z < 7 / 8:
            slow = (pi + 4 * pi * z) / 3
            s, c = math.sin(slow), math.cos(slow)
            shape = 2 / pi + z - 9 / (4 * pi) * s, 1 - 3 * c, 4 * pi * s, 16 * pi**2 / 3 * c
        else:
            s, c = math.sin(4 * pi * z), math.cos(4 * pi * z)
            base = 0 if z <= 1 / 8 else 4 / pi
            shape = base + z - s / (4 * pi), 1 - c, 4 * pi * s, 16 * pi**2 * c
        return [factor * d for d in shape]


class Table:
    """The periodic quintic spline of scipy through the points of the test scenes (degrees, millimetres)."""

    def __init__(self):
        rows = np.loadtxt(Path(__file__).parent / "scenes" / "profile.csv", delimiter=";", skiprows=1)
        angles, lifts = np.radians(rows[:, 0]), rows[:, 1] * 1e-3
        spline = make_interp_spline(angles, lifts, k=5, bc_type="periodic")
        self.derivatives = [spline] + [spline.derivative(n) for n in range(1, 4)]
        self.breakpoints = list(angles[:-1])

    def derivative(self, phi, order):
        return float(self.derivatives[order](phi % (2 * math.pi)))


def passages(law, phi, w, start, stop):
    """When a cam that turns by phi + w (t - start) passes the breakpoints of its law."""
    end = phi + w * (stop - start)
    low, high = min(phi, end), max(phi, end)
    turns = range(math.floor(low / (2 * math.pi)) - 1, math.ceil(high / (2 * math.pi)) + 1)
    angles = [b + 2 * math.pi * n for n in turns for b in law.breakpoints]
    return [start + (angle - phi) / w for angle in angles if low < angle < high]


def elastic_output_closed(m, c, b, series, w, phi_start, q0, v0, times, digits=60):
    """(q, der q) of m q'' + b q' + c q = -m x'' at constant speed, from (q0, v0) at t = 0.

    Superposition of the steady harmonics and the free motion in `digits` decimal digits, so that neither
    resonance nor critical damping costs accuracy; exactly at an undamped resonance the speed is moved by
    1e-25 relatively, which changes q by less than 1e-17 of its size over 1e6 revolutions.
    """
    with mp.workdps(digits):
        m, c, b, phi0 = (mp.mpf(v) for v in (m, c, b, phi_start))
        omega = mp.mpf(w) * (1 + mp.mpf(10) ** -25)
        delta = b / (2 * m) * (1 + mp.mpf(10) ** -25)
        root = mp.sqrt(mp.mpc(delta**2 - c / m))
        if root == 0:
            root = mp.mpf(10) ** -22
        l1, l2 = -delta + root, -delta - root
        harmonics = []
        for k in range(1, len(series.a)):
            x = mp.mpc(series.a[k], -mp.mpf(series.b[k])) * mp.expj(k * phi0)
            nu = k * omega
            if x != 0:
                harmonics.append((nu, m * nu**2 * x / (c - m * nu**2 + 1j * nu * b)))
        h0 = mp.mpf(q0) - sum(mp.re(q) for _, q in harmonics)
        h1 = mp.mpf(v0) - sum(mp.re(1j * nu * q) for nu, q in harmonics)
        c1, c2 = (h1 - l2 * h0) / (l1 - l2), (l1 * h0 - h1) / (l1 - l2)
        result = []
        for t in times:
            t = mp.mpf(t)
            e1, e2 = c1 * mp.exp(l1 * t), c2 * mp.exp(l2 * t)
            forced = [(nu, q * mp.expj(nu * t)) for nu, q in harmonics]
            position = mp.re(e1 + e2) + sum(mp.re(z) for _, z in forced)
            velocity = mp.re(l1 * e1 + l2 * e2) + sum(mp.re(1j * nu * z) for nu, z in forced)
            result.append((float(position), float(velocity)))
        return np.array(result)


def integrate(rhs, state, times, longest=np.inf):
    """The states at `times` (the first is the start) by DOP853 at rtol 1e-13."""
    solution = solve_ivp(
        rhs, (times[0], times[-1]), state, method="DOP853", rtol=1e-13, atol=1e-15, t_eval=times, max_step=longest
    )
    assert solution.success, solution.message
    return solution.y.T


def integrate_pieces(rhs, state, times, stops):
    """The same with steps that end at `stops`, where the right-hand side is not smooth."""
    ends, states = sorted({*times[1:], *stops}), [state]
    at = times[0]
    for end in ends:
        if end > at:
            state = integrate(rhs, state, [at, end])[-1]
            at = end
        if end in times:
            states.append(state)
    return np.array(states)


def elastic_output(m, c, b, series, motion):
    """Right-hand side for (q, der q); `motion` yields phi, w, a."""

    def rhs(t, s):
        phi, w, a = motion(t)
        xdd = series.derivative(phi, 2) * w * w + series.derivative(phi, 1) * a
        return [s[1], -(b * s[1] + c * s[0]) / m - xdd]

    return rhs


def elastic_shaft(m, inertia, c, b, series, motion, linear):
    """Right-hand side for (q, der q): physics of the elastic input shaft, twist q = psi - phi."""

    def rhs(t, s):
        q, v = s
        phi, w, a = motion(t)
        psi = phi if linear else phi + q
        u1, u2, u3 = (series.derivative(psi, n) for n in (1, 2, 3))
        j = inertia + m * u1 * u1
        if linear:
            force = -m * w * w * u1 * u2 - j * a
            damping = b + 2 * m * w * u1 * u2
            stiffness = c + m * w * w * (u2 * u2 + u1 * u3) + 2 * m * a * u1 * u2
            return [v, (force - damping * v - stiffness * q) / j]
        psid = w + v
        return [v, -(m * u1 * u2 * psid * psid + b * v + c * q) / j - a]

    return rhs


class Springs:
    """The stiffness of a parallel-crank drive: springs in series, and the dead centres as limits."""

    def __init__(self, p, second=None):
        self.p, self.second = p, second

    def at(self, phi):
        p = self.p
        shafts = 1 / (1 / p["c_T1"] + 1 / p["c_T2"])
        rod = lambda x: p["c_AB"] * (p["R"] * math.sin(x)) ** 2
        series = lambda k: shafts * k / (shafts + k)
        ahead = phi + p.get("second.angle", 0.0)
        if self.second == "own":
            return series(rod(phi)) + series(rod(ahead))
        return series(rod(phi) + (rod(ahead) if self.second == "shared" else 0.0))


class Parametric:
    """m, b, c and f of a parametric drive over the angle, from the parameters of an FMU."""

    def __init__(self, package, changes=(), second=None):
        p = self.p = package.parameters() | dict(changes)
        self.relative = "J" in p
        load = self.series(p, "f")
        if self.relative:
            springs = Springs(p, second)
            constants = lambda phi: (p["J"], p["b_T"], springs.at(phi))
        else:
            series = [self.series(p, letter) for letter in "mbc"]
            constants = lambda phi: tuple(s.derivative(phi, 0) for s in series)
        self.at = lambda phi: (*constants(phi), load.derivative(phi, 0))

    @staticmethod
    def series(p, letter):
        pick = lambda part, first: [p[f"{letter}.{part}[{k}]"] for k in range(first, 1000) if f"{letter}.{part}[{k}]" in p]
        return Series(pick("a", 0) or [0.0], [0.0, *pick("b", 1)])

    def rhs(self, motion, forced=True):
        """For (q, der q)."""

        def rhs(t, s):
            phi, _, a = motion(t)
            m, b, c, f = self.at(phi)
            force = f - (m * a if self.relative else 0.0) if forced else 0.0
            return [s[1], (force - b * s[1] - c * s[0]) / m]

        return rhs

    def monodromy(self, w):
        """The matrix of a turn from phi = 0."""
        rhs = self.rhs(lambda t: (w * t, w, 0.0), forced=False)
        m, _, c, _ = self.at(1.0)
        rate = math.sqrt(abs(c) / m)
        free = lambda q, v: integrate(lambda t, s: [rate * s[1], rhs(t, [s[0], rate * s[1]])[1] / rate], [q, v], [0, 2 * math.pi / abs(w)])[-1]
        return np.array([free(1.0, 0.0), free(0.0, 1.0)]).T


def mathieu(b, epsilon, w, start, times, digits=30):
    """(q, der q) of q'' + b q' + (1 - epsilon cos w t) q = 0 by Taylor series of order 30 in `digits` decimal digits."""
    order = 30
    with mp.workdps(digits):
        b, epsilon, w = (mp.mpf(v) for v in (b, epsilon, w))
        q, v, t, result = mp.mpf(start[0]), mp.mpf(start[1]), mp.mpf(0), []
        longest = 2 / (1 + abs(w))
        for target in times:
            span = mp.mpf(float(target)) - t
            count = int(mp.ceil(span / longest))
            h = span / count
            for _ in range(count):
                # The coefficients of epsilon cos w(t + x), each derivative a quarter of a turn on, and with them those of q.
                wave = [epsilon * mp.cos(w * t), -epsilon * mp.sin(w * t)]
                wave = [wave[k % 2] * (-1) ** (k // 2) * w**k / mp.factorial(k) for k in range(order)]
                c = [q, v]
                for k in range(order):
                    product = c[k] - mp.fsum(wave[i] * c[k - i] for i in range(k + 1))
                    c.append(-(b * (k + 1) * c[k + 1] + product) / ((k + 1) * (k + 2)))
                q, v = mp.fsum(x * h**k for k, x in enumerate(c)), mp.fsum(k * x * h ** (k - 1) for k, x in enumerate(c) if k)
                t += h
            t = mp.mpf(float(target))
            result.append((float(q), float(v)))
        return np.array(result)


def kloss(w, breakdown_torque, breakdown_slip, synchronous):
    """Kloss torque, the rational form."""
    s = (synchronous - w) / synchronous
    return math.copysign(1, synchronous) * 2 * breakdown_torque * s * breakdown_slip / (s * s + breakdown_slip**2)


def rigid_machine(j0, followers, torque, load):
    """Right-hand side for (phi, w); followers: (mass, series); torque(w) of the motor; load(t)."""

    def rhs(t, s):
        phi, w = s
        j = j0 + sum(m * f.derivative(phi, 1) ** 2 for m, f in followers)
        half = sum(m * f.derivative(phi, 1) * f.derivative(phi, 2) for m, f in followers)
        return [w, (torque(w) - load(t) - half * w * w) / j]

    return rhs


class Backlash:
    """The two-sided clearance at constant speed, undamped or damped, in multiple precision: exact phases, the
    switching instants by a fine scan and bisection. Starts in contact from `start.q`,
    `start.q_dot`; e = 0, or e > 0 without chatter."""

    def __init__(self, p, series, digits=25):
        self.digits = digits
        with mp.workdps(digits):
            for name in ("m1", "m2", "c", "b", "s", "e"):
                setattr(self, name, mp.mpf(p[name]))
            self.start = mp.mpf(p["start.q"]), mp.mpf(p["start.q_dot"])
            self.series, self.w, self.phi0 = series, mp.mpf(p["drive.w"]), mp.mpf(p["drive.phi_start"])
            # Imaginary where the damping is above the critical one.
            self.contact_rate = mp.sqrt(mp.mpc(self.c / self.m2 - (self.b / (2 * self.m2)) ** 2))
            reduced = self.m1 * self.m2 / (self.m1 + self.m2)
            self.flight_decay = self.b / (2 * reduced)
            self.flight_rate = mp.sqrt(mp.mpc(self.c / reduced - self.flight_decay**2))
            # Neither the vibration nor the highest harmonic of the cam may turn within a step of the search.
            harmonics = [k for k in range(1, len(series.a)) if series.a[k] or series.b[k]]
            fastest = max(abs(self.flight_rate), self.flight_decay, abs(self.w) * max(harmonics, default=0))
            self.scan = mp.pi / (40 * fastest)

    def cam(self, t, order):
        return self.w**order * self.series.derivative(self.phi0 + self.w * t, order, mp.sin, mp.cos)

    def steady(self, t):
        """(q, der q) of the periodic contact solution."""
        q = v = mp.mpf(0)
        for k in range(1, len(self.series.a)):
            nu = k * self.w
            x = mp.mpc(self.series.a[k], -mp.mpf(self.series.b[k])) * mp.expj(k * (self.phi0 + self.w * t))
            z = self.m2 * nu**2 * x / (self.c - self.m2 * nu**2 + 1j * nu * self.b)
            q, v = q + mp.re(z), v + mp.re(1j * nu * z)
        return q, v

    @staticmethod
    def free(rate, decay, q, v, t):
        # At critical damping the limit rate → 0, to the square of what replaces it.
        rate = rate or mp.mpf(10) ** -(mp.mp.dps // 2)
        s, c, e = mp.sin(rate * t), mp.cos(rate * t), mp.exp(-decay * t)
        g = (v + decay * q) / rate
        return mp.re(e * (q * c + g * s)), mp.re(e * ((rate * g - decay * q) * c - (rate * q + decay * g) * s))

    def force(self, t, q, v):
        return self.m1 * self.cam(t, 2) - self.c * q - self.b * v

    def run(self, stop):
        """Events (time, kind, impulse) and the state (x1, v1, x2, v2) at `stop`, from contact at t = 0."""
        with mp.workdps(self.digits):
            t, events = mp.mpf(0), []
            q, v = self.start
            flank = 1 if self.force(t, q, v) > 0 else -1
            while True:
                t, q, v, done = self.contact(t, q, v, flank, mp.mpf(stop))
                if done:
                    x = self.cam(t, 0) + (0 if flank == 1 else self.s)
                    return events, [float(z) for z in (x, self.cam(t, 1), x + q, self.cam(t, 1) + v)]
                events.append((t, "release", mp.mpf(0)))
                x1 = self.cam(t, 0) + (0 if flank == 1 else self.s)
                state = [x1, self.cam(t, 1), x1 + q, self.cam(t, 1) + v]
                while True:
                    t, state, hit, done = self.flight(t, state, mp.mpf(stop))
                    if done:
                        return events, [float(z) for z in state]
                    jump = -(1 + self.e) * (state[1] - self.cam(t, 1))
                    events.append((t, "impact", self.m1 * jump))
                    state[1] += jump
                    q, v = state[2] - state[0], state[3] - self.cam(t, 1)
                    rebound = abs(state[1] - self.cam(t, 1))
                    if rebound < mp.mpf(10) ** (5 - self.digits) and hit * self.force(t, q, v) > 0:
                        flank = hit
                        break
                    if self.e == 0:
                        events.append((t, "release", mp.mpf(0)))

    def contact(self, t0, q0, v0, flank, stop):
        p0 = self.steady(t0)
        decay = self.b / (2 * self.m2)

        def at(t):
            h = self.free(self.contact_rate, decay, q0 - p0[0], v0 - p0[1], t - t0)
            p = self.steady(t)
            return h[0] + p[0], h[1] + p[1]

        guard = lambda t: flank * self.force(t, *at(t))
        t = self.first(guard, t0, stop, self.scan)
        end = stop if t is None else t
        return (end, *at(end), t is None)

    def flight(self, t0, state, stop):
        total = self.m1 + self.m2
        centre = (self.m1 * state[0] + self.m2 * state[2]) / total
        speed = (self.m1 * state[1] + self.m2 * state[3]) / total

        def at(t):
            r, u = self.free(self.flight_rate, self.flight_decay, state[2] - state[0], state[3] - state[1], t - t0)
            c = centre + speed * (t - t0)
            return [c - self.m2 / total * r, speed - self.m2 / total * u, c + self.m1 / total * r, speed + self.m1 / total * u]

        gap = lambda t: at(t)[0] - self.cam(t, 0)
        ta = self.first(gap, t0, stop, self.scan)
        tb = self.first(lambda t: self.s - gap(t), t0, stop, self.scan)
        hits = [(t, f) for t, f in ((ta, 1), (tb, -1)) if t is not None]
        if not hits:
            return stop, at(stop), 0, True
        t, flank = min(hits)
        landed = at(t)
        landed[0] = self.cam(t, 0) + (0 if flank == 1 else self.s)
        return t, landed, flank, False

    @staticmethod
    def first(g, t0, stop, scan):
        """The first downward crossing after t0; g may start from a zero of any order, so the search starts with small
        steps: it misses no crossing later than 1e-4 of `scan`."""
        t, before, step = t0, None, scan / 10**4
        while t < stop:
            u = min(t + step, stop)
            step = min(2 * step, scan)
            value = g(u)
            if value < 0 and before is not None and before > 0:
                lo, hi = t, u
                while hi - lo > mp.mpf(10) ** (3 - mp.mp.dps) * (1 + abs(hi)):
                    middle = (lo + hi) / 2
                    lo, hi = (middle, hi) if g(middle) > 0 else (lo, middle)
                return (lo + hi) / 2
            t, before = u, value
        return None
