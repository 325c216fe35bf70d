"""A machine and a drive with impacts, connected by a master: `tau_mean` brings the momentum of the impacts into the machine,
`tau` does not, however small the step. Both limits against an event-driven integration of the whole."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import reference

# A shaft of small inertia, a cam of 90 mm and 3 mm of clearance: m1 U'^2 is a hundredth of the inertia at most.
MACHINE = {"J0": 0.2, "follower[1].m": 0.0, "follower[2].m": 0.0, "motor.M_k": 10.0, "start.mode": 1, "phi_start": 0.3, "w_start": 50.0}
DRIVE = {"b": 400.0, "s": 3e-3}
ENLARGED = 4.0
END = 0.1


class Whole:
    """Shaft and drive as one: m1 on a flank moves with the shaft, an impact acts on both. Contact, flight and impact by the
    equations of motion of the two masses on a shaft of the inertia J:

    J w' = M - U' F_K, m1 x1'' = F_K - S, m2 x2'' = S, S = c (x1 - x2) + b (x1' - x2')
    impact: x1' rises by P/m1, w by -U' P/J, P = -(1 + e) z' / (1/m1 + U'^2/J), z' = x1' - U' w
    """

    def __init__(self, p, law, inertia, torque, impulses=True):
        self.m1, self.m2, self.c, self.b, self.s, self.e = (p[name] for name in ("m1", "m2", "c", "b", "s", "e"))
        self.law, self.inertia, self.torque, self.impulses = law, inertia, torque, impulses

    def cam(self, phi):
        return [self.law.derivative(phi, order) for order in range(3)]

    def place(self, flank):
        return 0.0 if flank > 0 else self.s

    def contact(self, flank, state):
        """The accelerations of shaft and m2, and the force of the flank on m1."""
        phi, w, x2, v2 = state
        u, u1, u2 = self.cam(phi)
        spring = self.c * (u + self.place(flank) - x2) + self.b * (u1 * w - v2)
        a = (self.torque(w) - self.m1 * u1 * u2 * w * w - u1 * spring) / (self.inertia + self.m1 * u1 * u1)
        return a, spring / self.m2, self.m1 * (u2 * w * w + u1 * a) + spring

    def presses(self, flank, state):
        return flank * self.contact(flank, state)[2]

    def until(self, event, rhs, state, t, longest):
        """Integrates to END or the first event that becomes negative; its number."""
        for f in event:
            f.terminal, f.direction = True, -1
        solution = solve_ivp(rhs, (t, END), state, method="DOP853", rtol=1e-11, atol=1e-13, events=event, max_step=longest)
        assert solution.success, solution.message
        found = [n for n, times in enumerate(solution.t_events) if len(times)]
        return solution.t[-1], solution.y[:, -1], found[0] if found else None

    def on_flank(self, flank, t, state):
        """Up to the release; the state of the flight, where there is one."""

        def rhs(_, y):
            a, far, _ = self.contact(flank, y)
            return [y[1], a, y[3], far]

        t, (phi, w, x2, v2), released = self.until([lambda _, y: self.presses(flank, y)], rhs, state, t, 1e-3)
        u, u1, _ = self.cam(phi)
        return t, [phi, w, u + self.place(flank), u1 * w, x2, v2], released is not None

    def in_flight(self, t, state):
        """Up to the impact; the flank that is hit, 0 for none."""

        def rhs(_, y):
            _, w, x1, v1, x2, v2 = y
            spring = self.c * (x1 - x2) + self.b * (v1 - v2)
            return [w, self.torque(w) / self.inertia, v1, -spring / self.m1, v2, spring / self.m2]

        # A gap that opens from zero is rounded to either side of it.
        gap = lambda y: y[2] - self.law.derivative(y[0], 0)
        events = [lambda _, y: gap(y) + 1e-15, lambda _, y: self.s - gap(y) + 1e-15]
        t, state, hit = self.until(events, rhs, state, t, 2e-4)
        return t, list(state), 0 if hit is None else (1, -1)[hit]

    def impact(self, state):
        phi, w, _, v1, *_ = state
        _, u1, _ = self.cam(phi)
        mobility = 1 / self.m1 + (u1 * u1 / self.inertia if self.impulses else 0.0)
        impulse = -(1 + self.e) * (v1 - u1 * w) / mobility
        state[3] += impulse / self.m1
        if self.impulses:
            state[1] -= u1 * impulse / self.inertia

    def run(self, phi, w):
        """The speed of the shaft at END from rest relative to the cam, and the number of impacts."""
        u, u1, _ = self.cam(phi)
        flank, t, impacts = 1, 0.0, 0
        on = [phi, w, u, u1 * w]
        if self.presses(flank, on) < 0:
            flank, on[2] = -1, u + self.s
        while True:
            if flank:
                t, state, released = self.on_flank(flank, t, on)
                flank = 0
                if not released:
                    return state[1], impacts
            t, state, hit = self.in_flight(t, state)
            if not hit:
                return state[1], impacts
            impacts += 1
            self.impact(state)
            on = state[:2] + state[4:]
            if self.e == 0 and self.presses(hit, on) > 0:
                flank = hit


def connected(machine, drive, cam, torque, count):
    """The speed at END of both FMUs in `count` steps, each given what the other was at their beginning."""
    size = END / count
    with machine.unit() as shaft, drive.unit() as load:
        shaft.initialise(values=MACHINE)
        move = lambda: load.set(**dict(zip(("phi", "w", "a"), shaft.get("phi", "w", "a"))))
        move()
        load.initialise(values=DRIVE | cam)
        for _ in range(count):
            shaft.set(tau=load.get(torque))
            move()
            shaft.step(size)
            load.step(size)
        return shaft.get("w")


@pytest.fixture(scope="module")
def limits(fmu):
    machine, drive = fmu("rapier_loom"), fmu("backlash_input")
    p = machine.parameters() | MACHINE
    cam = {name: ENLARGED * value for name, value in drive.parameters().items() if name.startswith("cam.")}
    law = reference.Series.of(drive)
    law = reference.Series([ENLARGED * a for a in law.a], [ENLARGED * b for b in law.b])
    torque = lambda w: reference.kloss(w, p["motor.M_k"], p["motor.s_k"], p["motor.w_s"])
    ends = {}
    for impulses in (True, False):
        whole = Whole(drive.parameters() | DRIVE, law, p["J0"], torque, impulses)
        ends[impulses], impacts = whole.run(p["phi_start"], p["w_start"])
        assert impacts >= 3
    return machine, drive, cam, ends


def test_the_mean_torque_brings_the_impacts_into_the_machine(limits):
    machine, drive, cam, ends = limits
    errors = [abs(connected(machine, drive, cam, "tau_mean", count) - ends[True]) for count in (500, 2000, 8000)]
    # Held inputs have the order 1.
    assert errors[0] < 4e-3 and errors[1] < errors[0] / 3 and errors[2] < errors[1] / 3, errors


def test_the_torque_between_impacts_leaves_them_out_however_small_the_step(limits):
    machine, drive, cam, ends = limits
    # What the impacts take from the shaft or bring to it is missing for good: 0.4 of 52 rad/s.
    assert ends[True] - ends[False] > 0.4
    for count, bound in ((500, 4e-3), (8000, 4e-4)):
        w = connected(machine, drive, cam, "tau", count)
        assert abs(w - ends[False]) < bound, (count, w, ends)
