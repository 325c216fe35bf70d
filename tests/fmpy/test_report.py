"""Pages of reports in a browser: they ask nobody, tell the values of the study, and everybody can read them."""

import csv
import math
import shutil
import subprocess

import pytest

from browser import CHROMIUM, Page
from conftest import CAMDRIVE, ROOT

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
AXE = "axe-core@4.10.3"
SCENE = ROOT / "examples" / "guide_bar" / "scene.toml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The page of a scene, and the report of one study with its files."""
    folder = tmp_path_factory.mktemp("report")
    for command in (["report", "-o", "page.html"], ["tradeoff", "--quick", "--turns", "1", "-o", "study"]):
        subprocess.run([CAMDRIVE, command[0], str(SCENE), *command[1:]], check=True, capture_output=True, cwd=folder)
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


@pytest.mark.parametrize("width", [400, 1600])
def test_it_is_read_at_any_width(folder, page, width):
    for path in (folder / "page.html", folder / "study" / "guide_bar.html"):
        assert path.stat().st_size <= 300_000
        page.open(path, width)
        assert page.run("document.documentElement.scrollWidth") <= width
        smallest = "Math.min(...[...document.querySelectorAll('p, li, td, dd')].map((e) => parseFloat(getComputedStyle(e).fontSize)))"
        assert page.run(smallest) >= 14
        assert page.messages == []


@pytest.mark.parametrize("width", [400, 1600])
def test_everybody_can_read_it(folder, page, axe, width):
    page.open(folder / "page.html", width)
    page.run("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
    page.run(axe)
    rules = "{runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'best-practice']}"
    found = page.run(f"axe.run(document, {rules}).then((found) => found.violations.map((v) => [v.id, v.nodes[0].html]))")
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


def test_a_print_shows_all(folder, page):
    """Nothing is folded away or cut on paper: all words of the page and the last column of every table."""
    page.open(folder / "page.html", 1600)
    page.call("Page.printToPDF", preferCSSPageSize=True)
    assert page.run("[...document.querySelectorAll('details')].every((part) => part.open)")
    page.call("Emulation.setEmulatedMedia", media="print")
    # 180 mm between the margins.
    page.call("Emulation.setDeviceMetricsOverride", width=680, height=1000, deviceScaleFactor=1, mobile=False)
    wide = page.run("[...document.querySelectorAll('table, svg')].map((e) => e.getBoundingClientRect().right).filter((x) => x > 680)")
    page.call("Emulation.setEmulatedMedia", media="")
    assert wide == []
