"""Compares linked.toml, from which an FMU has its licences, with the packages of the runtime library; then writes the
licences of all that a wheel links, with the texts of the packages themselves: licenses.py [FOLDER].
"""

import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

packaging = Path(__file__).resolve().parent
root = packaging.parent


def output(*command: str) -> str:
    return subprocess.run(command, cwd=root, check=True, capture_output=True, text=True).stdout


def tree(package: str, edges: str, line: str) -> list[str]:
    """What a package links on any platform, without what only builds and tests use."""
    return output("cargo", "tree", "--locked", "--package", package, "--edges", edges, "--target", "all",
                  "--prefix", "none", "--no-dedupe", "--format", line).splitlines()


def faults() -> list[str]:
    listed = tomllib.loads((packaging / "linked.toml").read_text())
    notices = (packaging / "third_party.txt").read_text()
    lines = [line.split("|") for line in tree("camdrive", "normal,no-proc-macro", "{p}|{l}")]
    licences = {package.split()[0]: licence for package, licence in lines if package.split()[0] != "camdrive"}
    found = [f"{name}: linked, but not in linked.toml" for name in licences.keys() - set(listed["packages"])]
    found += [f"{name}: in linked.toml, but not linked" for name in set(listed["packages"]) - licences.keys()]
    for name, licence in licences.items():
        if "Apache-2.0" not in re.split(" OR |/", licence):
            found.append(f"{name}: not to be had under the Apache licence, but {licence}")
    for name, _ in listed["in_standard_library"] + listed["by_linker"]:
        if not re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", notices):
            found.append(f"{name}: without a notice in third_party.txt")
    return found


if found := faults():
    sys.exit("\n".join(found))
if len(sys.argv) == 1:
    sys.exit()
folder = Path(sys.argv[1])
linked = {tuple(line.split()[:2]) for line in tree("camdrive-cli", "normal", "{p}")}
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
# What compilers and linkers add to every program, as in an FMU; and the font whose letters pictures have.
shutil.copy(packaging / "dejavu.txt", folder / "DEJAVU-FONTS.txt")
shutil.copy(packaging / "third_party.txt", folder / "STANDARD-LIBRARIES.txt")
for name in ["LICENSE-MIT", "LICENSE-APACHE"]:
    shutil.copy(root / name, folder)
standard_library = Path(output("rustc", "--print", "sysroot").strip(), "share/doc/rust/COPYRIGHT-library.html")
if standard_library.is_file():
    shutil.copy(standard_library, folder)
else:
    print(f"the licences of Rust's standard library are missing: no {standard_library}", file=sys.stderr)
