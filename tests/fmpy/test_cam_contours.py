"""`camdrive cam`: the roller touches its contours at every angle of the cam, recomputed from the scene alone.

Nothing of the program's formulas is used: the follower is placed in the machine from law and lengths, the cam is turned under
it, and the distance from the roller's centre to the whole polygon of the file is that of the roller's radius.
"""

import math
import subprocess
import tomllib

import numpy as np
import pytest

from conftest import CAMDRIVE, ROOT

CHORD = 1e-6
# The files give tenths of a nanometre.
DIGITS = 2e-10

DISC = """
name = "disc"
model = "ElasticCamDrive"
[cam]
law = "fourier"
a = ["20 mm", "-20 mm", "2 mm"]
b = ["1 mm", "3 mm"]
[geometry]
roller_radius = "12 mm"
{geometry}
[drive]
mode = "constant"
speed = "100 rpm"
[elasticity]
place = "output"
m = 1
natural_frequency = "40 Hz"
"""
LEVER = 'follower = "lever"\npivot_distance = "160 mm"\narm_length = "110 mm"\n'
SLIDE = 'follower = "translating"\noffset = "12 mm"\n'
DISCS = {
    "outer_lever": LEVER + 'contour = "outer"\nprime_radius = "75 mm"\nside = "right"\ntransmission = "-90 mm"',
    "groove_lever": LEVER + 'contour = "groove"\nprime_radius = "75 mm"\nrotation = "clockwise"',
    "conjugate_lever": LEVER + 'contour = "conjugate"\nbase_radius = "60 mm"\nside = "right"\nrotation = "clockwise"\n'
    'second_arm_angle = "105 deg"\nsecond_arm_length = "125 mm"\nsecond_roller_radius = "15 mm"',
    "inner_slide": SLIDE + 'contour = "inner"\nbase_radius = "50 mm"',
    "outer_slide": SLIDE + 'contour = "outer"\nprime_radius = "60 mm"\nrotation = "clockwise"',
    "conjugate_slide": SLIDE + 'contour = "conjugate"\nbase_radius = "60 mm"\nroller_distance = "190 mm"',
}


def si(value):
    """A value of a scene with its unit."""
    if not isinstance(value, str):
        return float(value)
    number, unit = value.split()
    return float(number) * {"mm": 1e-3, "m": 1.0, "deg": math.pi / 180}[unit]


class Law:
    def __init__(self, cam):
        self.a = np.array([si(x) for x in cam["a"]])
        self.b = np.array([0.0] + [si(x) for x in cam.get("b", [])])
        # The vertex of the parabola through the extreme points is off by 1e-13 of the lift.
        places = np.linspace(0.0, 2 * np.pi, 20_001)
        self.ends = [self.extreme(sign, places) for sign in (1.0, -1.0)]

    def extreme(self, sign, places):
        """The least lift, or the largest."""
        lifts = sign * self(places)
        best = lifts[:-1].argmin()
        left, middle, right = lifts[best - 1 if best else -2], lifts[best], lifts[best + 1]
        return sign * (middle - (right - left) ** 2 / (8 * (right - 2 * middle + left)))

    def __call__(self, phi):
        phi = np.asarray(phi)[..., None]
        return np.cos(phi * np.arange(len(self.a))) @ self.a + np.sin(phi * np.arange(len(self.b))) @ self.b


def rollers(law, geometry, angular, phi):
    """Centre and radius of each roller in the machine at the angles phi of the cam, and the sense of turning."""
    lifts, (least, largest) = law(phi), law.ends
    radius = si(geometry["roller_radius"])
    prime = si(geometry["prime_radius"]) if "prime_radius" in geometry else si(geometry["base_radius"]) + radius
    sense = -1.0 if geometry.get("rotation") == "clockwise" else 1.0
    second = si(geometry.get("second_roller_radius", radius))
    if geometry["follower"] == "translating":
        offset = si(geometry.get("offset", 0.0))
        # The lowest place of the roller is on the prime circle.
        height = lifts - least + math.sqrt(prime**2 - offset**2)
        places = [(offset + 1j * height, radius)]
        if geometry["contour"] == "conjugate":
            places.append((offset + 1j * (height - si(geometry["roller_distance"])), second))
        return places, sense
    pivot, arm = si(geometry["pivot_distance"]), si(geometry["arm_length"])
    ratio = si(geometry.get("transmission", 1.0 if angular else arm))
    lowest = math.acos((pivot**2 + arm**2 - prime**2) / (2 * pivot * arm))
    angle = lifts / ratio - min(least / ratio, largest / ratio) + lowest
    side = -1.0 if geometry.get("side") == "right" else 1.0
    # The arms start from the pivot; their angle counts from the direction to the cam's centre.
    places = [(pivot - arm * np.exp(-1j * side * angle), radius)]
    if geometry["contour"] == "conjugate":
        other = si(geometry["second_arm_angle"]) - angle
        places.append((pivot - si(geometry.get("second_arm_length", arm)) * np.exp(1j * side * other), second))
    return places, sense


def distance(point, polygon):
    """From a point to the closed polygon, and how often the polygon winds around it."""
    start, end = polygon, np.roll(polygon, -1)
    along = end - start
    part = np.clip(((point - start) * along.conj()).real / np.abs(along) ** 2, 0.0, 1.0)
    turns = np.angle((end - point) / (start - point)).sum() / (2 * np.pi)
    return np.abs(point - start - part * along).min(), round(abs(turns))


def csv(path):
    head, *rows = path.read_text().split()
    separator = ";" if ";" in head else ","
    return dict(zip(head.split(separator), np.array([row.split(separator) for row in rows], float).T))


def polylines(path):
    """The closed polylines of a DXF by layer [mm], and its circles."""
    lines = path.read_text().splitlines()
    pairs = list(zip(map(int, map(str.strip, lines[::2])), lines[1::2]))
    found, circles, entity, current = {}, {}, None, {}

    def close():
        if entity == "VERTEX":
            found.setdefault(current[8], []).append(complex(float(current[10]), float(current[20])))
        if entity == "CIRCLE":
            circles[current[8]] = complex(float(current[10]), float(current[20])), float(current[40])

    for code, value in pairs:
        if code == 0:
            close()
            entity, current = value, {}
        current[code] = value
    return {layer: np.array(points) for layer, points in found.items()}, circles


def touch(name, folder, law, geometry, angular):
    """Every contour of the files of a cam at angles that are none of its points."""
    phi = np.random.default_rng(5).uniform(0.0, 2 * np.pi, 150)
    places, sense = rollers(law, geometry, angular, phi)
    drawn, circles = polylines(folder / f"{name}.dxf")
    at_rest, _ = rollers(law, geometry, angular, np.array([0.0]))
    pairs = ["F", "P"] if len(places) == 2 else [""]
    sides = {"outer": ["outer"], "groove": ["inner", "outer"]}.get(geometry["contour"], ["inner"])
    for which, (centres, radius), (start, _) in zip(pairs, places, at_rest):
        table = csv(folder / (f"{name}.{which}.csv" if which else f"{name}.csv"))
        prefix = f"{which}_" if which else ""
        centre, size = circles[f"{prefix}ROLLER"]
        assert abs(centre - 1e3 * start[0]) < 1e-6 and abs(size - 1e3 * radius) < 1e-6
        for side in sides:
            polygon = table[f"{side}_x_mm"] + 1j * table[f"{side}_y_mm"]
            layer = drawn[f"{prefix}{side.upper()}_CONTOUR"]
            assert len(layer) == len(polygon) and np.abs(layer - polygon).max() < 1e-6
            for angle, centre in zip(phi, centres):
                # The cam has turned by the angle; in its frame the machine has turned back.
                found, inside = distance(1e3 * centre * np.exp(-1j * sense * angle), polygon)
                assert abs(1e-3 * found - radius) <= CHORD + DIGITS, (which, side, angle, found)
                assert inside == (side == "outer")
        path = table["centre_x_mm"] + 1j * table["centre_y_mm"]
        angles = np.radians(table["phi_deg"])
        wanted, _ = rollers(law, geometry, angular, angles)[0][pairs.index(which)]
        turned = wanted * np.exp(-1j * sense * angles)
        assert np.abs(path - 1e3 * turned).max() < 1e-6


def motion_controller(name, folder, law, geometry, angular):
    """The cam tables, joined by straight lines, are the law to 1 um, of an angle at the roller."""
    arm = si(geometry.get("arm_length", 1.0)) / si(geometry.get("transmission", 1.0)) if angular else 1.0
    unit, tolerance = math.degrees(1.0) if angular else 1e3, 1e-6 / arm
    table = csv(folder / f"{name}.plcopen.csv")
    master = next(v for k, v in table.items() if k.startswith("MasterPosition"))
    slave = next(v for k, v in table.items() if k.startswith("SlavePosition"))
    columns = np.array([line.split("\t") for line in (folder / f"{name}.plc.txt").read_text().splitlines()], float)
    assert np.array_equal(columns, np.array([master, slave]).T)
    assert master[0] == 0.0 and master[-1] == 360.0 and np.all(np.diff(master) > 0)
    phi = np.linspace(0.0, 360.0, 20_001)
    error = np.abs(np.interp(phi, master, slave) / unit - law(np.radians(phi))).max()
    assert error <= tolerance + 1e-9, error
    # Velocity and acceleration are the law's derivatives.
    for key, order in (("SlaveVelocity", 1), ("SlaveAcceleration", 2)):
        values = next(v for k, v in table.items() if k.startswith(key))
        k = np.arange(max(len(law.a), len(law.b)))
        waves = np.pad(law.a, (0, len(k) - len(law.a))) - 1j * np.pad(law.b, (0, len(k) - len(law.b)))
        wanted = (np.exp(1j * np.outer(np.radians(master), k)) @ (waves * (1j * k) ** order)).real
        wanted *= unit / math.degrees(1.0) ** order
        assert np.abs(values - wanted).max() <= 1e-6 * np.abs(wanted).max() + 1e-8


@pytest.mark.parametrize("kind", DISCS)
def test_a_roller_touches_its_contours(kind, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(DISC.format(geometry=DISCS[kind]))
    run = subprocess.run([CAMDRIVE, "cam", scene, "-o", tmp_path], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    content = tomllib.loads(scene.read_text())
    law = Law(content["cam"])
    touch("disc", tmp_path, law, content["geometry"], False)
    motion_controller("disc", tmp_path, law, content["geometry"], False)


@pytest.mark.parametrize("example", ["rapier_loom", "sealing_machine"])
def test_the_cams_of_compensated_machines_lead_their_levers(example, tmp_path):
    """Of levers and of levers before mechanisms, whose law is an angle."""
    compensated = tmp_path / "compensated.toml"
    scene = ROOT / "examples" / example / "scene.toml"
    subprocess.run([CAMDRIVE, "compensate", scene, "-o", compensated], check=True, capture_output=True)
    subprocess.run([CAMDRIVE, "cam", compensated, "-o", tmp_path / "cams"], check=True, capture_output=True)
    followers = tomllib.loads(compensated.read_text())["follower"]
    assert len(followers) == 2
    for j, follower in enumerate(followers, 1):
        angular, law = "linkage" in follower or "J" in follower, Law(follower["cam"])
        name = f"{example}_hs.follower{j}"
        touch(name, tmp_path / "cams", law, follower["geometry"], angular)
        motion_controller(name, tmp_path / "cams", law, follower["geometry"], angular)
