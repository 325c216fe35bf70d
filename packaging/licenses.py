"""Writes the licences of all that a wheel links, with the texts of the packages themselves: licenses.py FOLDER."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

folder = Path(sys.argv[1])
root = Path(__file__).resolve().parents[1]


def output(*command: str) -> str:
    return subprocess.run(command, cwd=root, check=True, capture_output=True, text=True).stdout


# What is linked on any platform, without what only builds and tests use.
tree = output("cargo", "tree", "--locked", "--package", "camdrive-cli", "--edges", "normal", "--target", "all",
              "--prefix", "none", "--format", "{p}")
linked = {tuple(line.split()[:2]) for line in tree.splitlines() if line}
texts: dict[str, list[str]] = {}
for package in json.loads(output("cargo", "metadata", "--locked", "--format-version", "1"))["packages"]:
    if package["source"] is None or (package["name"], "v" + package["version"]) not in linked:
        continue
    home = Path(package["manifest_path"]).parent
    name = f"{package['name']} {package['version']} ({package['license']})"
    words = ("LICEN", "COPY", "NOTICE", "UNLICENSE")
    # A package may have the licence of its data beside these, in a folder of its own.
    files = [file for file in sorted(home.rglob("*")) if file.name.upper().startswith(words)]
    for text in {file.read_text(errors="replace").strip() for file in files if file.is_file()} or {""}:
        texts.setdefault(text, []).append(name)
parts = []
for text, names in sorted(texts.items(), key=lambda item: (item[1], item[0])):
    parts.append("\n".join(sorted(names)) + "\n\n" + (text or "Without a text of its own: that of the licence named."))
(folder / "THIRD-PARTY.txt").write_text(f"\n\n{'=' * 80}\n".join(parts) + "\n")
# What compilers and linkers add to every program, as in an FMU.
shutil.copy(root / "cli/src/export/third_party.txt", folder / "STANDARD-LIBRARIES.txt")
for name in ["LICENSE-MIT", "LICENSE-APACHE"]:
    shutil.copy(root / name, folder)
standard_library = Path(output("rustc", "--print", "sysroot").strip(), "share/doc/rust/COPYRIGHT-library.html")
if standard_library.is_file():
    shutil.copy(standard_library, folder)
else:
    print(f"the licences of Rust's standard library are missing: no {standard_library}", file=sys.stderr)
