"""Compares the values of two platforms: compare.py FILE FILE BOUND, relative to the largest value of each output.

An estimate of errors has no digits to rely on where the error is rounding; it only has to agree within 1e-6. The multiplier of a
periodic start comes from differences of motions over a turn, and is known to 2e-9. How many steps a motion takes is no figure of it:
an event within a rounding of the end of a step makes one more.

If many impacts multiply errors, rounding grows like the errors of the solver, which are at least a hundred times larger: from
the point on where the drive itself reports an error, a hundredth of it is admissible."""

import math
import struct
import sys
from pathlib import Path


def columns(path: str) -> dict[str, tuple[float, ...]]:
    names, *lines = Path(path).read_text().split("\n")[:-1]
    rows = [[struct.unpack(">d", bytes.fromhex(bits))[0] for bits in line.split(";")] for line in lines]
    return dict(zip(names.split(";"), zip(*rows)))


def error(a: tuple[float, ...], b: tuple[float, ...]) -> list[float]:
    size = max(map(abs, a)) or 1.0
    differences = [abs(x - y) / size for x, y in zip(a, b, strict=True)]
    # A maximum may drop what is no number.
    return [difference if math.isfinite(difference) else math.inf for difference in differences]


TOLD = 0.01
ROUGH = {
    "solver.error_estimate": 1e-6,
    "start.multiplier": 2e-9,
    "solver.steps": 1e-3,
    "solver.evaluations": 1e-3,
}

one, other = map(columns, sys.argv[1:3])
assert one.keys() == other.keys(), "other outputs"
rough = [name for name in one if name in ROUGH]
differences = {name: error(one[name], other[name]) for name in one}
errors = {name: max(values) for name, values in differences.items()}
told = [TOLD * estimate for estimate in one.get("solver.error_estimate", [0.0] * len(next(iter(one.values()))))]
worst = max(errors.keys() - rough, key=errors.__getitem__)
unequal = sum(x != y for name in one for x, y in zip(one[name], other[name])) / sum(map(len, one.values()))
if unequal:
    print(f"        {unequal:.1%} of the values differ, most in {worst}, by {errors[worst]:.1e}", end="")
    print(*(f", in {name} by {errors[name]:.1e}" for name in rough))
bound = float(sys.argv[3])
if bound == 0.0:
    # Bit by bit, signs of zeros included.
    sys.exit(Path(sys.argv[1]).read_bytes() != Path(sys.argv[2]).read_bytes())
bounds = {name: ROUGH.get(name, bound) for name in one}
sys.exit(any(off > max(bounds[name], most) for name in one for off, most in zip(differences[name], told)))
