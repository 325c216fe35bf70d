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


# Right-hand side, scale, start, corner of the motion [ms].
SMOOTH = {
    0: (elastic_output, [Q, Q * W0], [0.0, 0.0], 0),
    1: (elastic_shaft, [0.1, 20.0], [0.0, 0.0], 0),
    3: (rigid_machine, [1.0, 1.0], [0.0, 0.5], 0),
    4: (ramp, [Q, Q * W0], [0.0, 0.0], 5000),
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


def backlash(method, tolerance, count, times):
    out = np.zeros((count, 2))
    side = -1 if u2(1.0, 0.02) < 0 else 1
    t, y, done, left, armed = 0.0, np.array([flank(0.0, side) / X, 0.0]), 0, 0, 0.0
    end = times[-1]

    def event(function):
        function.terminal, function.direction = True, -1
        return function

    for _ in range(20000):
        if done >= count or t >= end:
            return out
        if side:
            rate, guards = (lambda t, y: contact_rate(t, y, side)), [event(lambda t, y: force(t, y, side))]
        else:
            # A flight begins with a gap of zero that grows with the cube of time: its sign is noise at first.
            def guard(s):
                return event(lambda t, y: 1.0 if s == left and t < armed else gap(t, y, s))

            rate, guards = free_rate, [guard(1), guard(-1)]
        ahead = times[done:]
        solution = solve_ivp(
            rate, (t, end), y, method, ahead, events=guards, rtol=tolerance, atol=tolerance, dense_output=False
        )
        n = len(solution.t)
        if n:
            at = solution.t
            out[done : done + n, 1] = solution.y[0] * X
            out[done : done + n, 0] = [flank(s, side) for s in at] if side else solution.y[2] * X
        done += n
        if solution.status != 1:
            return out if solution.status == 0 else None
        hit = [k for k, e in enumerate(solution.t_events) if e.size][0]
        t, y = solution.t_events[hit][0], solution.y_events[hit][0]
        speed = u1(math.sin(W5 * t), 0.02) * W5 / (X * W)
        if side:
            left, armed, y, side = side, t + 1e-4, np.array([y[0], y[1], flank(t, side) / X, speed]), 0
        else:
            reached = 1 if hit == 0 else -1
            left, armed = reached, t + 1e-4
            y = np.array([y[0], y[1], flank(t, reached) / X, speed])
            if force(t, y, reached) > 0:
                side, y = reached, y[:2]
    return None


def solve(method, work, tolerance, count):
    """(outputs or None, CPU seconds)."""
    name = METHODS[method].split()[1]
    # scipy refuses less and says so.
    tolerance = max(tolerance, 2.3e-14)
    times = np.arange(1, count + 1) * 1e-3
    start = time.process_time()
    if work == 2:
        out = backlash(name, tolerance, count, times)
        return out, time.process_time() - start
    rate, scale, y, corner = SMOOTH[work]
    pieces = [(0, corner), (corner, count)] if corner else [(0, count)]
    parts = []
    for first, last in pieces:
        span = (first * 1e-3, last * 1e-3)
        solution = solve_ivp(rate, span, y, name, times[first:last], rtol=tolerance, atol=tolerance)
        if solution.status != 0 or len(solution.t) != last - first:
            return None, time.process_time() - start
        parts.append(solution.y.T)
        y = solution.y[:, -1]
    out = np.vstack(parts) * scale
    return out, time.process_time() - start


def compile_all():
    """numba compiles at the first call, which is not counted."""
    for rate, _, y, _ in SMOOTH.values():
        rate(0.0, np.array(y))
    y = np.array([0.0, 0.0, 0.0, 0.0])
    contact_rate(0.0, y, 1), free_rate(0.0, y), force(0.0, y, 1), gap(0.0, y, 1)
