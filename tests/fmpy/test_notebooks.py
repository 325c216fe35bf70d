"""The notebooks of the examples: their code runs without Jupyter, prints what is stored, and leaves nothing behind."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NOTEBOOKS = sorted((EXAMPLES / "notebooks").glob("*.ipynb"))

# Runs the cells whose sources are a JSON list on stdin; the last line is the list of what each printed.
RUN = """
import contextlib, io, json, sys
printed, names = [], {"__name__": "__main__"}
for source in json.load(sys.stdin):
    with contextlib.redirect_stdout(io.StringIO()) as text:
        exec(compile(source, source.partition("\\n")[0], "exec"), names)
    printed.append(text.getvalue())
print(json.dumps(printed))
"""


def without_numbers(text):
    return re.sub(r"\s*[-+]?\d[\d.]*(e[-+]?\d+)?", " #", text)


@pytest.mark.skipif("CAMDRIVE_WHEEL" not in os.environ, reason="CAMDRIVE_WHEEL names no wheel")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_prints_what_is_stored(camdrive, tmp_path, path):
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    before = sorted(tmp_path.rglob("*"))
    cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
    done = subprocess.run(
        [sys.executable, "-c", RUN],
        input=json.dumps(["".join(cell["source"]) for cell in cells]),
        cwd=tmp_path / "examples" / "notebooks",
        env={**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": str(Path(camdrive.__file__).parents[1])},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    for cell, printed in zip(cells, json.loads(done.stdout.splitlines()[-1]), strict=True):
        stored = "".join(line for output in cell["outputs"] for line in output.get("text", ()))
        assert without_numbers(printed) == without_numbers(stored), "".join(cell["source"])
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_stored_notebook_is_executed_and_holds_nothing_of_the_machine(path):
    text = path.read_text()
    assert len(text) < 300_000 and not re.search(r"/tmp/|/home/|/root/|/work/|timestamp|iopub", text)
    cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    kinds = {(output["output_type"], output.get("name")) for cell in cells for output in cell["outputs"]}
    assert kinds <= {("stream", "stdout"), ("display_data", None), ("execute_result", None)}
    assert not any(cell["metadata"] for cell in cells)
