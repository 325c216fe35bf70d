"""Every block of README.md runs as it stands, in an empty folder, and prints what the text says."""

import os
import re
import subprocess
import sys
from pathlib import Path

from conftest import CAMDRIVE, ROOT

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
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


def test_every_block_runs_and_prints_what_stands_there(camdrive, tmp_path):
    text = (ROOT / "README.md").read_text()
    package = str(Path(camdrive.__file__).parents[1])
    blocks = BLOCK.findall(text)
    # The only block that needs this repository.
    assert blocks[0] == ("", "cargo run --release -- export examples/guide_bar/scene.toml\n")
    python, counts = None, {"toml": 0, "console": 0, "python": 0}
    for kind, block in blocks[1:]:
        counts[kind] = counts.get(kind, 0) + 1
        if kind == "toml":
            before = text[: text.index(block)]
            name = re.findall(r"`(\w+\.toml)`", before)[-1]
            (tmp_path / name).write_text(block)
            run([CAMDRIVE, "export", name], tmp_path, package)
        elif kind == "console":
            for command, expected in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE):
                printed = run(command.split(), tmp_path, package)
                assert agrees(expected, printed), f"{command}:\n{printed}"
        elif kind == "python":
            python = run([sys.executable, "-W", "error::SyntaxWarning", "-c", block], tmp_path, package)
        else:
            assert python is not None and agrees(block, python), f"{block}\n{python}"
            python = None
    assert python is None, "a block of Python without what it prints"
    assert counts["toml"] >= 1 and counts["console"] >= 1 and counts["python"] >= 2, counts


def test_every_link_of_readme_and_docs_leads_to_a_file():
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text()):
            assert link.startswith("http") or (page.parent / link).exists(), f"{page.name}: {link}"
