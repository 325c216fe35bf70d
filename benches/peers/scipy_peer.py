"""scipy's solve_ivp with right-hand sides compiled by numba: the methods DOP853, Radau and LSODA."""

import math
import time

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

METHODS = ["scipy DOP853", "scipy Radau", "scipy LSODA"]
A = (0.59404, -0.11066, 0.01667)


@njit
def u0(c, stroke):
    return stroke * c * (A[0] + A[1] * (4 * c * c - 3) + A[2] * ((16 * c * c - 20) * c * c + 5))


@njit
def u1(s, stroke):
    return -stroke * s * (A[0] + 3 * A[1] * (3 - 4 * s * s) + 5 * A[2] * ((16 * s * s - 20) * s * s + 5))


@njit
def u2(c, stroke):
    return -stroke * c * (A[0] + 9 * A[1] * (4 * c * c - 3) + 25 * A[2] * ((16 * c * c - 20) * c * c + 5))


@njit
def u3(s, stroke):
    return stroke * s * (A[0] + 27 * A[1] * (3 - 4 * s * s) + 125 * A[2] * ((16 * s * s - 20) * s * s + 5))


Q, W0, SPEED = 1e-4, 376.99111843077515, 50.26548245743669


@njit
def respond(y, acceleration):
    return np.array([W0 * y[1], -15.079644737231007 * y[1] - 142122.30337568672 / W0 * y[0] - acceleration / (Q * W0)])


@njit
def elastic_output(t, y):
    return respond(y, u2(math.cos(SPEED * t), 0.01) * SPEED * SPEED)


@njit
def ramp(t, y):
    rate = SPEED / 5
    if t <= 5:
        phi, w, a = 0.5 * rate * t * t, rate * t, rate
    else:
        phi, w, a = SPEED * (t - 2.5), SPEED, 0.0
    return respond(y, u2(math.cos(phi), 0.01) * w * w + u1(math.sin(phi), 0.01) * a)


@njit
def elastic_shaft(t, y):
    m, w = 20.0, 18.84955592153876
    s, c = math.sin(w * t), math.cos(w * t)
    d1, d2, d3 = u1(s, 0.1), u2(c, 0.1), u3(s, 0.1)
    g = m * w * d1 * d2
    stiffness = 2000.0 + m * w * w * (d2 * d2 + d1 * d3)
    torque = g * w / 20.0 + (0.6 + 2 * g) * y[1] + stiffness / 200.0 * y[0]
    return np.array([200.0 * y[1], -torque / (0.05 + m * d1 * d1)])


@njit
def rigid_machine(t, y):
    s, c, w = math.sin(y[0]), math.cos(y[0]), y[1]
    p1, p2, q1, q2 = u1(s, 0.1), u2(c, 0.1), u1(-c, 0.1), u2(s, 0.1)
    inertia = 0.5 + 30.0 * p1 * p1 + 15.0 * q1 * q1
    slip = (62.83185307179586 - w) / 62.83185307179586
    torque = 2 * 60.0 * 0.12 * slip / (slip * slip + 0.12 * 0.12)
    return np.array([w, (torque - (30.0 * p1 * p2 + 15.0 * q1 * q2) * w * w) / inertia])


# The train: y = (phi, phi' / SHAFT, M / TORQUE, then q / TRAIN_Q, q' / (TRAIN_Q TRAIN_W0) of each follower).
SHAFT, TORQUE, TRAIN_Q, TRAIN_W0, J0 = 60.0, 10.0, 1e-3, 300.0, 0.08
MASSES = (3.0, 5.0, 1.5)
STIFFNESSES = (426366.91012706014, 399718.978244119, 378992.80900183134)
DAMPINGS = (45.238934211693014, 84.82300164692441, 30.159289474462014)
STROKES = (0.06, 0.04, -0.08)


@njit
def kloss(w):
    slip = (62.83185307179586 - w) / 62.83185307179586
    return 2 * 12.0 * 0.15 * slip / (slip * slip + 0.15 * 0.15)


@njit
def pull(y, j):
    return STIFFNESSES[j] * TRAIN_Q * y[3 + 2 * j] + DAMPINGS[j] * TRAIN_Q * TRAIN_W0 * y[4 + 2 * j]


@njit
def shaft_torque(y, followers, s, c):
    """The torque of the motor and of elastic outputs."""
    torque = TORQUE * y[2]
    for j in range(followers):
        torque += u1(-c if j == 1 else s, STROKES[j]) * pull(y, j)
    return torque


@njit
def train_rates(y, f, followers, s, c, acceleration):
    w = SHAFT * y[1]
    f[0], f[1], f[2] = w, acceleration / SHAFT, (kloss(w) / TORQUE - y[2]) / 0.01
    for j in range(followers):
        x2 = u2(s if j == 1 else c, STROKES[j]) * w * w + u1(-c if j == 1 else s, STROKES[j]) * acceleration
        f[3 + 2 * j] = TRAIN_W0 * y[4 + 2 * j]
        f[4 + 2 * j] = -(pull(y, j) / MASSES[j] + x2) / (TRAIN_Q * TRAIN_W0)


@njit
def train(t, y):
    s, c, f = math.sin(y[0]), math.cos(y[0]), np.empty(9)
    train_rates(y, f, 3, s, c, shaft_torque(y, 3, s, c) / J0)
    return f


def train_start(states):
    return [0.0, 0.5 / SHAFT, kloss(0.5) / TORQUE] + [0.0] * (states - 3)


# Right-hand side, compared states, their scale, start, corner of the motion [ms].
SMOOTH = {
    0: (elastic_output, [0, 1], [Q, Q * W0], [0.0, 0.0], 0),
    1: (elastic_shaft, [0, 1], [0.1, 20.0], [0.0, 0.0], 0),
    3: (rigid_machine, [0, 1], [1.0, 1.0], [0.0, 0.5], 0),
    4: (ramp, [0, 1], [Q, Q * W0], [0.0, 0.0], 5000),
    5: (train, [1, 3], [SHAFT, TRAIN_Q], train_start(9), 0),
}


X, W, S = 0.01, 251.32741228718345, 1e-4
C, M1, M2, W5 = 505323.74533577514, 2.0, 8.0, 31.41592653589793


@njit
def flank(t, side):
    return u0(math.cos(W5 * t), 0.02) + (0.0 if side > 0 else S)


@njit
def contact_rate(t, y, side):
    return np.array([W * y[1], C / M2 / W * (flank(t, side) / X - y[0])])


@njit
def free_rate(t, y):
    q = C / W * (y[0] - y[2])
    return np.array([W * y[1], -q / M2, W * y[3], q / M1])


@njit
def force(t, y, side):
    return side * (M1 * u2(math.cos(W5 * t), 0.02) * W5 * W5 - C * (y[0] * X - flank(t, side)))


@njit
def gap(t, y, side):
    return side * (y[2] * X - flank(t, side))


class Backlash:
    """y = (x2, v2 / W, x1, v1 / W) / X, in contact without x1, v1."""

    bound = 2
    contact_rate, free_rate = staticmethod(contact_rate), staticmethod(free_rate)
    force, gap = staticmethod(force), staticmethod(gap)

    @staticmethod
    def start():
        side = -1 if u2(1.0, 0.02) < 0 else 1
        return np.array([flank(0.0, side) / X, 0.0]), side

    @staticmethod
    def on_flank(t, y, side):
        """The state with m1 on the flank."""
        return np.array([y[0], y[1], flank(t, side) / X, u1(math.sin(W5 * t), 0.02) * W5 / (X * W)])

    @staticmethod
    def impact(t, y, side):
        return Backlash.on_flank(t, y, side)

    @staticmethod
    def outputs(t, y, side):
        """(x1, x2) over columns of y."""
        return [[flank(s, side) for s in t] if side else y[2] * X, y[0] * X]


TRAIN_X, TRAIN_V, TRAIN_S = 0.04, 20.0, 1e-4
TRAIN_C, TRAIN_D, TRAIN_M1, TRAIN_M2 = 378992.80900183134, 75.39822368615505, 0.5, 1.5


@njit
def train_flank(c, side):
    return u0(c, -0.08) + (0.0 if side > 0 else TRAIN_S)


@njit
def train_spring(y, x1, v1):
    """The force of m1 on m2."""
    return TRAIN_C * (x1 - TRAIN_X * y[7]) + TRAIN_D * (v1 - TRAIN_V * y[8])


@njit
def train_with_spring(y, f, s, c, acceleration, spring):
    train_rates(y, f, 2, s, c, acceleration)
    f[7], f[8] = TRAIN_V / TRAIN_X * y[8], spring / (TRAIN_M2 * TRAIN_V)


@njit
def train_contact_rate(t, y, side):
    s, c, w, f = math.sin(y[0]), math.cos(y[0]), SHAFT * y[1], np.empty(9)
    d1, d2 = u1(s, -0.08), u2(c, -0.08)
    spring = train_spring(y, train_flank(c, side), d1 * w)
    torque = shaft_torque(y, 2, s, c) - d1 * (spring + TRAIN_M1 * d2 * w * w)
    train_with_spring(y, f, s, c, torque / (J0 + TRAIN_M1 * d1 * d1), spring)
    return f


@njit
def train_free_rate(t, y):
    s, c, f = math.sin(y[0]), math.cos(y[0]), np.empty(11)
    spring = train_spring(y, TRAIN_X * y[9], TRAIN_V * y[10])
    train_with_spring(y, f, s, c, shaft_torque(y, 2, s, c) / J0, spring)
    f[9], f[10] = TRAIN_V / TRAIN_X * y[10], -spring / (TRAIN_M1 * TRAIN_V)
    return f


@njit
def train_force(t, y, side):
    s, c, w = math.sin(y[0]), math.cos(y[0]), SHAFT * y[1]
    d1, d2 = u1(s, -0.08), u2(c, -0.08)
    spring = train_spring(y, train_flank(c, side), d1 * w)
    alone = shaft_torque(y, 2, s, c) / J0
    return side * (TRAIN_M1 * (d2 * w * w + d1 * alone) + spring) / (1 + TRAIN_M1 * d1 * d1 / J0)


@njit
def train_gap(t, y, side):
    return side * (TRAIN_X * y[9] - train_flank(math.cos(y[0]), side))


class TrainBacklash:
    """y = (the shaft and two outputs, x2 / TRAIN_X, v2 / TRAIN_V), between the flanks x1 / TRAIN_X, v1 / TRAIN_V, too."""

    bound = 9
    contact_rate, free_rate = staticmethod(train_contact_rate), staticmethod(train_free_rate)
    force, gap = staticmethod(train_force), staticmethod(train_gap)

    @staticmethod
    def start():
        y = TrainBacklash.on_flank(0.0, np.array(train_start(9)), 1)
        for side in (1, -1):
            y = TrainBacklash.on_flank(0.0, y, side)
            y[7:9] = y[9:11]
            if train_force(0.0, y, side) > 0:
                return y[:9], side
        return y, 0

    @staticmethod
    def on_flank(t, y, side):
        speed = u1(math.sin(y[0]), -0.08) * SHAFT * y[1]
        return np.concatenate([y[:9], [train_flank(math.cos(y[0]), side) / TRAIN_X, speed / TRAIN_V]])

    @staticmethod
    def impact(t, y, side):
        s, c = math.sin(y[0]), math.cos(y[0])
        d1, y = u1(s, -0.08), y.copy()
        approach = TRAIN_V * y[10] - d1 * SHAFT * y[1]
        jump = d1 * approach / (1 / TRAIN_M1 + d1 * d1 / J0) / J0
        y[1] += jump / SHAFT
        for j in range(2):
            y[4 + 2 * j] -= u1(-c if j == 1 else s, STROKES[j]) * jump / (TRAIN_Q * TRAIN_W0)
        return TrainBacklash.on_flank(t, y, side)

    @staticmethod
    def outputs(t, y, side):
        return [[train_flank(math.cos(phi), side) for phi in y[0]] if side else y[9] * TRAIN_X, y[7] * TRAIN_X]


DRIVES = {2: Backlash, 6: TrainBacklash}


def backlash(drive, method, tolerance, count, times):
    out = np.zeros((count, 2))
    y, side = drive.start()
    t, done, left, armed, end = 0.0, 0, 0, 0.0, times[-1]

    def event(function):
        function.terminal, function.direction = True, -1
        return function

    for _ in range(20000):
        if done >= count or t >= end:
            return out
        if side:
            rate, guards = (lambda t, y: drive.contact_rate(t, y, side)), [event(lambda t, y: drive.force(t, y, side))]
        else:
            # A flight begins with a gap of zero that grows with the cube of time: its sign is noise at first.
            def guard(s):
                return event(lambda t, y: 1.0 if s == left and t < armed else drive.gap(t, y, s))

            rate, guards = drive.free_rate, [guard(1), guard(-1)]
        ahead = times[done:]
        solution = solve_ivp(
            rate, (t, end), y, method, ahead, events=guards, rtol=tolerance, atol=tolerance, dense_output=False
        )
        n = len(solution.t)
        if n:
            out[done : done + n] = np.transpose(drive.outputs(solution.t, solution.y, side))
        done += n
        if solution.status != 1:
            return out if solution.status == 0 else None
        hit = [k for k, e in enumerate(solution.t_events) if e.size][0]
        t, y = solution.t_events[hit][0], solution.y_events[hit][0]
        armed = t + 1e-4
        if side:
            left, y, side = side, drive.on_flank(t, y, side), 0
        else:
            left = 1 if hit == 0 else -1
            y = drive.impact(t, y, left)
            if drive.force(t, y, left) > 0:
                side, y = left, y[: drive.bound]
    return None


def solve(method, work, tolerance, count):
    """(outputs or None, CPU seconds)."""
    name = METHODS[method].split()[1]
    # scipy refuses less and says so.
    tolerance = max(tolerance, 2.3e-14)
    times = np.arange(1, count + 1) * 1e-3
    start = time.process_time()
    if work in DRIVES:
        out = backlash(DRIVES[work], name, tolerance, count, times)
        return out, time.process_time() - start
    rate, outputs, scale, y, corner = SMOOTH[work]
    pieces = [(0, corner), (corner, count)] if corner else [(0, count)]
    parts = []
    for first, last in pieces:
        span = (first * 1e-3, last * 1e-3)
        solution = solve_ivp(rate, span, y, name, times[first:last], rtol=tolerance, atol=tolerance)
        if solution.status != 0 or len(solution.t) != last - first:
            return None, time.process_time() - start
        parts.append(solution.y[outputs].T)
        y = solution.y[:, -1]
    out = np.vstack(parts) * scale
    return out, time.process_time() - start


def compile_all():
    """numba compiles at the first call, which is not counted."""
    for rate, _, _, y, _ in SMOOTH.values():
        rate(0.0, np.array(y))
    for drive in DRIVES.values():
        y, _ = drive.start()
        y = drive.impact(0.0, drive.on_flank(0.0, y, 1), 1)
        drive.contact_rate(0.0, y[: drive.bound], 1), drive.free_rate(0.0, y), drive.gap(0.0, y, 1)
        drive.force(0.0, y, 1)
