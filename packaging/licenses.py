"""Compares linked.toml, from which an FMU has its licences, and its bill of materials (CycloneDX) with the packages of the
runtime library; then writes the licences of all that a wheel links, with the texts of the packages themselves, into FOLDER, or
the bill: licenses.py [FOLDER | --bill].
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
LISTED = tomllib.loads((packaging / "linked.toml").read_text())
BILL = packaging / "camdrive.cdx.json"


def output(*command: str) -> str:
    return subprocess.run(command, cwd=root, check=True, capture_output=True, text=True).stdout


def tree(package: str, edges: str, line: str) -> list[str]:
    """The packages that a package links on any platform, except for builds and tests."""
    return output("cargo", "tree", "--locked", "--package", package, "--edges", edges, "--target", "all",
                  "--prefix", "none", "--no-dedupe", "--format", line).splitlines()


def component(name: str, licence: str, reference: str, **more: object) -> dict[str, object]:
    return {"type": "library", "bom-ref": reference, "name": name, "licenses": [{"expression": licence}], **more}


def bill() -> str:
    """The bill of materials of the runtime library; the export fills in {version}, {sources} and {rust}. A library that is no
    package has the version of the compiler or of the linker.
    """
    locked = {package["name"]: package for package in tomllib.loads((root / "Cargo.lock").read_text())["package"]
              if package["name"] in [*LISTED["packages"], "camdrive"]}
    locked["camdrive"]["version"] = "{version}"

    def reference(name: str) -> str:
        return f"pkg:cargo/{name}@{locked[name]['version']}"

    def linked(name: str) -> list[str]:
        needed = [dependency.split()[0] for dependency in locked[name].get("dependencies", [])]
        return [dependency for dependency in needed if dependency in LISTED["packages"]]

    names = ["camdrive"]
    for name in names:
        names += [other for other in linked(name) if other not in names]
    packages = []
    for name in names:
        sums = [{"alg": "SHA-256", "content": locked[name]["checksum"]}] if name != "camdrive" else []
        licence = "Apache-2.0" if sums else "MIT OR Apache-2.0"
        packages.append(component(name, licence, reference(name), version=locked[name]["version"], purl=reference(name),
                                  **({"hashes": sums} if sums else {})))
    own = packages.pop(0)
    own["properties"] = [{"name": "camdrive:sources", "value": "{sources}"}]
    inside, beside = ([component(name, licence, f"linked:{name}") for name, licence in LISTED[key]]
                      for key in ("in_standard_library", "by_linker"))
    rust = component("rust-std", "(MIT OR Apache-2.0) AND Unicode-3.0", "rust-std", version="{rust}", components=inside)
    dependencies = [{"ref": reference(name), "dependsOn": [*map(reference, linked(name)), "rust-std"]} for name in names]
    dependencies.append({"ref": "rust-std", "dependsOn": [other["bom-ref"] for other in inside + beside]})
    whole = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "metadata": {"component": own},
             "components": [*packages, rust, *beside], "dependencies": dependencies}
    return json.dumps(whole, indent=2, ensure_ascii=False, sort_keys=True) + "\n"


def faults() -> list[str]:
    notices = (packaging / "third_party.txt").read_text()
    lines = [line.split("|") for line in tree("camdrive", "normal,no-proc-macro", "{p}|{l}")]
    licences = {package.split()[0]: licence for package, licence in lines if package.split()[0] != "camdrive"}
    found = [f"{name}: linked, but not in linked.toml" for name in licences.keys() - set(LISTED["packages"])]
    found += [f"{name}: in linked.toml, but not linked" for name in set(LISTED["packages"]) - licences.keys()]
    for name, licence in licences.items():
        if "Apache-2.0" not in re.split(" OR |/", licence):
            found.append(f"{name}: not to be had under the Apache licence, but {licence}")
    for name, _ in LISTED["in_standard_library"] + LISTED["by_linker"]:
        if not re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", notices):
            found.append(f"{name}: without a notice in third_party.txt")
    if BILL.read_text() != bill():
        found.append(f"{BILL.name}: not the bill of Cargo.lock and linked.toml; `licenses.py --bill` writes that")
    return found


if sys.argv[1:] == ["--bill"]:
    BILL.write_text(bill())
    sys.exit()
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
    # A package may also have the licence of its data, in a separate folder.
    files = [file for file in sorted(home.rglob("*")) if file.name.upper().startswith(words)]
    for text in {file.read_text(errors="replace").strip() for file in files if file.is_file()} or {""}:
        texts.setdefault(text, []).append(name)
parts = []
for text, names in sorted(texts.items(), key=lambda item: (item[1], item[0])):
    parts.append("\n".join(sorted(names)) + "\n\n" + (text or "No separate text; the named licence applies."))
(folder / "THIRD-PARTY.txt").write_text(f"\n\n{'=' * 80}\n".join(parts) + "\n")
# The additions of compilers and linkers to every program, as in an FMU.
shutil.copy(packaging / "third_party.txt", folder / "STANDARD-LIBRARIES.txt")
for name in ["LICENSE-MIT", "LICENSE-APACHE"]:
    shutil.copy(root / name, folder)
standard_library = Path(output("rustc", "--print", "sysroot").strip(), "share/doc/rust/COPYRIGHT-library.html")
if standard_library.is_file():
    shutil.copy(standard_library, folder)
else:
    print(f"the licences of Rust's standard library are missing: no {standard_library}", file=sys.stderr)
