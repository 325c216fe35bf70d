"""The elastic output against its closed form (constant speed) and against DOP853 (inputs)."""

import math

import numpy as np
import pytest

import reference

# Stiffness and speed are powers of ten, so that 5 Omega = w0 holds exactly in binary as well.
MASS, STIFFNESS, SPEED = 1.0, 1.0e6, 200.0
TURN = 2 * math.pi / SPEED


def parameters(w=SPEED, b=0.0):
    return {"m": MASS, "c": STIFFNESS, "b": b, "drive.w": w, "drive.phi_start": 0.3}


def closed(package, values, times):
    series = reference.Series.of(package)
    return reference.elastic_output_closed(
        values["m"], values["c"], values["b"], series, values["drive.w"], values["drive.phi_start"], 0.0, 0.0, times
    )


def size_of_motion(package, values, span):
    """The largest |q| and |der q|, sampled at irregular instants, since regular ones may all meet a node."""
    times = np.random.default_rng(1).uniform(0.0, span, 200)
    return np.abs(closed(package, values, times)).max(axis=0)


CRITICAL = 2 * math.sqrt(MASS * STIFFNESS)

CASES = {
    "lightly damped": parameters(b=0.03 * CRITICAL),
    "undamped": parameters(w=190.0),
    "critical": parameters(b=CRITICAL),
    "overdamped": parameters(b=40 * CRITICAL),
    "at resonance": parameters(),
    "1e-9 beside resonance": parameters(w=SPEED * (1 + 1e-9)),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("turns", [1, 1_000_000])
def test_closed_form_after_one_and_after_a_million_turns(fmu, case, turns):
    package, values = fmu("guide_bar"), CASES[case]
    span = turns * TURN
    times, got = [], []
    with package.unit() as unit:
        unit.initialise(values=values)
        # Up to the last turn in one step, then a few short ones.
        for time in [span - TURN * f for f in (0.77, 0.5, 0.31, 0.1, 0.0)]:
            if time > unit.time:
                unit.step_to(time)
                times.append(unit.time)
                got.append(unit.get("q", "der(q)"))
    expected = closed(package, values, times)
    scale = size_of_motion(package, values, span)
    assert np.all(np.abs(np.array(got) - expected) <= 1e-12 * scale)


@pytest.mark.parametrize("size", [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 10 * TURN])
@pytest.mark.parametrize("case", CASES)
def test_the_answer_does_not_depend_on_the_communication_step(fmu, case, size):
    package, values = fmu("guide_bar"), CASES[case]
    # At most 2000 communication steps, the last of them of full size.
    count = max(1, min(2000, round(20 * TURN / size)))
    with package.unit() as unit:
        unit.initialise(values=values)
        for _ in range(count):
            unit.step(size)
        got, time = np.array(unit.get("q", "der(q)", "y", "force", "tau")), unit.time
    (q, v), = closed(package, values, [time])
    scale = size_of_motion(package, values, time)
    series = reference.Series.of(package)
    phi = math.fmod(values["drive.phi_start"] + values["drive.w"] * time, 2 * math.pi)
    force = -(values["c"] * q + values["b"] * v)
    expected = [q, v, series.derivative(phi, 0) + q, force, series.derivative(phi, 1) * force]
    force_scale = values["c"] * scale[0] + values["b"] * scale[1]
    scales = [*scale, abs(series.a[1]), force_scale, abs(series.a[1]) * force_scale]
    assert np.all(np.abs(got - expected) <= 1e-12 * np.array(scales))


def test_steady_state_is_periodic(fmu):
    package = fmu("guide_bar")
    with package.unit() as unit:
        unit.initialise(values={"start.mode": 3})
        first = np.array(unit.get("q", "der(q)", "force", "tau"))
        turn = 2 * math.pi / package.start("drive.w")
        unit.step(turn)
        assert np.allclose(unit.get("q", "der(q)", "force", "tau"), first, rtol=1e-11, atol=1e-12 * np.abs(first).max())


def test_steady_state_is_refused_at_an_undamped_resonance(fmu):
    from fmpy.fmi1 import FMICallException

    with fmu("guide_bar").unit() as unit:
        with pytest.raises(FMICallException):
            unit.initialise(values=parameters() | {"start.mode": 3})
        assert "harmonic 5 of the cam meets the undamped natural frequency" in unit.log[-1][2]


def test_energy_balance_over_many_turns(fmu):
    """d/dt(m y'^2/2 + c q^2/2) = tau w - b q'^2, integrated by Gauss-Legendre over communication steps."""
    package = fmu("guide_bar")
    m, c, b, w = (package.start(n) for n in ("m", "c", "b", "drive.w"))
    nodes, weights = np.polynomial.legendre.leggauss(8)
    span = 1e-3
    work = 0.0
    with package.unit() as unit:
        unit.initialise()

        def energy():
            v, q = unit.get("der(y)", "q")
            return m * v * v / 2 + c * q * q / 2

        start = energy()
        scale = 0.0
        for cell in range(200):
            for node, weight in zip(nodes, weights):
                unit.step_to(span * (cell + (1 + node) / 2))
                tau, v = unit.get("tau", "der(q)")
                power = tau * w - b * v * v
                work += weight * span / 2 * power
                scale += weight * span / 2 * abs(power)
        unit.step_to(200 * span)
        assert abs(energy() - start - work) <= 1e-10 * scale


@pytest.mark.parametrize("w, start", [(20.0, 0.0), (-13.0, 100.0)])
@pytest.mark.parametrize("steps", [1, 1000])
def test_a_table_law_forwards_and_backwards_over_ten_revolutions(fmu, w, start, steps):
    """At another start time than zero the rounding of the time, 1e-14 s, is what limits reference and drive."""
    package = fmu("output_table")
    p = package.parameters()
    law = reference.Table()
    rhs = reference.elastic_output(p["m"], p["c"], p["b"], law, lambda t: (0.3 + w * (t - start), w, 0.0))
    span = 20 * math.pi / abs(w)
    times = start + span * np.linspace(0, 1, 41)
    expected = reference.integrate_pieces(rhs, [0.0, 0.0], times, reference.passages(law, 0.3, w, start, times[-1]))
    scale = np.abs(expected).max(axis=0)
    with package.unit() as unit:
        unit.initialise(start_time=start, values={"drive.w": w, "drive.phi_start": 0.3})
        for n in range(steps):
            unit.step_to(times[-1] if n + 1 == steps else start + span * (n + 1) / steps)
        got = np.array(unit.get("q", "der(q)"))
    assert np.all(np.abs(got - expected[-1]) <= 1e-10 * scale)


@pytest.mark.parametrize(
    "degrees, printed",
    [
        (30.0, [4.22722213936, 13.0494633938, 10.8830001335]),
        (150.0, [41.3577347589, 8.53543942776, -21.9712873891]),
        (260.0, [17.9817390072, -37.7430378822, 31.0695176066]),
    ],
)
def test_a_motion_plan_has_its_printed_values(fmu, degrees, printed):
    """x (mm) and its derivatives at 1 rad/s; the points of the scene are rounded to 1e-10 mm, and x'' is some ten times that."""
    with fmu("output_plan").unit() as unit:
        unit.initialise()
        unit.step_to(math.radians(degrees))
        x = unit.package.variables["x"].valueReference
        found = [unit.get("x"), *unit.slave.getRealOutputDerivatives([x, x], [1, 2])]
    assert np.allclose(1e3 * np.array(found), printed, rtol=0, atol=2e-9)


def test_the_points_of_a_plan_are_parameters(fmu):
    package = fmu("output_plan")
    names = [name for name in package.variables if name.startswith("cam.point[")]
    assert names == [
        *("cam.point[1].phi", "cam.point[1].U"),
        *("cam.point[2].phi", "cam.point[2].U", "cam.point[2].inflection"),
        *("cam.point[3].phi", "cam.point[3].U"),
        *("cam.point[4].phi", "cam.point[4].U", "cam.point[4].inflection"),
        *("cam.point[5].phi", "cam.point[5].U"),
        *("cam.point[6].phi", "cam.point[6].U", "cam.point[6].inflection"),
    ]
    with package.unit() as unit:
        unit.initialise(values={"cam.point[4].U": 0.05, "cam.point[5].U": 0.05})
        unit.step_to(math.radians(180.0))
        assert abs(unit.get("x") - 0.05) < 1e-16
    with package.unit() as unit:
        with pytest.raises(Exception):
            unit.initialise(values={"cam.point[3].phi": 0.5})
        assert "cam.point[3].phi: 28.6479 deg is not beyond" in unit.log[-1][2]


def ramp(t, w0=2.0, a=35.0):
    return w0 * t + a * t * t / 2, w0 + a * t, a


@pytest.mark.parametrize("size", [1e-6, 1e-4, 1e-3, 1e-2, 1e-1, 2.0])
def test_ramped_speed_with_inputs(fmu, size):
    package = fmu("output_input")
    values = package.parameters()
    series = reference.Series.of(package)
    m, c, b = values["m"], values["c"], values["b"]
    stop = min(2.0, 50_000 * size)
    times = np.linspace(0.0, stop, 11)
    rhs = reference.elastic_output(m, c, b, series, ramp)
    expected = reference.integrate(rhs, [0.0, 0.0], times)
    # The size of the motion is that of the whole ramp.
    scale = np.abs(reference.integrate(rhs, [0.0, 0.0], np.linspace(0.0, 2.0, 101))).max(axis=0)
    with package.unit() as unit:
        unit.set(phi=0.0, w=2.0, a=35.0)
        unit.initialise()
        got = []
        per_point = max(1, round(stop / 10 / size))
        if stop / size < 10:
            times, expected, per_point = times[[0, -1]], expected[[0, -1]], round(stop / size)
        for _ in times[1:]:
            for _ in range(per_point):
                phi, w, a = ramp(unit.time)
                unit.set(phi=phi, w=w, a=a)
                unit.step(size)
            got.append(unit.get("q", "der(q)"))
    assert np.all(np.abs(np.array(got) - expected[1:]) <= 1e-10 * scale)


def test_input_derivatives_make_the_motion_within_a_step_exact(fmu):
    """phi = 3 t + 2 t^3 + t^4 / 2 over one long step, given by derivatives of `a`."""
    package = fmu("output_input")
    values = package.parameters()
    series = reference.Series.of(package)

    def motion(t):
        return 3 * t + 2 * t**3 + t**4 / 2, 3 + 6 * t * t + 2 * t**3, 12 * t + 6 * t * t

    expected = reference.integrate(
        reference.elastic_output(values["m"], values["c"], values["b"], series, motion), [0.0, 0.0], [0.0, 0.5, 1.0]
    )
    a = package.variables["a"].valueReference
    with package.unit() as unit:
        unit.set(phi=0.0, w=3.0, a=0.0)
        unit.initialise()
        unit.slave.setRealInputDerivatives([a, a], [1, 2], [12.0, 12.0])
        unit.step(1.0)
        got = unit.get("q", "der(q)")
    assert np.all(np.abs(got - expected[-1]) <= 1e-10 * np.abs(expected).max(axis=0))


def test_a_jump_of_the_inputs_leaves_the_mass_where_it_is(fmu):
    package = fmu("output_input")
    with package.unit() as unit:
        unit.set(phi=0.2, w=5.0, a=0.0)
        unit.initialise()
        unit.step(0.01)
        before = unit.get("y", "der(y)")
        unit.set(phi=0.9, w=-3.0, a=1.0)
        y, v, q, q_dot, x = unit.get("y", "der(y)", "q", "der(q)", "x")
        series = reference.Series.of(package)
        assert np.allclose([y, v], before, rtol=0, atol=1e-15)
        assert math.isclose(x, series.derivative(0.9, 0), abs_tol=1e-15)
        assert math.isclose(q, y - x, abs_tol=1e-15)
        assert math.isclose(q_dot, v + 3.0 * series.derivative(0.9, 1), abs_tol=1e-13)


def test_a_tunable_parameter_changes_between_steps(fmu):
    package = fmu("guide_bar")
    values = package.parameters()
    series = reference.Series.of(package)
    with package.unit() as unit:
        unit.initialise()
        unit.step(0.0125)
        q, v = unit.get("q", "der(q)")
        softer = values["c"] / 2
        unit.set(c=softer)
        assert unit.get("q", "der(q)") == [q, v]
        unit.step(0.0125)
        got = unit.get("q", "der(q)")
    phase = values["drive.phi_start"] + values["drive.w"] * 0.0125
    expected = reference.elastic_output_closed(
        values["m"], softer, values["b"], series, values["drive.w"], phase, q, v, [0.0125]
    )[0]
    assert np.allclose(got, expected, rtol=1e-11, atol=1e-13 * abs(v))
