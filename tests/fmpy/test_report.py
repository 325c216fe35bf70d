"""Pages of reports in a browser: they ask nobody, tell the values of the study, and everybody can read them."""

import base64
import contextlib
import csv
import math
import os
import pty
import re
import shutil
import subprocess
import zipfile

import pytest

from browser import CHROMIUM, Page
from conftest import CAMDRIVE, ROOT

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
AXE = "axe-core@4.10.3"
EXAMPLES = ROOT / "examples"
SCENE = EXAMPLES / "guide_bar" / "scene.toml"
STUDY = """
scene = "scene.toml"
turns = 1
measures = ["max |q|", "rms der(y,2)"]
vary = [{ name = "drive.w", from = "900 rpm", to = "2400 rpm", count = 40 }]
"""
# Loads without mass are refused.
MAP = """
scene = "scene.toml"
turns = 1
measures = ["max |q|", "max |tau|"]
vary = [{ name = "drive.w", values = ["900 rpm", "1200 rpm", "1500 rpm"] }, { name = "m", values = [0, 8, 12] }]
"""
PAGES = ["scene.html", "system.html", "variants.html", "map.html", "study/guide_bar.html"]
# The one in an FMU runs nothing.
ALL = [*PAGES, "fmu/documentation/index.html"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The pages of a scene, a system and the variants of a scene, and the report of one study with its files."""
    folder = tmp_path_factory.mktemp("report")
    shutil.copy(SCENE, folder)
    (folder / "study.toml").write_text(STUDY)
    (folder / "map.toml").write_text(MAP)
    for command, file, *options in (
        ("report", SCENE, "-o", "scene.html"),
        ("report", EXAMPLES / "two_cams" / "system.toml", "-o", "system.html"),
        ("study", "study.toml", "-o", "store"),
        ("report", "store", "-o", "variants.html"),
        ("study", "map.toml", "-o", "maps"),
        ("report", "maps", "-o", "map.html"),
        ("export", SCENE, "-o", "guide_bar.fmu"),
        ("tradeoff", SCENE, "--quick", "--turns", "1", "-o", "study"),
    ):
        subprocess.run([CAMDRIVE, command, str(file), *options], check=True, capture_output=True, cwd=folder)
    with zipfile.ZipFile(folder / "guide_bar.fmu") as fmu:
        fmu.extract("documentation/index.html", folder / "fmu")
    return folder


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    page = Page(tmp_path_factory.mktemp("profile"))
    yield page
    page.close()


@pytest.fixture(scope="module")
def axe():
    """The source of a checker of accessibility, which npm fetches below target/."""
    if shutil.which("npm") is None:
        pytest.skip("no npm")
    place = ROOT / "target" / "axe"
    source = place / "node_modules" / "axe-core" / "axe.min.js"
    if not source.exists():
        place.mkdir(parents=True, exist_ok=True)
        fetched = subprocess.run(["npm", "install", "--no-save", "--prefix", str(place), AXE], capture_output=True)
        if fetched.returncode:
            pytest.skip(f"npm cannot fetch {AXE}")
    return source.read_text()


def violations(page, axe):
    """What hinders a reader of an open page, folded parts included."""
    page.run("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
    page.run(axe)
    rules = "{runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'best-practice']}"
    return page.run(f"axe.run(document, {rules}).then((found) => found.violations.map((v) => [v.id, v.nodes[0].html]))")


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("width", [400, 1600])
def test_it_is_read_at_any_width(folder, page, name, width):
    path = folder / name
    assert path.stat().st_size <= 300_000
    page.open(path, width)
    assert page.run("document.documentElement.scrollWidth") <= width
    # Pictures lie within the window as a whole.
    assert page.run("[...document.querySelectorAll('figure')].every((e) => e.scrollWidth <= e.clientWidth)")
    smallest = "Math.min(...[...document.querySelectorAll('p, li, td, dd')].map((e) => parseFloat(getComputedStyle(e).fontSize)))"
    assert page.run(smallest) >= 14
    assert page.messages == []


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize(("width", "scheme"), [(400, "light"), (1600, "light"), (1600, "dark")])
def test_everybody_can_read_it(folder, page, axe, name, width, scheme):
    page.media("", scheme)
    page.open(folder / name, width)
    found = violations(page, axe)
    page.media("")
    assert found == []


def numbers(tip):
    """Name, x and y of what was read."""
    name, x, y = tip.split("\n")
    return name, *(float(text.rsplit(": ", 1)[1].split(" ")[0]) for text in (x, y))


def test_the_pointer_and_the_keyboard_read_values(folder, page):
    path = folder / "study" / "guide_bar.html"
    page.open(path, 1600)
    known = []
    for table, value in (("settings", "error"), ("features", "change")):
        with open(folder / "study" / f"guide_bar.{table}.csv", newline="") as file:
            for row in filter(lambda row: row[value] and row["cost_ns_per_ms"], csv.DictReader(file)):
                # What is smaller than what is known stands there.
                known += [[float(row[key]), float(row["cost_ns_per_ms"])] for key in (value, "known_to")]
    is_known = lambda x, y: any(math.isclose(x, a, rel_tol=2e-3) and math.isclose(y, b, rel_tol=2e-3) for a, b in known)
    # The pointer on the first point of the first line, where the picture has it.
    place = page.run("""(async () => {
        const figure = document.querySelector('figure[data-x]'), svg = figure.querySelector('svg');
        svg.scrollIntoView({ block: 'center' });
        // What is read vanishes when the page moves, which it tells a picture later.
        for (let i = 0; i < 3; i++) await new Promise(requestAnimationFrame);
        const [x, y] = [figure.dataset.x, figure.dataset.y].map((text) => text.split(' ').slice(0, 4).map(Number));
        const point = figure.querySelector('data').value.split(' ')[0].split(',').map(Number);
        const at = svg.createSVGPoint();
        const pixel = ([first, last, low, high], value) => first + (Math.log10(value) - low) / (high - low) * (last - first);
        [at.x, at.y] = [pixel(x, point[0]), pixel(y, point[1])];
        const there = at.matrixTransform(svg.getScreenCTM());
        return [there.x, there.y];
    })()""")
    page.point(*place)
    name, error, cost = numbers(page.run("document.getElementById('tip').textContent"))
    assert name and is_known(error, cost), (name, error, cost)
    # By the keyboard every point of every line.
    page.run("document.querySelector('figure[data-x]').focus()")
    lines = page.run("document.querySelectorAll('figure[data-x] data').length")
    read = set()
    for key in ["End", "ArrowLeft", "ArrowDown", "ArrowRight"] * lines:
        page.press(key)
        read.add(numbers(page.run("document.getElementById('tip').textContent")))
    assert len(read) > 4 and all(is_known(x, y) for _, x, y in read), read


@pytest.mark.parametrize("name", PAGES)
def test_all_tables_sort_and_all_diagrams_tell(folder, page, name):
    page.open(folder / name, 1600)
    page.run("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
    for i in range(page.run("document.querySelectorAll('table').length")):
        values = f"""[...document.querySelectorAll('table')[{i}].tBodies[0].rows]
            .map((row) => parseFloat(row.cells[COLUMN].dataset.v)).map((x) => Number.isFinite(x) ? x : null)"""
        for column in range(page.run(f"document.querySelectorAll('table')[{i}].tHead.rows[0].cells.length")):
            before = page.run(values.replace("COLUMN", str(column)))
            page.run(f"document.querySelectorAll('table')[{i}].tHead.rows[0].cells[{column}].firstChild.focus()")
            page.press("Enter")
            if None not in before:
                assert page.run(values.replace("COLUMN", str(column))) == sorted(before)
    for i in range(page.run("document.querySelectorAll('figure[data-x]').length")):
        # What is read vanishes when the page moves, which it tells a picture later.
        page.run(f"""(async () => {{
            document.querySelectorAll('figure[data-x]')[{i}].focus();
            for (let i = 0; i < 3; i++) await new Promise(requestAnimationFrame);
        }})()""")
        page.press("ArrowRight")
        told = page.run("document.getElementById('tip').textContent").split("\n")
        points = page.run(f"""[...document.querySelectorAll('figure[data-x]')[{i}].querySelectorAll('data')]
            .flatMap((data) => data.value.split(/[ ;]/)).map((point) => point.split(',').map(Number))""")
        number = lambda text: float(text.rsplit(": ", 1)[1].split(" ")[0].rstrip("°"))
        size = [max(abs(point[k]) for point in points) for k in range(2)]
        near = lambda point: all(abs(number(told[k - 2]) - point[k]) <= 1e-3 * size[k] for k in range(2))
        assert any(map(near, points)), told
    assert page.messages == []


def test_tables_sort_by_the_keyboard_and_tell_all_digits(folder, page):
    page.open(folder / "study" / "guide_bar.html", 1600)
    heads = page.run("[...document.querySelectorAll('table')[0].tHead.rows[0].cells].map((cell) => cell.textContent)")
    column = next(i for i, head in enumerate(heads) if head.startswith("cost"))
    cells = f"[...document.querySelectorAll('table')[0].tBodies[0].rows].map((row) => row.cells[{column}])"
    values = f"{cells}.map((cell) => cell.dataset.v).filter(Boolean).map(Number)"
    # Tab reaches the heading from the one before.
    page.run(f"document.querySelectorAll('table')[0].tHead.rows[0].cells[{column - 1}].firstChild.focus()")
    page.press("Tab")
    for order, sign in (("ascending", 1), ("descending", -1)):
        page.press("Enter")
        assert page.run(f"document.querySelectorAll('table')[0].tHead.rows[0].cells[{column}].ariaSort") == order
        found = page.run(values)
        assert len(found) > 2 and found == sorted(found, key=lambda value: sign * value)
    with open(folder / "study" / "guide_bar.settings.csv", newline="") as file:
        costs = {float(row["cost_ns_per_ms"]) for row in csv.DictReader(file) if row["cost_ns_per_ms"]}
    assert set(found) == costs
    page.run(f"{cells}[0].focus()")
    assert page.run("document.getElementById('tip').textContent") == f"{found[0]!r} ns/ms".replace(".0 ", " ")
    page.press("ArrowDown")
    assert page.run("document.getElementById('tip').textContent") == f"{found[1]!r} ns/ms".replace(".0 ", " ")


@pytest.mark.parametrize("name", ALL)
def test_a_print_shows_all(folder, page, name):
    """Nothing is folded away or cut on paper: all words of the page and the last column of every table."""
    page.open(folder / name, 1600)
    page.call("Page.printToPDF", preferCSSPageSize=True)
    assert page.run("[...document.querySelectorAll('details')].every((part) => part.open)")
    page.media("print")
    # 180 mm between the margins.
    page.call("Emulation.setDeviceMetricsOverride", width=680, height=1000, deviceScaleFactor=1, mobile=False)
    wide = page.run("[...document.querySelectorAll('table, svg')].map((e) => e.getBoundingClientRect().right).filter((x) => x > 680)")
    page.media("")
    assert wide == []


def light(page, mark):
    """The mean of red, green and blue (0 to 255) of the window, as the browser paints it."""
    shot = page.call("Page.captureScreenshot", format="png", clip={"x": 0, "y": mark, "width": 400, "height": 300, "scale": 1})
    return page.run(f"""(async () => {{
        const image = await createImageBitmap(await (await fetch('data:image/png;base64,{shot["data"]}')).blob());
        const canvas = new OffscreenCanvas(image.width, image.height).getContext('2d');
        canvas.drawImage(image, 0, 0);
        const all = canvas.getImageData(0, 0, image.width, image.height).data.filter((_, i) => i % 4 < 3);
        return all.reduce((sum, value) => sum + value, 0) / all.length;
    }})()""")


def test_pages_and_diagrams_are_dark_where_the_reader_wants_it(folder, page):
    page.open(folder / "scene.html", 400)
    figure = page.run("document.querySelector('figure').getBoundingClientRect().top + scrollY")
    shown = {}
    for media, scheme in (("", "light"), ("", "dark"), ("print", "dark")):
        page.media(media, scheme)
        shown[media, scheme] = [light(page, 0), light(page, figure)]
    page.media("")
    assert all(value > 200 for value in shown["", "light"] + shown["print", "dark"]), shown
    assert all(value < 80 for value in shown["", "dark"]), shown


@pytest.mark.parametrize("name", ["README", "guide_bar", "tappet", "backlash_drive", "transfer_manipulator", "valve_train", "rod_drive"])
def test_a_drive_with_one_follower_prints_on_four_pages(page, tmp_path, name):
    scene = EXAMPLES / name / "scene.toml"
    if name == "README":
        scene = tmp_path / "guide_bar.toml"
        scene.write_text(re.search("```toml\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)[1])
    subprocess.run([CAMDRIVE, "report", str(scene), "-o", "page.html"], check=True, capture_output=True, cwd=tmp_path)
    page.open(tmp_path / "page.html", 1600)
    paper = base64.b64decode(page.call("Page.printToPDF", preferCSSPageSize=True)["data"])
    assert 1 <= len(re.findall(rb"/Type */Page\b", paper)) <= 4


def test_a_map_tells_its_cells(folder, page):
    page.open(folder / "map.html", 1000)
    texts = "[...document.querySelectorAll('figure')].map((figure) => [...figure.querySelectorAll('text')].map((e) => e.textContent))"
    for words, measure in zip(page.run(texts), ("max |q| [mm]", "max |tau| [N·m]"), strict=True):
        assert {measure, "drive.w [rpm]", "m [kg]", "refused or failed"} <= set(words)
    page.run("document.querySelector('figure').focus()")
    told = []
    for key in ("End", "ArrowDown", "ArrowDown"):
        page.press(key)
        told.append(page.run("document.getElementById('tip').textContent").split("\n"))
    assert [words[0].split(": ")[0] for words in told] == ["max |q|", "max |q|", "refused or failed"], told
    assert [words[1:] for words in told] == [["drive.w: 1500 rpm", f"m: {m} kg"] for m in (8, 12, 0)], told


def test_long_commands_show_their_progress(folder):
    """On a terminal a bar with the name of the scene and the stage; elsewhere nothing."""
    ours, theirs = pty.openpty()
    command = [CAMDRIVE, "tradeoff", str(SCENE), "--quick", "--turns", "1"]
    ran = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=theirs, env=os.environ | {"TERM": "xterm"})
    os.close(theirs)
    shown = b""
    # Reading fails when nobody is left at the other end.
    with contextlib.suppress(OSError):
        while part := os.read(ours, 1 << 16):
            shown += part
    os.close(ours)
    assert ran.wait() == 0
    # The name, the stage, the bar and the time.
    assert re.search(r"guide_bar +[a-z]+[^\n]*[█░][^\n]*\d+s", shown.decode()), shown
    quiet = subprocess.run(command, cwd=folder, capture_output=True, check=True)
    assert b"\r" not in quiet.stderr and "█".encode() not in quiet.stderr
