"""Every block of README.md and of the pages in docs runs as it stands, in an empty folder, and prints what the text says. The
commands of the examples run. Links lead to files and headings."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import CAMDRIVE, ROOT

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# Stands for lines that are left out.
GAP = "[…]"


def agrees(expected, printed):
    """Whether the lines are those that were printed, but for gaps and colours."""
    parts = [part.strip("\n") for part in expected.split(GAP)]
    pattern = ".*".join(re.escape(part) for part in parts)
    return re.fullmatch(pattern, printed.strip("\n"), re.DOTALL) is not None


def run(command, folder, path):
    search = f"{Path(CAMDRIVE).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": search, "PYTHONPATH": path, "COLUMNS": "100"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, f"{command}: {done.stderr}"
    return done.stdout


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_block_runs_and_prints_what_stands_there(page, camdrive, tmp_path):
    text = page.read_text()
    package = str(Path(camdrive.__file__).parents[1])
    python, unused = None, set()
    for block in BLOCK.finditer(text):
        kind, content = block.groups()
        if kind == "toml":
            # The text before it says what it is called.
            name = re.findall(r"`(\w+\.toml)`", text[: block.start()])[-1]
            (tmp_path / name).write_text(content)
            unused.add(name)
        elif kind == "console":
            for command, expected in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", content, re.MULTILINE):
                printed = run(command.split(), tmp_path, package)
                assert agrees(expected, printed), f"{command}:\n{printed}"
                unused -= set(command.split())
        elif kind == "python":
            assert python is None, "a block of Python without what it prints"
            python = run([sys.executable, "-W", "error::SyntaxWarning", "-c", content], tmp_path, package)
        else:
            assert python is not None and agrees(content, python), f"{content}\n{python}"
            python = None
    assert python is None, "a block of Python without what it prints"
    assert not unused, "no command reads these files"


# Those that take seconds and need no results of others; other tests run the rest.
SHORT = re.compile(r"^camdrive ((?:export|check|forces|run|system|cam|clearance) .*examples/.*)$", re.MULTILINE)


@pytest.mark.parametrize("page", sorted(ROOT.glob("examples/*/README.md")), ids=lambda page: page.parent.name)
def test_commands_of_the_examples_run(page, tmp_path):
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    for command in SHORT.findall("".join(content for _, content in BLOCK.findall(page.read_text()))):
        done = subprocess.run(["bash", "-c", f"{CAMDRIVE} {command}"], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}: {done.stderr}"


def anchors(page):
    """The names under which a page's headings are reached."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


LISTED = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()


@pytest.mark.parametrize("page", LISTED)
def test_every_link_leads_to_a_file_and_a_heading(page):
    page = ROOT / page
    for link, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)\s]*))?\)", page.read_text()):
        if not link.startswith(("http", "mailto")):
            target = page.parent / link if link else page
            assert target.exists(), link
            assert not anchor or anchor in anchors(target / "README.md" if target.is_dir() else target), f"{link}#{anchor}"
