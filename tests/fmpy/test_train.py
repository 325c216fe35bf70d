"""Drive trains against reference numbers, on which an integration by Taylor series in 170 bits (reduced equations) and one by
extrapolation in 80 bits (Lagrange multipliers, redundant coordinates) agree to the digits shown."""

import math
import re
import subprocess
import tomllib

import pytest

from conftest import CAMDRIVE, ROOT, Package

TRAINS = ROOT / "tests" / "fmpy" / "trains"
LINE = re.compile(r"t = ([-+0-9.e]+) s: (?:follower (\d+): |torque of the servo )?(release|impact|at|below)")

# End (s), values there, first events: kind, follower (0: the servo at or below its limit), time (s). N is the force of the cam on the follower, x1 the mass at the
# clearance, psi the angle behind an elastic shaft.
CASES = {
    "outputs": (
        1.2,
        {
            "phi": 13.8278766955171,
            "w": 14.807108164271,
            "follower[1].y": 0.0130308905717516,
            "der(follower[1].y)": -0.48402215440047,
            "follower[2].y": -0.0117638731780698,
            "der(follower[2].y)": 0.303481563256041,
            "follower[1].N": -26.3841256572317,
            "follower[2].N": 6.3532755476481,
            "M_an": 7.58171059300451,
        },
        [],
    ),
    "shaft": (
        1,
        {
            "phi": 14.4464441927694,
            "w": 13.656989420565,
            "follower[1].psi": 14.4226887548618,
            "der(follower[1].psi)": 17.5454717952993,
            "follower[1].N": 414.634477729734,
            "M_an": 44.7517812647158,
        },
        [],
    ),
    "backlash_e0": (
        0.8,
        {
            "phi": 12.1109947192104,
            "w": 14.9492071279756,
            "follower[1].x1": -0.041676130728845,
            "der(follower[1].x1)": -0.312015869770759,
            "follower[1].y": -0.0377022485695266,
            "der(follower[1].y)": -3.02550743744194,
            "M_an": 2.03113264194284,
            "follower[1].impulse": -0.580565103219888,
            "energy_loss": 0.269066190019219,
        },
        [("release", 1, 0.172203264386481), ("impact", 1, 0.195433264478715), ("release", 1, 0.373242680038908)],
    ),
    "backlash_e06": (
        0.5,
        {
            "phi": 7.67859937878697,
            "w": 14.7598301968251,
            "follower[1].x1": -0.0104202491682276,
            "der(follower[1].x1)": 0.676111562607312,
            "follower[1].y": -0.135661235633522,
            "der(follower[1].y)": 0.725520462320645,
            "follower[1].N": 261.122454666059,
            "M_an": 9.5456137219013,
            "follower[1].impulse": 0.404462646821003,
            "energy_loss": 0.170034933866405,
        },
        [("release", 1, 0.172203264386481), ("impact", 1, 0.195433264478715), ("impact", 1, 0.206145615119258)],
    ),
    "loom": (
        0.24,
        {
            "phi": 12.1630434874286,
            "w": 51.5483288978671,
            "follower[1].y": 0.00256176923258925,
            "der(follower[1].y)": 0.589357247045457,
            "follower[1].N": -965.28475621835,
            "follower[2].N": -10895.4226864237,
            "M_an": 42.2271902339772,
        },
        [],
    ),
    "servo": (
        0.6,
        {
            "phi": 10.4103491430712,
            "w": 35.1597518256837,
            "motor.I": 4.79749884524076,
            "follower[1].y": -0.0414399853736773,
            "der(follower[1].y)": 2.26683364617827,
            "follower[1].N": 84.5190069171191,
            "follower[2].N": 33.0210273299121,
            "M_an": 5,
        },
        [("at", 0, 0.388079903331848), ("below", 0, 0.496867260950225), ("at", 0, 0.525533807969804)],
    ),
    "two_contacts": (
        0.8,
        {
            "phi": 8.965211991447,
            "w": 11.1201712017026,
            "follower[1].x1": 0.0522255549703481,
            "der(follower[1].x1)": 0.312853587955346,
            "follower[1].y": 0.101369889441858,
            "der(follower[1].y)": 0.398048682532783,
            "follower[2].x1": -0.0155416485286587,
            "der(follower[2].x1)": -0.271086927009983,
            "follower[2].y": -0.016012680127485,
            "follower[1].N": -115.387554209599,
            "M_an": -3.48922658416085,
            "follower[1].impulse": -0.29695678411244,
            "follower[2].impulse": 0.0115756025634132,
            "energy_loss": 0.261195820316068,
        },
        [("release", 2, 0.00163552897403256), ("impact", 2, 0.0362787773881733), ("impact", 1, 0.0364585928013257)],
    ),
    "limit_J1e3": (
        0.5,
        {
            "phi": 6.29974583316266,
            "w": 11.9988841844925,
            "follower[1].x1": -0.0439301955164329,
            "der(follower[1].x1)": 0.053155776901579,
            "follower[1].y": -0.12437726953372,
            "der(follower[1].y)": -0.684553020165588,
            "follower[1].N": 183.117667008545,
            "follower[1].impulse": 0.101837207554947,
            "energy_loss": 0.126527308261763,
        },
        [("release", 1, 0.196614639181846), ("impact", 1, 0.222741057813247), ("release", 1, 0.4162661940736)],
    ),
    "limit_J1e6": (
        0.5,
        {
            "phi": 6.29999974582461,
            "w": 11.9999988841159,
            "follower[1].x1": -0.0439290698319145,
            "der(follower[1].x1)": 0.0532397519689685,
            "follower[1].y": -0.124384164537387,
            "der(follower[1].y)": -0.684475121326587,
            "follower[1].N": 183.134988612025,
            "follower[1].impulse": 0.101844825018883,
            "energy_loss": 0.126531661878889,
        },
        [("release", 1, 0.196613873508329), ("impact", 1, 0.222740048228233)],
    ),
    "limit_Jinf": (
        0.5,
        {
            "follower[1].x1": -0.0439290687042273,
            "der(follower[1].x1)": 0.0532398360371701,
            "follower[1].y": -0.124384171438714,
            "der(follower[1].y)": -0.684475043337435,
            "follower[1].N": 183.135005952045,
            "follower[1].tau": 0.81250647412942,
            "follower[1].impulse": 0.101844832643523,
            "energy_loss": 0.126531666236793,
        },
        [("release", 1, 0.196613872741871), ("impact", 1, 0.222740047217622), ("release", 1, 0.416262964786004)],
    ),
    "limit_c1e6": (
        0.1,
        {
            "phi": 1.28839803833838,
            "w": 14.7509439415557,
            "follower[1].y": 0.00997376655298119,
            "der(follower[1].y)": -0.454190907514957,
            "follower[1].N": -30.2267992478872,
            "M_an": 9.89405152301181,
        },
        [],
    ),
    "limit_c1e8": (
        0.1,
        {
            "phi": 1.28839896605301,
            "w": 14.7510442306117,
            "follower[1].y": 0.00994381172196952,
            "der(follower[1].y)": -0.453159217704149,
            "follower[1].N": -30.0467725725994,
            "M_an": 9.89012192876917,
        },
        [],
    ),
    "limit_rigid": (
        0.1,
        {
            "phi": 1.28839897528936,
            "w": 14.7510447185228,
            "follower[1].N": -29.9297443972573,
            "M_an": 9.89010281094165,
        },
        [],
    ),
    "load_output": (
        0.9,
        {
            "follower[1].y": 0.025163614349626,
            "der(follower[1].y)": 0.0122018586467936,
            "follower[1].N": 96.3053413825294,
            "follower[1].tau": 0.00220785268877654,
        },
        [],
    ),
    "load_shaft": (
        0.9,
        {
            "follower[1].psi": 12.5975089226534,
            "der(follower[1].psi)": 12.1665048428283,
            "follower[1].N": 339.200246064352,
            "follower[1].tau": 4.82278797313989,
        },
        [],
    ),
    "load_rigid": (
        0.9,
        {
            "follower[1].N": 125.917254314439,
            "follower[1].tau": 0.00288672200846304,
        },
        [],
    ),
    "load_backlash": (
        0.6,
        {
            "follower[1].x1": -0.0421210497716215,
            "der(follower[1].x1)": -0.0641580002411233,
            "follower[1].y": 0.0164851868472915,
            "der(follower[1].y)": -1.10757361983927,
            "follower[1].N": -53.8317409201792,
            "follower[1].tau": 0.172686842346847,
            "follower[1].impulse": -0.363483794278535,
            "energy_loss": 0.136796760191905,
        },
        [("release", 1, 0.204489952473781), ("impact", 1, 0.241096885986446), ("release", 1, 0.255603389272205)],
    ),
    "lift_e0": (
        0.12,
        {
            "follower[1].x1": -0.00104578396142975,
            "der(follower[1].x1)": 1.21137885810118,
            "follower[1].N": 157.33790870028,
            "follower[1].tau": 1.12115185986691,
            "follower[1].impulse": 3.56410465517052,
            "energy_loss": 3.52856722028004,
        },
        [("release", 1, 0.0149809141665695), ("impact", 1, 0.0338163761054477), ("release", 1, 0.0519408277382142)],
    ),
    "lift_e04": (
        0.08,
        {
            "follower[1].x1": -0.00417020238712716,
            "der(follower[1].x1)": 0.822764923843696,
            "follower[1].impulse": 5.31685563160855,
            "energy_loss": 2.28274775169493,
        },
        [("release", 1, 0.0149809141665695), ("impact", 1, 0.0338163761054477), ("impact", 1, 0.0393377674304742)],
    ),
    "lift_train": (
        0.15,
        {
            "phi": 27.3275139327169,
            "w": 187.973388254063,
            "follower[1].x1": 0.00400926187986684,
            "der(follower[1].x1)": 1.49357790730632,
            "follower[1].y": -0.00100671474653625,
            "der(follower[1].y)": -1.66374826495584,
            "follower[1].N": 2185.02631200945,
            "M_an": 1.2763350458546,
            "follower[1].impulse": 2.57950158029862,
            "energy_loss": 5.46454785766229,
        },
        [("release", 1, 0.0174073815901246), ("impact", 1, 0.0359830450421741), ("release", 1, 0.0397358679752581)],
    ),
    "ratio": (
        1,
        {
            "phi": 10.0922403819822,
            "w": 14.9058111771265,
            "M_an": 3 * 1.27879940720284,
            "follower[1].y": -0.0229874795760311,
            "der(follower[1].y)": -0.087523207959432,
        },
        [],
    ),
    "coupling": (
        1,
        {
            "phi": 10.1915651103953,
            "w": 14.8999130490062,
            "motor.w": 44.7338911652578,
            "follower[1].y": -0.0236275145019588,
        },
        [],
    ),
    "coupling_servo": (
        0.6,
        {
            "phi": 8.89631396151544,
            "w": 29.822219952184,
            "motor.I": 1.70506406523555,
            "motor.w": 111.61964062816,
            "follower[1].y": -0.044692077691738,
        },
        [("at", 0, 0.44640342878606), ("below", 0, 0.462506326134282), ("at", 0, 0.577280978758409)],
    ),
    "table": (
        1.2,
        {
            "phi": 14.4128498816335,
            "w": 14.6945826138407,
            "follower[1].y": -0.0106699374670167,
            "M_an": 6.73073868449789,
        },
        [],
    ),
    "servo_position": (
        0.9,
        {
            "phi": 19.5141609115616,
            "w": 25.4022388660357,
            "motor.I": 1.10503059154198,
            "follower[1].y": 0.028339016666652,
            "M_an": -4.7569001120377,
        },
        [("below", 0, 0.394820137781703), ("at", 0, 0.40815455817346), ("below", 0, 0.536083569307699)],
    ),
    "press": (
        0.78,
        {
            "phi": 12.2031365166528,
            "w": 12.0060868002694,
            "a": -32.1190434213295,
            "follower[1].N": 62878.3563888403,
            "motor.I": 15.0588944013349,
            "follower[1].tau": 2108.11365820767,
        },
        [],
    ),
    "four_bar": (
        0.8,
        {
            "phi": 11.7260129350849,
            "w": 14.9649700303409,
            "a": 1.51610273279994,
            "follower[1].N": 0.514337529502273,
            "follower[1].tau": -0.0659163772090079,
        },
        [],
    ),
    "cycle_output": (
        1,
        {
            "phi": 14.3707017235595,
            "w": 14.8172596781298,
            "follower[1].y": 0.0428991875930361,
            "follower[1].N": -24.6964438939232,
            "a": 2.40549189116252,
        },
        [],
    ),
    "cycle_lift": (
        0.06,
        {
            "phi": 10.3695355395108,
            "w": 186.144498473369,
            "follower[1].x1": 0.0230156630726504,
            "follower[1].y": 0.0229873644595581,
            "follower[1].impulse": 0.700125401900597,
        },
        [("release", 1, 0.00982595414022469), ("impact", 1, 0.0321415720175391)],
    ),
    "cycle_jump": (
        0.06,
        {
            "phi": 10.3809898350756,
            "w": 186.569206067487,
            "follower[1].x1": 0.0120355536220479,
            "der(follower[1].x1)": -1.17478565847836,
            "a": 179.108153567633,
            "follower[1].impulse": 1.76701118913267,
        },
        [("release", 1, 0.0108028171810113), ("impact", 1, 0.0215266137842262), ("release", 1, 0.0218015307208838), ("impact", 1, 0.0327214886227547)],
    ),
    "equilibrium": (
        0.6,
        {
            "phi": 7.09468338889146,
            "w": 14.560863727945,
            "follower[1].y": 0.00772453385195597,
            "follower[2].psi": 7.07066910703799,
            "follower[3].y": -0.00732996080974156,
            "follower[3].N": 90.2940559076064,
        },
        [],
    ),
    "periodic": (
        0.422775956727908,
        {
            "w": 14.834951322737,
            "follower[1].y": 0.013661175937604,
            "der(follower[1].y)": 0.014547572202273,
        },
        [],
    ),
}


@pytest.fixture(scope="module")
def train(tmp_path_factory):
    """A function from the name of a train to its FMU and its scene."""
    folder, packages = tmp_path_factory.mktemp("trains"), {}

    def load(name):
        if name not in packages:
            scene = TRAINS / f"{name}.toml"
            subprocess.run([CAMDRIVE, "export", scene, "-o", f"{folder}/"], check=True, capture_output=True)
            packages[name] = Package(folder / f"{name}.fmu", folder / name), tomllib.loads(scene.read_text())
        return packages[name]

    return load


def value(unit, scene, name):
    """The value of an output, or what follows from outputs."""
    j, key = re.search(r"(?:\[(\d)\]\.)?(\w+)\)?$", name).groups()
    if key == "N":
        elastic = scene["follower"][int(j) - 1].get("elasticity", {}).get("place") == "output"
        return unit.get(f"follower[{j}].{'contact_' if elastic else ''}force")
    if key == "psi" and name.startswith("der"):
        return unit.get("w") + unit.get(f"der(follower[{j}].q)")
    if key == "energy_loss":
        return sum(unit.get(name) for name in unit.package.variables if name.endswith(".energy_loss"))
    return unit.get(name)


def run(train, name, steps):
    """Values at the end, the largest size of each, and the events."""
    (package, scene), (end, expected, _) = train(name), CASES[name]
    with package.unit() as unit:
        inputs = {"follower[1].F": 30 * math.sin(25 * end)} if name == "load_rigid" else {}
        unit.initialise(values=inputs)
        read = lambda: {key: value(unit, scene, key) for key in expected}
        largest = {key: 0.0 for key in expected}
        for i in range(steps):
            unit.step_to(end * (i + 1) / steps)
            largest = {key: max(largest[key], abs(found)) for key, found in read().items()}
        found = (LINE.search(text) for _, category, text in unit.log if category == "logEvents")
        events = [(m.group(3), int(m.group(2) or m.group(3) in ("release", "impact")), float(m.group(1))) for m in found if m]
        return read(), largest, events


@pytest.mark.parametrize("name", CASES)
def test_states_sums_and_first_events(train, name):
    _, expected, first = CASES[name]
    _, largest, _ = run(train, name, 200)
    for steps in (1, 7, 200):
        got, _, events = run(train, name, steps)
        for key, number in expected.items():
            assert abs(got[key] - number) <= 1e-9 * largest[key], (steps, key, got[key], number)
        assert [event[:2] for event in events[: len(first)]] == [event[:2] for event in first]
        for (_, _, time), (_, _, exact) in zip(events, first):
            assert abs(time - exact) <= 1e-9 * CASES[name][0], (steps, time, exact)


SINGLE = {
    "load_backlash": "BacklashDrive",
    "lift_e0": "BacklashDrive",
    "lift_e04": "BacklashDrive",
    "press": "RigidMachine",
    "four_bar": "RigidMachine",
}


@pytest.mark.parametrize("name", SINGLE)
def test_the_single_model_with_its_loads_moves_as_the_train(train, tmp_path, name):
    text, (end, expected, first) = (TRAINS / f"{name}.toml").read_text(), CASES[name]
    called = lambda name: name
    if SINGLE[name] == "BacklashDrive":
        own = re.findall(r"^(?:cam|backlash) = .*\n", text, re.MULTILINE)
        for line in ["[[follower]]\n", *own]:
            text = text.replace(line, "")
        text = "".join(own) + text.replace("[follower.load]", "[load]")
        called = lambda name: name.replace("follower[1].", "").replace("N", "force")
    scene = tmp_path / f"{name}.toml"
    scene.write_text(text.replace('"DriveTrain"', f'"{SINGLE[name]}"'))
    subprocess.run([CAMDRIVE, "export", scene, "-o", f"{tmp_path}/"], check=True, capture_output=True)
    package = Package(tmp_path / f"{name}.fmu", tmp_path / name)
    _, largest, _ = run(train, name, 200)
    with package.unit() as unit:
        unit.initialise()
        for i in range(7):
            unit.step_to(end * (i + 1) / 7)
        for key, number in expected.items():
            found = unit.get(called(key.replace("].N", "].force")))
            assert abs(found - number) <= 1e-9 * largest[key], (key, found, number)
        events = [m for m in (LINE.search(text) for _, category, text in unit.log if category == "logEvents") if m]
    for event, (kind, _, time) in zip(events, first):
        assert event.group(3) == kind and abs(float(event.group(1)) - time) <= 1e-9 * end


def test_equilibrium_at_the_start(train):
    package, scene = train("equilibrium")
    with package.unit() as unit:
        unit.initialise()
        for name, number in {
            "follower[1].y": 0.00551321179585351,
            "follower[2].psi": 0.704616882879973,
            "follower[3].y": -0.00770772910839558,
        }.items():
            assert abs(value(unit, scene, name) - number) <= 1e-12, name


def test_the_periodic_motion_at_the_start(train):
    package, scene = train("periodic")
    with package.unit() as unit:
        unit.initialise()
        for name, number in CASES["periodic"][1].items():
            assert abs(value(unit, scene, name) / number - 1) <= 1e-9, name


@pytest.mark.parametrize(
    ("speed", "on_the_cam", "force", "first"),
    [(2000, 1.0, 703.415, None), (2100, 0.99, 749.784, 0.0105828412), (2400, 0.691, 4708.940, 0.0088059412)],
)
def test_the_valve_train_leaves_its_cam(tmp_path, speed, on_the_cam, force, first):
    scene = ROOT / "examples" / "valve_train" / "scene.toml"
    subprocess.run([CAMDRIVE, "export", scene, "-o", tmp_path], check=True, capture_output=True)
    package = Package(tmp_path / "valve_train.fmu", tmp_path / "valve_train")
    with package.unit() as unit:
        unit.initialise(values={"drive.w": speed * math.pi / 30})
        forces, contacts, count = [], 0, 3000
        for i in range(count):
            unit.step_to(180 / speed * (i + 1) / count)
            forces.append(unit.get("follower[1].force"))
            contacts += unit.get("follower[1].contact")
        events = [m for m in (LINE.search(text) for _, category, text in unit.log if category == "logEvents") if m]
    assert abs(max(forces) - force) < 1e-3 and abs(contacts / count - on_the_cam) < 1e-3
    impacts = [float(m.group(1)) for m in events if m.group(3) == "impact"]
    assert impacts == [] if first is None else abs(impacts[0] - first) < 1e-9
