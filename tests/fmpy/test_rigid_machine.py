"""The rigid machine against DOP853, its energy balance and the published steady state of the loom."""

import math

import numpy as np
import pytest

import reference


def machine(package, load=lambda t: 0.0, **changes):
    p = package.parameters() | changes
    followers = []
    while f"follower[{len(followers) + 1}].m" in p:
        j = len(followers) + 1
        followers.append((p[f"follower[{j}].m"], reference.Series.of(package, f"follower[{j}].cam")))
    torque = lambda w: reference.kloss(w, p["motor.M_k"], p["motor.s_k"], p["motor.w_s"])
    return p, reference.rigid_machine(p["J0"], followers, torque, load)


@pytest.mark.parametrize("size", [1e-4, 1e-3, 1e-2, 1e-1, 1.2])
def test_run_up_from_standstill(fmu, size):
    package = fmu("rapier_loom")
    start = {"start.mode": 1, "phi_start": 0.0, "w_start": 0.0}
    p, rhs = machine(package)
    count = max(1, min(2000, round(1.2 / size)))
    expected = reference.integrate(rhs, [0.0, 0.0], np.linspace(0, count * size, 101))[-1]
    with package.unit() as unit:
        unit.initialise(values=start)
        for _ in range(count):
            unit.step(size)
        phi, w = unit.get("phi", "w")
    assert abs(phi - expected[0]) <= 1e-9 * abs(expected[0]) + 1e-12
    assert abs(w - expected[1]) <= 1e-9 * p["motor.w_s"]


@pytest.mark.parametrize("values", [{}, {"motor.w_s": -40.0}])
@pytest.mark.parametrize("size", [1e-3, 1.0])
def test_table_and_cycle_on_a_motor_with_lag(fmu, values, size):
    """Forwards and backwards, from another time than zero; 42 breakpoints per turn lie within the long step."""
    package = fmu("machine_table")
    p = package.parameters() | values
    laws = [(p["follower[1].m"], reference.Table()), (p["follower[2].m"], reference.Cycle())]

    def rhs(t, state):
        phi, w, torque = state
        _, acceleration = reference.rigid_machine(p["J0"], laws, lambda _: torque, lambda _: 0.0)(t, [phi, w])
        kloss = reference.kloss(w, p["motor.M_k"], p["motor.s_k"], p["motor.w_s"])
        return [w, acceleration, (kloss - torque) / p["motor.T_el"]]

    expected = reference.integrate(rhs, [0.0, 0.0, 0.0], np.linspace(100.0, 101.0, 41), longest=1e-3)
    with package.unit() as unit:
        unit.initialise(start_time=100.0, values=values)
        for n in range(round(1.0 / size)):
            unit.step_to(100.0 + size * (n + 1))
        got = np.array(unit.get("phi", "w", "M_an"))
    assert np.all(np.abs(got - expected[-1]) <= 1e-9 * np.abs(expected).max(axis=0))


def test_microsecond_steps(fmu):
    package = fmu("rapier_loom")
    p, rhs = machine(package)
    expected = reference.integrate(rhs, [0.0, 30.0], [0.0, 0.02])[-1]
    with package.unit() as unit:
        unit.initialise(values={"start.mode": 1, "phi_start": 0.0, "w_start": 30.0})
        for n in range(20_000):
            unit.time = n * 1e-6
            unit.step(1e-6)
        got = np.array(unit.get("phi", "w"))
    assert np.all(np.abs(got - expected) <= 1e-9 * np.abs(expected))


def test_through_reversal_under_load(fmu):
    """A load above the breakdown torque drives the machine backwards."""
    package = fmu("rapier_loom")
    load = 400.0
    p, rhs = machine(package, load=lambda t: load)
    expected = reference.integrate(rhs, [0.0, 20.0], np.linspace(0, 0.8, 201))
    assert expected[-1, 1] < -5.0
    for size in (1e-3, 0.8):
        with package.unit() as unit:
            unit.initialise(values={"start.mode": 1, "phi_start": 0.0, "w_start": 20.0, "tau": load})
            for _ in range(round(0.8 / size)):
                unit.step(size)
            phi, w = unit.get("phi", "w")
        assert abs(phi - expected[-1, 0]) <= 1e-9 * np.abs(expected[:, 0]).max()
        assert abs(w - expected[-1, 1]) <= 1e-9 * np.abs(expected[:, 1]).max()


def test_the_published_steady_state_of_the_loom(fmu):
    """T = 0.12004168324406 s, speed between 49.683 and 55.776 rad/s."""
    package = fmu("rapier_loom")
    period = 0.12004168324406
    with package.unit() as unit:
        unit.initialise(values={"start.mode": 2})
        phi, w = unit.get("phi", "w")
        speeds = []
        for i in range(2000):
            unit.step_to(period * (i + 1) / 2000)
            speeds.append(unit.get("w"))
        assert abs(unit.get("phi") - phi - 2 * math.pi) <= 2e-11
        assert abs(unit.get("w") - w) <= 1e-9 * w
    assert abs(min(speeds) - 49.682586) < 2e-4 and abs(max(speeds) - 55.776336) < 2e-4


def test_energy_balance(fmu):
    """The change of E = J w^2 / 2 is the integral of (M_an - tau) w over time, Gauss-Legendre over short cells."""
    package = fmu("rapier_loom")
    nodes, weights = np.polynomial.legendre.leggauss(10)
    cell = 2e-3
    work = scale = 0.0
    with package.unit() as unit:
        unit.initialise(values={"start.mode": 1, "phi_start": 0.0, "w_start": 1.0})
        start = unit.get("E")
        for i in range(300):
            for node, weight in zip(nodes, weights):
                unit.step_to(cell * (i + (1 + node) / 2))
                torque, w = unit.get("M_an", "w")
                work += weight * cell / 2 * torque * w
                scale += weight * cell / 2 * abs(torque * w)
        unit.step_to(300 * cell)
        assert abs(unit.get("E") - start - work) <= 1e-9 * scale


def test_without_a_motor_the_energy_is_constant(fmu):
    package = fmu("machine_free")
    with package.unit() as unit:
        unit.initialise()
        start = unit.get("E")
        for _ in range(500):
            unit.step(1e-2)
            j, w, energy = unit.get("J", "w", "E")
            assert abs(energy - start) <= 1e-10 * start
            assert math.isclose(energy, j * w * w / 2, rel_tol=1e-14)


def test_torque_as_input(fmu):
    package = fmu("machine_torque_input")
    p = package.parameters()
    followers = [(p["follower[1].m"], reference.Series.of(package, "follower[1].cam"))]
    drive = lambda t: 5.0 + 4.0 * t
    rhs = reference.rigid_machine(p["J0"], followers, lambda w: 0.0, lambda t: -drive(t))
    start = [p["phi_start"], p["w_start"]]
    expected = reference.integrate(rhs, start, np.linspace(0, 1.0, 101))
    reference_of = package.variables["M_an"].valueReference
    for size in (1e-2, 0.25):
        with package.unit() as unit:
            unit.set(M_an=5.0)
            unit.initialise()
            for _ in range(round(1.0 / size)):
                unit.set(M_an=drive(unit.time))
                unit.slave.setRealInputDerivatives([reference_of], [1], [4.0])
                unit.step(size)
            got = np.array(unit.get("phi", "w"))
        assert np.all(np.abs(got - expected[-1]) <= 1e-9 * np.abs(expected).max(axis=0))


def test_the_tolerance_buys_accuracy(fmu):
    package = fmu("rapier_loom")
    p, rhs = machine(package)
    expected = reference.integrate(rhs, [0.0, 0.0], np.linspace(0, 1.2, 121))
    errors = []
    for tolerance in (1e-2, 1e-5, 1e-8, 1e-12):
        with package.unit() as unit:
            values = {"start.mode": 1, "phi_start": 0.0, "w_start": 0.0, "solver.tolerance": tolerance}
            unit.initialise(values=values)
            unit.step(1.2)
            got = np.array(unit.get("phi", "w"))
        errors.append(np.max(np.abs(got - expected[-1]) / np.abs(expected).max(axis=0)))
        # The last digits of the reference are beyond its own tolerance.
        assert errors[-1] <= max(tolerance, 1e-11), errors
    assert errors[0] > 10 * errors[1] > 10 * errors[2], errors


def test_energy_changes_by_the_work_of_the_torques(fmu):
    """Coarse equal steps do not depend on the communication step, by which the work of the outputs is summed here."""
    package = fmu("rapier_loom")
    missed = []
    for method in ({"solver.method": 2, "solver.step_size": 0.015}, {"solver.method": 1}):
        with package.unit() as unit:
            unit.initialise(values={"start.mode": 1, "phi_start": 0.3, "w_start": 10.0} | method)
            size, count = 1e-4, 4000
            rows = [unit.get("w", "M_an", "E")]
            for _ in range(count):
                unit.step(size)
                rows.append(unit.get("w", "M_an", "E"))
        w, torque, energy = np.array(rows).T
        power = w * torque
        work = size / 3 * (power[0] + 4 * power[1:-1:2].sum() + 2 * power[2:-1:2].sum() + power[-1])
        missed.append(abs(energy[-1] - energy[0] - work) / energy.max())
    assert missed[0] > 1e-10 and missed[1] < 1e-12
