"""The parametric drive, of series and as parallel crank, against DOP853 on equations written anew."""

import math

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import reference
from extremes import truth

SECOND = {"crank_double": "shared", "rod_drive_both_sides": "own"}
CONSTANT = ["parametric_series", "mathieu", "crank_double", "rod_drive", "rod_drive_both_sides"]


def turning(p):
    return lambda t: (p["drive.phi_start"] + p["drive.w"] * t, p["drive.w"], 0.0)


def expected(package, changes, times):
    """(q, der q) at the times, and their size: the largest so far."""
    law = reference.Parametric(package, changes, SECOND.get(package.path.stem))
    p = law.p
    start = [p["start.q"], p["start.q_dot"]] if p["start.mode"] == 2 else [0.0, 0.0]
    _, _, stiffness, _ = law.at(1.0)
    size = max(abs(start[0]), 1e-3)
    rate = math.sqrt(abs(stiffness) / law.at(1.0)[0])
    states = truth.integrate(law.rhs(turning(p)), start, [0.0, *times], [size, size * rate])
    return states[1:], np.maximum.accumulate(np.abs(states), axis=0)[1:]


def initialised(package, changes):
    unit = package.unit()
    return unit.initialise(values={k: int(v) if k == "start.mode" else v for k, v in changes.items()})


@pytest.mark.parametrize("name", CONSTANT)
@pytest.mark.parametrize("size", [1e-3, 1e-2, 0.1, 3.0])
def test_constant_speed(fmu, name, size):
    package = fmu(name)
    turn = 2 * math.pi / package.start("drive.w")
    count = max(1, min(1000, round(3 * turn / (size * turn))))
    times = size * turn * np.arange(1, count + 1)
    states, scale = expected(package, {}, times)
    with initialised(package, {}) as unit:
        for time, state, largest in zip(times, states, scale):
            unit.step_to(time)
            assert np.all(np.abs(np.array(unit.get("q", "der(q)")) - state) <= 1e-9 * largest)


HUNDRED = {
    "inside the first tongue of a cosine": ("mathieu", {}),
    "on its boundary": ("mathieu", {"drive.w": 1.84756}),
    "outside": ("mathieu", {"drive.w": 1.5}),
    "backwards, damped": ("mathieu", {"drive.w": -2.0, "b.a[0]": 0.05}),
    "inside the second tongue": ("mathieu", {"drive.w": 0.99}),
    "all coefficients vary": ("parametric_series", {"start.mode": 2, "start.q": 0.5}),
    "and are unstable": ("parametric_series", {"drive.w": 8.9}),
    "crank inside the tongue j = 1": ("rod_drive", {"drive.w": 57.0, "b_T": 0.0}),
    "crank inside the tongue j = 2": ("rod_drive", {"drive.w": 28.5}),
    "crank outside": ("rod_drive", {}),
    "crank with a stiff rod": ("rod_drive", {"c_AB": 1e12}),
    "cranks on the same shafts": ("crank_double", {}),
    "cranks with shafts of their own": ("rod_drive_both_sides", {"drive.w": 28.5, "b_T": 0.0}),
}


def driven(package, changes, times):
    """The states at `times` and the error estimate at the end."""
    with initialised(package, changes) as unit:
        got = []
        for time in times:
            unit.step_to(time)
            got.append(unit.get("q", "der(q)"))
        return np.array(got), unit.get("solver.error_estimate")


@pytest.mark.parametrize("case", HUNDRED)
def test_a_hundred_turns_relative_to_the_growing_envelope(fmu, case):
    name, changes = HUNDRED[case]
    package = fmu(name)
    turn = 2 * math.pi / abs(changes.get("drive.w", package.start("drive.w")))
    every = [100 * turn * np.arange(1, count + 1) / count for count in (7, 1000)]
    together = np.unique(np.concatenate(every))
    truth_of_all = expected(package, changes, together)
    for times in every:
        states, scale = (values[np.searchsorted(together, times)] for values in truth_of_all)
        got, estimate = driven(package, changes, times)
        error = np.max(np.abs(got - states) / scale)
        assert error <= 1e-9, f"{error:.1e}"
        if case == "on its boundary":
            # There every error of the coefficients makes q grow, and DOP853 errs by more than the drive.
            assert error <= 1e-10
        else:
            # DOP853 at 1e-13 errs by some 1e-12 over a hundred turns itself.
            assert error <= estimate + 1e-11


@pytest.mark.parametrize("w, damping", [(2.0, 0.0), (1.84756, 0.0), (1.5, 0.0), (0.99, 0.05)])
def test_the_cosine_in_thirty_digits(fmu, w, damping):
    package = fmu("mathieu")
    times = 2 * math.pi / w * np.array([0.37, 1.0, 7.2, 31.0, 100.0])
    with initialised(package, {"drive.w": w, "b.a[0]": damping}) as unit:
        reached, got = [], []
        for time in times:
            unit.step_to(time)
            reached.append(unit.time)
            got.append(unit.get("q", "der(q)"))
        estimate = unit.get("solver.error_estimate")
    states = reference.mathieu(damping, 0.3, w, [1.0, 0.0], reached)
    scale = np.maximum.accumulate(np.maximum(np.abs(states), [1.0, 0.0]), axis=0)
    error = np.max(np.abs(got - states) / scale)
    assert error <= 1e-11 and error <= estimate, (error, estimate)


@pytest.mark.parametrize("name", CONSTANT)
def test_the_growth_is_that_of_the_multipliers(fmu, name):
    package = fmu(name)
    for factor in (1.0, -0.63, 1.9):
        w = factor * package.start("drive.w")
        law = reference.Parametric(package, {}, SECOND.get(name))
        with initialised(package, {"drive.w": w}) as unit:
            growth = unit.get("growth")
        expected_growth = math.log(np.max(np.abs(np.linalg.eigvals(law.monodromy(w)))))
        assert abs(growth - expected_growth) <= 1e-8 * (1 + abs(expected_growth)), (growth, expected_growth)


def test_growth_until_overflow_is_a_clear_error(fmu):
    with initialised(fmu("mathieu"), {}) as unit:
        assert any("parametrically unstable" in text and category == "logSolver" for _, category, text in unit.log)
        with pytest.raises(FMICallException):
            for _ in range(10_000):
                unit.step(1.0)
        assert "q grows without bound" in unit.log[-1][2] and "grow by exp(0.2" in unit.log[-1][2]


@pytest.mark.parametrize("name", ["parametric_series", "rod_drive", "rod_drive_both_sides"])
def test_the_steady_state_is_periodic(fmu, name):
    package = fmu(name)
    turn = 2 * math.pi / package.start("drive.w")
    with initialised(package, {"start.mode": 3}) as unit:
        start = np.array(unit.get("q", "der(q)"))
        for n in range(1, 11):
            unit.step_to(n * turn)
            assert np.allclose(unit.get("q", "der(q)"), start, rtol=1e-9, atol=1e-10 * np.abs(start).max())


@pytest.mark.parametrize("changes, reason", [
    ({"drive.w": 57.0}, "the periodic solution is unstable, free vibrations grow by exp(0.7"),
    ({"drive.w": 0.0, "drive.phi_start": 0.0}, "with a stiffness of 0"),
])
def test_a_steady_state_that_is_none_is_refused(fmu, changes, reason):
    with fmu("rod_drive").unit() as unit:
        with pytest.raises(FMICallException):
            unit.initialise(values=changes | {"start.mode": 3})
        assert reason in unit.log[-1][2], unit.log[-1][2]


@pytest.mark.parametrize("name", ["crank_input", "parametric_input"])
@pytest.mark.parametrize("size", [1e-3, 1e-2, 0.5])
@pytest.mark.parametrize("method", [1, 2])
def test_ramped_inputs(fmu, name, size, method):
    package = fmu(name)

    def ramp(t):
        return 0.4 + 12.0 * t + 15.0 * t * t, 12.0 + 30.0 * t, 30.0

    law = reference.Parametric(package)
    changes = {"start.mode": 2, "start.q": 1e-3, "solver.method": method}
    start = [1e-3, 0.0]
    states = truth.integrate(law.rhs(ramp), start, np.linspace(0.0, 1.0, 201), [1e-3, 1e-1])
    with package.unit() as unit:
        unit.set(**dict(zip(("phi", "w", "a"), ramp(0.0))))
        unit.initialise(values=changes)
        for _ in range(round(1.0 / size)):
            unit.set(**dict(zip(("phi", "w", "a"), ramp(unit.time))))
            unit.step(size)
        got, estimate = np.array(unit.get("q", "der(q)")), unit.get("solver.error_estimate")
    error = np.max(np.abs(got - states[-1]) / np.abs(states).max(axis=0))
    assert error <= (1e-9 if method == 1 else 1e-5), f"{error:.1e}"
    assert error <= estimate + 1e-11


def test_where_inputs_jump_the_driven_side_stays(fmu):
    package = fmu("crank_input")
    with package.unit() as unit:
        unit.set(phi=0.5, w=10.0)
        unit.initialise()
        unit.step(0.01)
        unit.set(phi=0.6, w=10.0)
        psi, speed = unit.get("psi", "der(psi)")
        unit.set(phi=0.9, w=-5.0)
        assert np.allclose(unit.get("psi", "der(psi)"), [psi, speed], rtol=1e-14)


def test_the_energy_of_the_crank_comes_from_the_drive(fmu):
    """d/dt (J psi'^2/2 + c q^2/2) = (tau + tau_parametric) w - b q'^2 + f psi', by Gauss-Legendre quadrature."""
    package = fmu("rod_drive")
    p = package.parameters()
    law = reference.Parametric(package)
    w = p["drive.w"]
    nodes, weights = np.polynomial.legendre.leggauss(8)

    def energy(unit):
        speed, q, c = unit.get("der(psi)", "q", "stiffness")
        return 0.5 * p["J"] * speed**2 + 0.5 * c * q**2

    with initialised(package, {"start.mode": 2, "start.q": 2e-3}) as unit:
        start, work, total = energy(unit), 0.0, 0.0
        ends = np.linspace(0.0, 0.5, 201)
        for a, b in zip(ends, ends[1:]):
            for x, weight in zip(nodes, weights):
                unit.step_to(0.5 * (a + b) + 0.5 * (b - a) * x)
                tau, second, rate, speed = unit.get("tau", "tau_parametric", "der(q)", "der(psi)")
                load = law.at(w * unit.time)[3]
                power = (tau + second) * w - p["b_T"] * rate**2 + load * speed
                work += 0.5 * (b - a) * weight * power
                total += 0.5 * (b - a) * weight * abs(power)
        unit.step_to(0.5)
        assert abs(energy(unit) - start - work) <= 1e-9 * (start + total)


def test_outputs_follow_from_the_states(fmu):
    package = fmu("parametric_series")
    law = reference.Parametric(package)
    with initialised(package, {"start.mode": 2, "start.q": 0.5, "start.q_dot": -1.0}) as unit:
        for time in (0.0, 0.3, 7.7):
            if time:
                unit.step_to(time)
            q, v, acceleration, tau, stiffness = unit.get("q", "der(q)", "der(q,2)", "tau", "stiffness")
            m, b, c, f = law.at(law.p["drive.w"] * unit.time)
            assert math.isclose(stiffness, c, rel_tol=1e-12) and math.isclose(tau, -(c * q + b * v), rel_tol=1e-11)
            assert math.isclose(acceleration, (f + tau) / m, rel_tol=1e-11)


def test_without_mass_the_drive_is_refused_with_the_angle(fmu):
    with fmu("parametric_series").unit() as unit:
        with pytest.raises(FMICallException):
            unit.initialise(values={"m.a[2]": -4.0})
        assert "`m`: m(φ) is -" in unit.log[-1][2] and "rad (" in unit.log[-1][2]


def test_a_coarser_tolerance_is_honest(fmu):
    package = fmu("parametric_series")
    turn = 2 * math.pi / package.start("drive.w")
    times = turn * np.arange(1, 200) * 0.1
    states, scale = expected(package, {"start.mode": 2, "start.q": 1.0}, times)
    for tolerance in (1e-4, 1e-6, 1e-8):
        changes = {"start.mode": 2, "start.q": 1.0, "solver.tolerance": tolerance}
        got, estimate = driven(package, changes, times)
        error = np.max(np.abs(got - states) / scale)
        assert error <= estimate <= 10 * tolerance, (error, estimate)


@pytest.mark.parametrize("rpm, one, both, range_of_one, range_of_both", [
    (181, 0.782, -0.378, None, (19.3, 52.0)),
    (230, -0.297, -0.297, (-105, 105), (22.9, 47.0)),
    (272, 0.898, 0.497, None, None),
    (400, -0.171, -0.171, (0.0, 31.4), (25.0, 44.3)),
    (544, 0.783, -0.126, None, (25.4, 43.9)),
])
def test_the_rod_drive_shakes_where_its_readme_says(fmu, rpm, one, both, range_of_one, range_of_both):
    w = rpm * math.pi / 30
    for name, growth, span in (("rod_drive", one, range_of_one), ("rod_drive_both_sides", both, range_of_both)):
        with initialised(fmu(name), {"drive.w": w}) as unit:
            assert abs(unit.get("growth") - growth) < 6e-4
        if span is None:
            continue
        with initialised(fmu(name), {"drive.w": w, "start.mode": 3}) as unit:
            tau = []
            for i in range(1, 361):
                unit.step_to(i * 2 * math.pi / w / 360)
                tau.append(unit.get("tau") / 1e3)
        assert abs(min(tau) - span[0]) < 0.6 * 10 ** -(abs(span[0]) < 100) and abs(max(tau) - span[1]) < 0.6 * 10 ** -(span[1] < 100)
