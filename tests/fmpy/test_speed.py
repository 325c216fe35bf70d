"""Drives on their speed alone, and what a drive on angle, speed and acceleration says of inputs that contradict each other."""

import math

import fmpy
import numpy as np
import pytest

import reference

DRIVES = ["output", "shaft", "backlash", "crank", "train"]

# w = 4 + 30 t - 90 t^2 + 60 t^3: it turns back and forth again.
SPEED = [4.0, 30.0, -180.0, 360.0]


def speed(t, order=0):
    """w and its derivatives."""
    return sum(c * t ** (j - order) / math.factorial(j - order) for j, c in enumerate(SPEED) if j >= order)


def angle(t, start):
    """Its integral."""
    return start + sum(c * t ** (j + 1) / math.factorial(j + 1) for j, c in enumerate(SPEED))


def give_speed(unit, derivatives=True):
    w = unit.package.variables["w"].valueReference
    unit.set(w=speed(unit.time))
    if derivatives:
        unit.slave.setRealInputDerivatives([w] * 3, [1, 2, 3], [speed(unit.time, order) for order in (1, 2, 3)])


def give_motion(unit, start):
    a = unit.package.variables["a"].valueReference
    unit.set(phi=angle(unit.time, start), w=speed(unit.time), a=speed(unit.time, 1))
    unit.slave.setRealInputDerivatives([a] * 2, [1, 2], [speed(unit.time, order) for order in (2, 3)])


def warnings(unit):
    return [text for status, category, text in unit.log if category == "logStatusWarning" and status == 1]


def compared(package):
    """The continuous outputs other than those of the shaft."""
    outputs = [v for v in package.description.modelVariables if v.causality == "output" and v.variability == "continuous"]
    return [v.name for v in outputs if v.name not in ("phi", "der(phi)")]


@pytest.mark.parametrize("name", DRIVES)
def test_it_has_the_input_w_alone_and_the_state_phi(fmu, name):
    package = fmu(f"{name}_speed")
    variables = package.description.modelVariables
    inputs = [v.name for v in variables if v.causality == "input"]
    assert [v for v in inputs if v in ("phi", "w", "a")] == ["w"]
    phi, rate = package.variables["phi"], package.variables["der(phi)"]
    assert phi.causality == rate.causality == "output" and rate.derivative is phi
    assert package.description.coSimulation.canInterpolateInputs
    assert package.start("drive.phi_start") == pytest.approx(math.radians(20.0) if name in ("output", "backlash", "train") else 0.0)


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("steps", [1, 7, 500])
def test_it_moves_as_the_drive_on_the_whole_motion(fmu, name, steps):
    alone, whole = fmu(f"{name}_speed"), fmu(f"{name}_input")
    start, stop, names = 0.4, 1.5, compared(alone)
    assert names == compared(whole)
    with alone.unit() as a, whole.unit() as b:
        a.set(**{"drive.phi_start": start, "w": speed(0.0)})
        a.initialise()
        b.set(phi=start, w=speed(0.0), a=speed(0.0, 1))
        b.initialise()
        largest = np.zeros(len(names))
        for n in range(steps):
            give_speed(a)
            give_motion(b, start)
            time = stop * (n + 1) / steps
            a.step_to(time)
            b.step_to(time)
            values = [np.array(unit.get(*names)) for unit in (a, b)]
            largest = np.maximum(largest, np.abs(values[1]))
        assert a.get("phi") == pytest.approx(angle(a.time, start), abs=1e-14)
        assert a.get("der(phi)") == pytest.approx(speed(a.time), abs=1e-13)
        assert np.all(np.abs(values[0] - values[1]) <= 1e-8 * largest + 1e-300), dict(zip(names, values[0] - values[1]))
        assert warnings(a) == warnings(b) == []


@pytest.mark.parametrize("size", [1e-3, 0.05, 0.3, 1.5])
def test_the_mass_moves_as_integrated_by_hand_at_any_communication_step(fmu, size):
    package = fmu("output_speed")
    p = package.parameters()
    law = reference.Series.of(package)
    rhs = reference.elastic_output(p["m"], p["c"], p["b"], law, lambda t: (angle(t, 0.7), speed(t), speed(t, 1)))
    times = np.linspace(0.0, 1.5, 51)
    expected = reference.integrate(rhs, [0.0, 0.0], times)
    with package.unit() as unit:
        unit.initialise(values={"drive.phi_start": 0.7, "w": speed(0.0)})
        while unit.time < 1.5 - 1e-9:
            give_speed(unit)
            unit.step_to(min(unit.time + size, 1.5))
        got = np.array(unit.get("q", "der(q)"))
        assert unit.get("phi") == pytest.approx(angle(unit.time, 0.7), abs=1e-13)
    assert np.all(np.abs(got - expected[-1]) <= 1e-9 * np.abs(expected).max(axis=0))


@pytest.mark.parametrize("name", DRIVES)
def test_a_speed_without_derivatives_is_held_over_the_step(fmu, name):
    """Then the motion is that of jumps of the speed, and phi is late by half a step of its change."""
    alone, whole = fmu(f"{name}_speed"), fmu(f"{name}_input")
    names, size, phi = compared(alone), 0.01, 0.4
    with alone.unit() as a, whole.unit() as b:
        a.initialise(values={"drive.phi_start": phi, "w": 2.0})
        b.set(phi=phi, w=2.0, a=0.0)
        b.initialise()
        largest = np.zeros(len(names))
        for n in range(50):
            w = 2.0 + 30.0 * size * n
            a.set(w=w)
            b.set(phi=phi, w=w, a=0.0)
            a.step(size)
            b.step(size)
            phi += w * size
            values = [np.array(unit.get(*names)) for unit in (a, b)]
            largest = np.maximum(largest, np.abs(values[1]))
        assert np.all(np.abs(values[0] - values[1]) <= 1e-8 * largest + 1e-300)
        time = a.time
        assert 0.4 + 2.0 * time + 15.0 * time**2 - a.get("phi") == pytest.approx(0.5 * size * 30.0 * time, rel=1e-9)


def test_a_jump_of_the_speed_hits_the_mass_as_the_flank_does(fmu):
    package = fmu("output_speed")
    with package.unit() as unit:
        unit.initialise(values={"drive.phi_start": 0.2, "w": 5.0})
        unit.step(0.01)
        before = unit.get("phi", "y", "der(y)", "q", "der(q)")
        unit.set(w=-3.0)
        after = unit.get("phi", "y", "der(y)", "q", "der(q)")
        slope = reference.Series.of(package).derivative(before[0], 1)
        assert np.allclose(after[:4], before[:4], rtol=0, atol=1e-15)
        assert math.isclose(after[4] - before[4], 8.0 * slope, abs_tol=1e-13)
        assert unit.get("der(phi)") == -3.0
        unit.step(0.01)
        assert unit.get("phi") == pytest.approx(before[0] - 0.03, abs=1e-15)
        assert warnings(unit) == []


def test_an_importer_that_knows_the_speed_alone_runs_up(fmu):
    """The guide bar at 20 rad/s2: with input derivatives as on phi, w and a, by fmpy without them half a step late."""
    package, largest = fmu("guide_bar_speed"), 0.0
    with package.unit() as unit:
        unit.initialise()
        for n in range(1, 101):
            unit.set(w=20.0 * unit.time)
            unit.slave.setRealInputDerivatives([package.variables["w"].valueReference], [1], [20.0])
            unit.step_to(n / 100)
            largest = max(largest, abs(unit.get("tau")))
        phi, x = unit.get("phi", "x")
    assert phi == pytest.approx(10.0, abs=1e-13)
    # As on phi, w and a.
    assert x == pytest.approx(-4.667e-4, rel=1e-4) and largest == pytest.approx(2.87e-3, rel=2e-3)
    time = np.arange(0, 1.0001, 0.01)
    held = fmpy.simulate_fmu(
        str(package.path),
        input=np.array(list(zip(time, 20.0 * time)), dtype=[("time", float), ("w", float)]),
        stop_time=1.0,
        output_interval=0.01,
        output=["phi"],
    )
    assert held["phi"][-1] == pytest.approx(10.0 - 0.5 * 0.01 * 20.0, abs=1e-12)


RUN_UP = {"phi": lambda t: 10.0 * t * t, "w": lambda t: 20.0 * t, "a": lambda t: 20.0}


def run_up(unit, connected, steps=30):
    """Steps of 10 ms with these inputs connected, the others at 0."""
    give = lambda: unit.set(**{name: RUN_UP[name](unit.time) for name in connected})
    give()
    unit.initialise()
    for _ in range(steps):
        give()
        unit.step(0.01)


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("connected", [["phi", "w", "a"], ["phi", "w"], ["w"], ["w", "a"], ["phi"], ["phi", "a"]], ids="_".join)
def test_inputs_that_contradict_each_other_are_told_once(fmu, name, connected):
    with fmu(f"{name}_input").unit() as unit:
        for _ in range(2):
            run_up(unit, connected)
            told = warnings(unit)
            if "phi" in connected and "w" in connected:
                assert told == []
            elif "w" in connected:
                assert len(told) == 1 and "phi stays constant while w is not 0" in told[0] and 'mode = "speed"' in told[0], told
            else:
                assert len(told) == 1 and "w stays 0 while phi changes" in told[0], told
            # After a reset it is another run.
            unit.log.clear()
            unit.slave.reset()
            unit.time = 0.0


def test_a_warning_belongs_to_the_state(fmu):
    """Restored to an instant before it, the instance tells it again; told before, it stays told."""
    with fmu("output_input").unit() as unit:
        unit.set(phi=0.0, w=5.0, a=0.0)
        unit.initialise()
        unit.step(0.01)
        before = unit.slave.getFMUstate()
        for _ in range(2):
            unit.slave.setFMUstate(before)
            unit.time = 0.01
            unit.set(phi=0.3)
            unit.step(0.01)
            unit.set(phi=0.6)
            unit.step(0.01)
        unit.slave.freeFMUstate(before)
        told = warnings(unit)
        assert len(told) == 2 and told[0] == told[1]
        assert told[0].startswith("t = 0.01 s: phi differs from the angle to which phi, w and a of the previous step lead") and "jump of phi = 0.25 rad" in told[0]


def test_what_nobody_wants_to_read_is_not_told(fmu):
    with fmu("output_input").unit(logging=False) as unit:
        run_up(unit, ["w"])
        assert unit.log == []
