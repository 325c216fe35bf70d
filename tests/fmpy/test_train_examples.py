"""The numbers that the READMEs of the examples of drive trains promise."""

import json
import math
import re
import subprocess

import numpy as np
import pytest

from conftest import CAMDRIVE, ROOT, Package

EXAMPLES = ROOT / "examples"
EVENT = re.compile(r"t = ([-+0-9.e]+) s: follower 1: (release|impact)")


def exported(scene, folder):
    subprocess.run([CAMDRIVE, "export", scene, "-o", f"{folder}/"], check=True, capture_output=True)
    (path,) = folder.glob("*.fmu")
    return Package(path, folder / "unpacked")


def rounded(got, number):
    """Whether `got` rounds to `number`, given as the text of the README."""
    digits = len(number.partition(".")[2])
    return abs(got - float(number)) <= 0.5000001 * 10**-digits


def turn(package, names, values={}, count=3600):
    """The values at `count` equal steps and one more of the periodic motion, and its period."""
    with package.unit() as unit:
        unit.initialise(values=values)
        period, rows = unit.get("start.period"), []
        for i in range(count + 1):
            rows.append(unit.get(*names))
            unit.step_to(period * (i + 1) / count)
    return np.array(rows, dtype=float).T, period


def integral(values, period):
    """Over a period, by the trapezoidal rule."""
    return np.mean((values[1:] + values[:-1]) / 2) * period


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    return exported(EXAMPLES / "valve_train" / "measured.toml", tmp_path_factory.mktemp("measured"))


def lift_off(scene, folder):
    """The speed (rad/s) from which the follower of the scene leaves its cam, by `camdrive forces`."""
    done = subprocess.run([CAMDRIVE, "forces", scene, "-o", folder, "--json"], capture_output=True, text=True)
    return json.loads(done.stdout)["drives"][0]["keeping"]["lift_off_speed"]["value"]


def flights(package, speed, turns=3):
    """Instants of release and impact in the first turns, and the impulse of all impacts."""
    with package.unit() as unit:
        unit.initialise(values={"drive.w": speed})
        unit.step_to(turns * 2 * math.pi / speed)
        found = [EVENT.search(text) for _, category, text in unit.log if category == "logEvents"]
        events = [(m.group(2), float(m.group(1))) for m in found if m]
        return events, unit.get("follower[1].impulse")


def test_the_measured_lift_is_what_its_formula_says():
    rows = (EXAMPLES / "valve_train" / "lift.csv").read_text().splitlines()[1:]
    for i, row in enumerate(rows):
        angle, lift = map(float, row.split(";"))
        assert angle == i + 0.5
        assert abs(lift - 10 * math.sin(math.radians(angle) / 2) ** 12 - 3e-3 * math.sin(i * i)) < 0.51e-4
    assert len(rows) == 360


def test_the_speed_of_lift_off_of_the_measured_valve(measured, tmp_path):
    scene = EXAMPLES / "valve_train" / "measured.toml"
    speed = lift_off(scene, tmp_path)
    # At the top of 10 mm sin¹²(φ/2), U″ = −3 · 10 mm.
    exact = math.sqrt((250 + 25e3 * 10e-3) / (0.18 * 3 * 10e-3))
    assert rounded(exact * 30 / math.pi, "2905.8") and rounded(speed * 30 / math.pi, "2906.5")
    assert flights(measured, 0.9999 * speed)[0] == []
    kinds = [kind for kind, _ in flights(measured, 1.0001 * speed)[0]]
    assert kinds == ["release", "impact"] * 3
    noisy = tmp_path / "noisy.toml"
    noisy.write_text(scene.read_text().replace(', noise = "estimate"', "").replace("lift.csv", str(scene.parent / "lift.csv")))
    assert rounded(lift_off(noisy, tmp_path) * 30 / math.pi, "1434.9")


@pytest.mark.parametrize(
    ("rpm", "angle", "flight", "impulse"), [(2950, "174.70", "1.213", "0.0241"), (3000, "172.41", "1.721", "0.0700"), (3200, "167.15", "2.792", "0.3059")]
)
def test_flights_over_the_measured_cam(measured, rpm, angle, flight, impulse):
    speed = rpm * math.pi / 30
    events, total = flights(measured, speed)
    assert [kind for kind, _ in events] == ["release", "impact"] * 3
    release, impact = events[0][1], events[1][1]
    assert rounded(math.degrees(speed * release), angle)
    assert rounded(1e3 * (impact - release), flight) and rounded(total / 3, impulse)
    # In flight m ẍ = −F_v − c x; the cam without errors of the measurement meets the valve at the same time to 1 %.
    swing, rest = math.sqrt(25e3 / 0.18), -250 / 25e3
    U = lambda phi: 10e-3 * math.sin(phi / 2) ** 12
    phi = speed * release
    x, v = U(phi), speed * 6 * 10e-3 * math.sin(phi / 2) ** 11 * math.cos(phi / 2)
    gap = lambda t: rest + (x - rest) * math.cos(swing * t) + v / swing * math.sin(swing * t) - U(phi + speed * t)
    short, long = 0.3 * (impact - release), 3 * (impact - release)
    for _ in range(60):
        middle = (short + long) / 2
        short, long = (middle, long) if gap(middle) > 0 else (short, middle)
    assert abs(short / (impact - release) - 1) < (0.01 if rpm > 2950 else 0.05)


@pytest.fixture(scope="module")
def press(tmp_path_factory):
    return exported(EXAMPLES / "crank_press" / "scene.toml", tmp_path_factory.mktemp("press"))


@pytest.mark.parametrize(
    ("inertia", "slowest", "fastest", "drop", "least", "most", "limited"),
    [
        (20, "79.63", "106.89", "25.5", "-3.9", "60.0", "5.1"),
        (40, "90.94", "105.56", "13.9", "0.7", "38.1", "0.0"),
        (80, "96.03", "103.57", "7.3", "7.0", "26.1", "0.0"),
        (160, "98.18", "102.00", "3.7", "11.7", "21.3", "0.0"),
    ],
)
def test_the_flywheel_of_the_press(press, inertia, slowest, fastest, drop, least, most, limited):
    (w, torque, saturated), _ = turn(press, ["w", "M_an", "motor.saturated"], {"J0": inertia})
    rpm, motor = w * 30 / math.pi, torque / 8
    assert rounded(rpm.min(), slowest) and rounded(rpm.max(), fastest) and rounded(100 * (1 - w.min() / w.max()), drop)
    assert rounded(motor.min(), least) and rounded(motor.max(), most) and rounded(100 * saturated[1:].mean(), limited)


def test_the_energy_of_a_stroke_of_the_press(press):
    (w, torque), period = turn(press, ["w", "M_an"])
    work, friction = integral(torque * w, period), integral(2 * w * w, period)
    assert rounded(work, "879.81") and rounded(friction, "131.66")
    # −∫ F dy by the kinematics of the slider-crank.
    r, l, phi = 0.08, 0.5, np.radians(np.linspace(330, 360, 300_001))
    force = np.interp(np.degrees(phi), [330, 345, 356, 360], [-20e3, -90e3, -90e3, 0])
    slope = -r * np.sin(phi) - r * r * np.sin(phi) * np.cos(phi) / np.sqrt(l * l - (r * np.sin(phi)) ** 2)
    stroke = -integral(force * slope, phi[-1] - phi[0])
    assert rounded(stroke, "748.15")
    assert abs(work - friction - stroke) < 1e-6 * stroke


def test_the_press_from_standstill(press):
    with press.unit() as unit:
        unit.initialise(values={"start.mode": 1, "w_start": 0, "phi_start": 3})
        unit.step_to(4)
        (text,) = [text for _, category, text in unit.log if category == "logEvents"]
    assert "torque of the servo below its limit" in text and rounded(float(text.split()[2]), "2.301")


@pytest.mark.parametrize(
    ("elastic", "lag", "slowest", "fastest", "least", "most", "behind"),
    [
        (False, False, "474.43", "532.62", "-153.8", "127.6", None),
        (False, True, "473.67", "535.96", "-73.6", "46.7", None),
        (True, False, "473.79", "534.23", "-159.1", "130.2", "19.72"),
        (True, True, "473.06", "535.15", "-69.9", "46.6", "19.81"),
    ],
)
def test_the_rapier_loom_as_a_train(tmp_path, elastic, lag, slowest, fastest, least, most, behind):
    text = (EXAMPLES / "rapier_loom" / "train.toml").read_text()
    if not lag:
        text = text.replace('lag = "20 ms"\n', "")
    if not elastic:
        head, _, rest = text.partition("[follower.elasticity]")
        _, _, rest = rest.partition("\n\n")
        text = head.replace("[follower.cam]", 'm = "1.6 kg"\n[follower.cam]', 1) + "\n" + rest
    scene = tmp_path / "loom.toml"
    scene.write_text(text)
    q = ["phi", "follower[1].q", "follower[1].force"] if elastic else []
    (w, torque, *more), _ = turn(exported(scene, tmp_path), ["w", "M_an", *q], count=1440)
    rpm = w * 30 / math.pi
    assert rounded(rpm.min(), slowest) and rounded(rpm.max(), fastest)
    assert rounded(torque.min(), least) and rounded(torque.max(), most)
    if elastic:
        phi, q, force = more
        assert rounded(1e3 * abs(q).max(), behind)
        if lag:
            assert rounded(math.degrees(phi[abs(q).argmax()] % (2 * math.pi)), "170.9") and rounded(abs(force).max() / 1e3, "4.51")
