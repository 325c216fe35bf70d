"""Compares linked.toml, from which an FMU has its licences, and its bills of materials (CycloneDX) with the packages of the
runtime library and of the module of pages; then writes the licences of all that a wheel links, with the texts of the packages
themselves, into FOLDER, or the bills and the licences of the module: licenses.py [FOLDER | --bill].
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
BILL_OF_PAGE = packaging / "page.cdx.json"
LICENCES_OF_PAGE = packaging / "page_licenses.txt"
WASM = "wasm32-unknown-unknown"


def output(*command: str) -> str:
    return subprocess.run(command, cwd=root, check=True, capture_output=True, text=True).stdout


def tree(package: str, edges: str, line: str, target: str = "all") -> list[str]:
    """The packages that a package links on any platform or one, except for builds and tests."""
    return output("cargo", "tree", "--locked", "--package", package, "--edges", edges, "--target", target,
                  "--prefix", "none", "--no-dedupe", "--format", line).splitlines()


def licences(package: str, target: str = "all") -> dict[str, str]:
    """The licence under which each package of the registry is used: Apache's where there is a choice."""
    lines = [line.split("|") for line in tree(package, "normal,no-proc-macro", "{p}|{l}", target)]
    found = {of.split()[0]: licence.replace("/", " OR ") for of, licence in sorted(lines) if not of.startswith("camdrive")}
    return {name: "Apache-2.0" if "Apache-2.0" in licence.split(" OR ") else licence for name, licence in found.items()}


def component(name: str, licence: str, reference: str, **more: object) -> dict[str, object]:
    return {"type": "library", "bom-ref": reference, "name": name, "licenses": [{"expression": licence}], **more}


def bill(own_name: str, own_target: str = "all") -> str:
    """The bill of materials of the runtime library or of the module of pages; the export fills in {version}, {sources} and {rust}.
    A library that is no package has the version of the compiler or of the linker.
    """
    own_licences = licences(own_name, own_target)
    locked = {package["name"]: package for package in tomllib.loads((root / "Cargo.lock").read_text())["package"]
              if package["name"] in own_licences or package["name"].startswith("camdrive")}
    for name in locked:
        if name.startswith("camdrive"):
            locked[name]["version"] = "{version}"

    def reference(name: str) -> str:
        return f"pkg:cargo/{name}@{locked[name]['version']}"

    def linked(name: str) -> list[str]:
        needed = [dependency.split()[0] for dependency in locked[name].get("dependencies", [])]
        return [dependency for dependency in needed if dependency in locked]

    names = [own_name]
    for name in names:
        names += [other for other in linked(name) if other not in names]
    packages = []
    for name in names:
        sums = [{"alg": "SHA-256", "content": locked[name]["checksum"]}] if "checksum" in locked[name] else []
        licence = own_licences.get(name, "MIT OR Apache-2.0")
        packages.append(component(name, licence, reference(name), version=locked[name]["version"], purl=reference(name),
                                  **({"hashes": sums} if sums else {})))
    own = packages.pop(0)
    own["properties"] = [{"name": "camdrive:sources", "value": "{sources}"}]
    keys = ("in_standard_library", "by_linker") if own_target == "all" else ("in_module",)
    inside, *beside = ([component(name, licence, f"linked:{name}") for name, licence in LISTED[key]] for key in keys)
    beside = sum(beside, [])
    rust = component("rust-std", "(MIT OR Apache-2.0) AND Unicode-3.0", "rust-std", version="{rust}", components=inside)
    dependencies = [{"ref": reference(name), "dependsOn": [*map(reference, linked(name)), "rust-std"]} for name in names]
    dependencies.append({"ref": "rust-std", "dependsOn": [other["bom-ref"] for other in inside + beside]})
    whole = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "metadata": {"component": own},
             "components": [*packages, rust, *beside], "dependencies": dependencies}
    return json.dumps(whole, indent=2, ensure_ascii=False, sort_keys=True) + "\n"


def texts(linked: set[tuple[str, ...]]) -> str:
    """The licences of these packages, as they come with them."""
    found: dict[str, list[str]] = {}
    for package in json.loads(output("cargo", "metadata", "--locked", "--format-version", "1"))["packages"]:
        if package["source"] is None or (package["name"], "v" + package["version"]) not in linked:
            continue
        home = Path(package["manifest_path"]).parent
        name = f"{package['name']} {package['version']} ({package['license']})"
        words = ("LICEN", "COPY", "NOTICE", "UNLICENSE")
        # A package may also have the licence of its data, in a separate folder.
        files = [file for file in sorted(home.rglob("*")) if file.name.upper().startswith(words)]
        for text in {file.read_text(errors="replace").strip() for file in files if file.is_file()} or {""}:
            found.setdefault(text, []).append(name)
    parts = []
    for text, names in sorted(found.items(), key=lambda item: (item[1], item[0])):
        parts.append("\n".join(sorted(names)) + "\n\n" + (text or "No separate text; the named licence applies."))
    return f"\n\n{'=' * 80}\n".join(parts) + "\n"


def of_page() -> str:
    """The licences of the module of pages, for the FMUs that have one."""
    used = licences("camdrive-page", WASM)
    apache = sorted(name for name, licence in used.items() if licence == "Apache-2.0")
    versions = {tuple(line.split()[:2]) for line in tree("camdrive-page", "normal,no-proc-macro", "{p}", WASM)}
    others = {package for package in versions if used.get(package[0], "Apache-2.0") != "Apache-2.0"}
    return ("live.html contains a module for WebAssembly, built from camdrive, Rust's standard library (THIRD-PARTY.txt) and\n"
            "packages.\n\nUsed under the Apache licence, version 2.0 (LICENSE-APACHE.txt):\n\n  "
            + "\n  ".join(apache) + "\n\nUsed under their own licences:\n\n" + texts(others))


# What is generated, by file.
GENERATED = {
    BILL: lambda: bill("camdrive"),
    BILL_OF_PAGE: lambda: bill("camdrive-page", WASM),
    LICENCES_OF_PAGE: of_page,
}


def faults() -> list[str]:
    notices = (packaging / "third_party.txt").read_text()
    used = licences("camdrive")
    found = [f"{name}: linked, but not in linked.toml" for name in used.keys() - set(LISTED["packages"])]
    found += [f"{name}: in linked.toml, but not linked" for name in set(LISTED["packages"]) - used.keys()]
    for name, licence in used.items():
        if licence != "Apache-2.0":
            found.append(f"{name}: not to be had under the Apache licence, but {licence}")
    for name, _ in LISTED["in_standard_library"] + LISTED["by_linker"] + LISTED["in_module"]:
        if not re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", notices):
            found.append(f"{name}: without a notice in third_party.txt")
    for file, generated in GENERATED.items():
        if file.read_text() != generated():
            found.append(f"{file.name}: not that of Cargo.lock and linked.toml; `licenses.py --bill` writes it")
    return found


if sys.argv[1:] == ["--bill"]:
    for file, generated in GENERATED.items():
        file.write_text(generated())
    sys.exit()
if found := faults():
    sys.exit("\n".join(found))
if len(sys.argv) == 1:
    sys.exit()
folder = Path(sys.argv[1])
linked = {tuple(line.split()[:2]) for line in tree("camdrive-cli", "normal", "{p}")}
(folder / "THIRD-PARTY.txt").write_text(texts(linked))
# The additions of compilers and linkers to every program, as in an FMU.
shutil.copy(packaging / "third_party.txt", folder / "STANDARD-LIBRARIES.txt")
for name in ["LICENSE-MIT", "LICENSE-APACHE"]:
    shutil.copy(root / name, folder)
standard_library = Path(output("rustc", "--print", "sysroot").strip(), "share/doc/rust/COPYRIGHT-library.html")
if standard_library.is_file():
    shutil.copy(standard_library, folder)
else:
    print(f"the licences of Rust's standard library are missing: no {standard_library}", file=sys.stderr)
