"""Pages that compute, in a browser: every example, each of its sliders, the numbers of `steady`, and the messages of the reader."""

import json
import re
import subprocess
import time
import zipfile

import pytest

from browser import CHROMIUM, Page
from conftest import CAMDRIVE, ROOT
from test_report import axe, violations  # noqa: F401

EXAMPLES = ROOT / "examples"
MODULE = ROOT / "target" / "runtimes" / "wasm" / "camdrive.wasm.lzma"
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium"),
    pytest.mark.skipif(not MODULE.exists(), reason="no module of pages: packaging/build wasm"),
]
SCENES = sorted(
    path for path in EXAMPLES.glob("*/*.toml")
    if re.search(r"^model\s*=", path.read_text(), re.M) and not re.search(r"^objective", path.read_text(), re.M)
)
LARGEST = 900_000
# Of the largest number in a row: sines of the browser differ in the last digit.
BOUND = 1e-10
# Multipliers of a turn are known as parts of 1.
ROWS = """[...document.querySelectorAll('#live tr')].map((row) => [...row.querySelectorAll('[data-v]')].map((e) => parseFloat(e.dataset.v))
    .concat(row.closest('table').ariaLabel.startsWith('Floquet') ? 1 : []))"""
TURN = """[...document.querySelectorAll('#live table[aria-label="Over the turn"] tbody tr')].map((row) =>
    [row.cells[0].textContent, ...[...row.querySelectorAll('[data-v]')].map((e) => parseFloat(e.dataset.v))])"""
MOVE = """(() => {
    const slider = document.querySelectorAll('#dials input[type=range]')[%d], share = %f;
    slider.value = +slider.min + (slider.max - slider.min) * share;
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    return slider.dataset.key;
})()"""
TYPE = """(() => {
    const field = document.querySelector('#dials input[type=text][data-key="%s"]');
    field.value = %s;
    field.dispatchEvent(new Event('input', { bubbles: true }));
})()"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    page = Page(tmp_path_factory.mktemp("profile"))
    yield page
    page.close()


def made(scene, folder):
    path = folder / "live.html"
    subprocess.run([CAMDRIVE, "report", scene, "--live", "--force", "-o", path], check=True, capture_output=True)
    return path


def wait(page, condition):
    for _ in range(1200):
        if page.run(condition):
            return
        time.sleep(0.05)
    raise AssertionError(page.run("document.getElementById('state').textContent"))


def opened(page, path, width=1400, address=""):
    page.open(path, width, address)
    wait(page, "!document.getElementById('dials').hidden")


def settled(page):
    """The page has answered: it shows the values or says why not."""
    wait(page, "!document.getElementById('state').textContent.startsWith('Computing')")


def drawn(page, change):
    """The diagrams have followed a change, or the page says why not."""
    before = page.run("performance.getEntriesByName('redraw').length")
    found = page.run(change)
    wait(page, f"performance.getEntriesByName('redraw').length > {before} || !document.getElementById('state').textContent.startsWith('Computing')")
    return found


def close(a, b):
    """Infinite numbers, as the quality of an undamped resonance, are none in JSON."""
    size = max((abs(x) for x in [*a, *b] if x is not None), default=0.0)
    same = (x == y if x is None or y is None else abs(x - y) <= BOUND * size for x, y in zip(a, b))
    return len(a) == len(b) and all(same)


@pytest.mark.parametrize("scene", SCENES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_each_slider_of_each_example_is_followed(scene, page, tmp_path):
    path = made(scene, tmp_path)
    opened(page, path)
    native, said = page.run(ROWS), page.run("document.getElementById('live').textContent")
    # A change and its return: the browser computes the scene of the file.
    key = page.run("document.querySelector('#dials input[type=text]').dataset.key")
    own = page.run("document.querySelector('#dials input[type=text]').value")
    page.run(TYPE % (key, json.dumps(own + " ")))
    settled(page)
    rows = page.run(ROWS)
    # Where disturbances grow, the last digit of a sine decides whether the search for a motion ends.
    repeats = "does not repeat" not in said + page.run("document.getElementById('live').textContent")
    if repeats or scene != EXAMPLES / "backlash_machine" / "train.toml":
        assert len(native) == len(rows) and sum(map(len, native)) > 10
        assert all(close(a, b) for a, b in zip(native, rows))
    drawn(page, "document.getElementById('dials').reset()")
    for k in range(page.run("document.querySelectorAll('#dials input[type=range]').length")):
        key = drawn(page, MOVE % (k, 0.3))
        # What the reader refuses, such as angles that do not fill the turn, is told at its field or above.
        assert key in page.run("decodeURIComponent(location.hash)") or key.split(".")[-1] in page.run("decodeURIComponent(location.hash)")
        told = page.run("document.getElementById('state').textContent + [...document.querySelectorAll('.fault')].map((e) => e.textContent)")
        assert told.startswith(("Computing", "Thin lines")) or "`" in told or "admissible" in told, (key, told)
        drawn(page, "document.getElementById('dials').reset()")
    settled(page)
    assert page.messages == []
    redraws = sorted(page.run("performance.getEntriesByName('redraw').map((e) => e.duration)"))
    print(f"{scene.parent.name}/{scene.stem}: {path.stat().st_size} bytes, redraw {redraws[len(redraws) // 2]:.0f} ms")


def test_the_numbers_are_those_of_steady_and_the_address_keeps_them(page, tmp_path):
    scene = EXAMPLES / "guide_bar" / "scene.toml"
    path = made(scene, tmp_path)
    opened(page, path)
    page.run(TYPE % ("drive.speed", '"1900 rpm"'))
    settled(page)
    assert page.run("location.hash") == "#speed=1900rpm"
    found = subprocess.run([CAMDRIVE, "steady", scene, "--speed", "1900 rpm", "--json"], check=True, capture_output=True, text=True)
    outputs = {of["output"]: of for of in json.loads(found.stdout)["turn"]["outputs"]}
    shown = {row[0].split(" ")[0]: row[1:] for row in page.run(TURN)}
    factor = {"x": 1e3, "y": 1e3, "q": 1e3}
    for name, row in shown.items():
        of, times = outputs[name], factor.get(name, 1.0)
        assert close([of[key] * times for key in ("least", "largest", "mean", "rms")], row), name
    # The link shows the same; a later Reset does not.
    before = page.run(TURN)
    opened(page, path.rename(tmp_path / "link.html"), address="#speed=1900rpm")
    settled(page)
    assert page.run(TURN) == before
    page.run("document.getElementById('copy').click()")
    assert page.run("document.getElementById('copied').value") == '[drive]\nspeed = "1900 rpm"'
    page.run("document.getElementById('dials').reset()")
    settled(page)
    assert page.run("location.hash") == "" and page.run(TURN) != before


@pytest.mark.parametrize(("value", "words"), [
    ("1800 mm", "is a length; an angular velocity is expected"),
    ("fast", "does not start with a finite number"),
    ("1e9 rpm", "is out of range; admissible: "),
])
def test_wrong_numbers_get_the_message_of_the_reader(page, tmp_path, value, words):
    opened(page, made(EXAMPLES / "guide_bar" / "scene.toml", tmp_path))
    before = page.run(TURN)
    page.run(TYPE % ("drive.speed", json.dumps(value)))
    wait(page, "document.querySelector('.fault').textContent")
    assert words in page.run("document.querySelector('.fault').textContent")
    assert page.run("document.querySelector('[data-key=\"drive.speed\"]').getAttribute('aria-invalid')") == "true"
    settled(page)
    assert page.run(TURN) == before and page.messages == []


@pytest.mark.parametrize("width", [400, 1600])
def test_it_fits_the_window_and_the_keyboard_moves_it(page, tmp_path, width):
    path = made(EXAMPLES / "valve_train" / "scene.toml", tmp_path)
    opened(page, path, width)
    assert page.run("document.documentElement.scrollWidth") <= width
    page.run("document.querySelector('input[type=range]').focus()")
    page.press("ArrowRight")
    settled(page)
    assert page.run("location.hash").startswith("#speed=")
    assert page.run("[...document.querySelectorAll('#dials input')].every((e) => e.labels.length || e.ariaLabel)")


@pytest.mark.parametrize(("width", "scheme"), [(400, "light"), (1600, "dark")])
def test_everybody_can_use_it(page, axe, tmp_path, width, scheme):
    page.media("", scheme)
    opened(page, made(EXAMPLES / "guide_bar" / "scene.toml", tmp_path), width)
    page.run(MOVE % (0, 0.4))
    settled(page)
    found = violations(page, axe)
    page.media("")
    assert found == []


def test_a_number_of_a_list_moves_and_is_copied_with_its_list(page, tmp_path):
    scene = EXAMPLES / "guide_bar" / "scene.toml"
    opened(page, made(scene, tmp_path))
    before = page.run(TURN)
    page.run(TYPE % ("cam.a[3]", '"-0.09"'))
    settled(page)
    page.run("document.getElementById('copy').click()")
    copied = page.run("document.getElementById('copied').value")
    assert copied == "[cam]\na = [0, 0.5867065, 0, -0.09, 0, 0.0115306]"
    changed = tmp_path / "changed.toml"
    changed.write_text(re.sub(r"(?m)^a = .*$", copied.split("\n")[1], scene.read_text()))
    found = subprocess.run([CAMDRIVE, "steady", changed, "--json"], check=True, capture_output=True, text=True)
    largest = {of["output"]: of["largest"] for of in json.loads(found.stdout)["turn"]["outputs"]}
    row = next(row for row in page.run(TURN) if row[0].startswith("q"))
    assert row != next(row for row in before if row[0].startswith("q"))
    assert abs(row[2] / (1e3 * largest["q"]) - 1.0) < BOUND
    page.run(TYPE % ("cam.a[3]", '"much"'))
    wait(page, "document.querySelector('.fault:not(:empty)') !== null")
    assert "cam.a[3]" in page.run("document.querySelector('.fault:not(:empty)').parentNode.querySelector('input').dataset.key")
    # Whole numbers of a list are numbers of the scene, too.
    assert page.messages == []


def test_a_plain_zero_has_the_unit_of_its_neighbours_and_links_keep_the_values(page, tmp_path):
    opened(page, made(EXAMPLES / "backlash_machine" / "pusher.toml", tmp_path))
    assert page.run("document.querySelector('#dials input[type=text][data-key=\"cam.a[0]\"]').value") == "0 mm"
    page.run(TYPE % ("cam.a[0]", '"1 mm"'))
    settled(page)
    before = page.run("location.hash")
    page.run("document.querySelector('nav a').click()")
    assert "1mm" in before and page.run("document.querySelector('#dials input[data-key=\"cam.a[0]\"]').value") == "1 mm"
    # The slider keeps the unit of the file.
    page.run(TYPE % ("cam.a[0]", '"0.001 m"'))
    page.run("""(() => { const slider = document.querySelector('#dials input[type=range][data-key="cam.a[0]"]');
        slider.value = 2; slider.dispatchEvent(new Event('input', { bubbles: true })); })()""")
    assert page.run("document.querySelector('#dials input[data-key=\"cam.a[0]\"]').value") == "2 mm"


def test_the_example_vibrates_as_its_text_says(page, tmp_path):
    folder = EXAMPLES / "live"
    text = (folder / "README.md").read_text()
    opened(page, made(folder / "scene.toml", tmp_path))
    dwells = page.run("""[...document.querySelectorAll('#live table[aria-label="Vibration in the dwells"] tbody tr')].map((row) =>
        parseFloat(row.cells[3].textContent))""")
    assert [f"{1e3 * of:.0f} µm" for of in dwells] == ["32 µm"] * 2 and "by 32 µm" in text
    assert page.run("document.querySelectorAll('figure[data-key^=spectrum]').length") == 1
    rows = page.run("[...document.querySelectorAll('#live tr')].map((row) => row.textContent)")
    assert any("23" in row and "268" in row for row in rows) and "harmonic 23 at 268 rpm" in text


def test_a_browser_without_wasm_shows_the_page_and_one_sentence(page, tmp_path):
    path = made(EXAMPLES / "guide_bar" / "scene.toml", tmp_path)
    script = page.call("Page.addScriptToEvaluateOnNewDocument", source="delete globalThis.WebAssembly")
    page.open(path, 1400)
    time.sleep(0.3)
    page.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script["identifier"])
    assert page.run("document.getElementById('dials').hidden")
    assert "WebAssembly" in page.run("document.getElementById('state').textContent")
    assert page.run("document.querySelectorAll('#live figure').length") > 2 and page.messages == []


def test_an_fmu_brings_its_page(page, tmp_path):
    scene = EXAMPLES / "guide_bar" / "scene.toml"
    for option, there in (("--no-live", False), ("--terminals", True)):
        subprocess.run([CAMDRIVE, "export", scene, option, "-o", tmp_path / "bar.fmu"], check=True, capture_output=True)
        with zipfile.ZipFile(tmp_path / "bar.fmu") as fmu:
            assert ("documentation/live.html" in fmu.namelist()) == there
            assert (b"Try it" in fmu.read("documentation/index.html")) == there
            fmu.extractall(tmp_path / "bar")
    live = tmp_path / "bar" / "documentation" / "live.html"
    assert live.stat().st_size <= LARGEST
    opened(page, live)
    page.run(MOVE % (0, 0.5))
    settled(page)
    assert "Thin lines" in page.run("document.getElementById('state').textContent") and page.messages == []


def test_a_point_of_a_study_opens_its_variant(page, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text((EXAMPLES / "guide_bar" / "scene.toml").read_text())
    (tmp_path / "study.toml").write_text(
        'scene = "scene.toml"\nturns = 1\nmeasures = ["max |q|"]\n'
        'vary = [{ name = "drive.w", values = ["900 rpm", "1200 rpm"] }, { name = "m", values = [8, 12] }]\n'
    )
    for command in (["study", "study.toml"], ["report", "study.toml", "--live"]):
        subprocess.run([CAMDRIVE, *command], check=True, capture_output=True, cwd=tmp_path)
    page.open(next(tmp_path.glob("study-*.html")), 1400)
    page.run("document.querySelector('figure[data-x]').focus()")
    page.press("ArrowRight")
    page.press("Enter")
    wait(page, "location.pathname.endsWith('guide_bar.live.html') && document.getElementById('dials')?.hidden === false")
    settled(page)
    field = "document.querySelector('#dials input[type=text][data-key=\"%s\"]').value"
    assert page.run(field % "drive.speed").endswith(" rpm") and page.run(field % "elasticity.m") in ("8 kg", "12 kg")
    assert page.run(field % "drive.speed") in ("900 rpm", "1200 rpm")
    assert "Thin lines" in page.run("document.getElementById('state').textContent") and page.messages == []
