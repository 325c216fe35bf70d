"""Compares the values of two platforms: compare.py FILE FILE BOUND, relative to the largest value of each output.

An estimate of errors has no digits to rely on where the error is rounding; it only has to agree within 1e-6. The multiplier of a
periodic start comes from differences of motions over a turn, and is known to 2e-9."""

import math
import struct
import sys
from pathlib import Path


def columns(path: str) -> dict[str, tuple[float, ...]]:
    names, *lines = Path(path).read_text().split("\n")[:-1]
    rows = [[struct.unpack(">d", bytes.fromhex(bits))[0] for bits in line.split(";")] for line in lines]
    return dict(zip(names.split(";"), zip(*rows)))


def error(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    differences = [abs(x - y) for x, y in zip(a, b, strict=True)]
    # The maximum may drop what is no number.
    return max(differences) / (max(map(abs, a)) or 1.0) if all(map(math.isfinite, differences)) else math.inf


ROUGH = {"solver.error_estimate": 1e-6, "start.multiplier": 2e-9}

one, other = map(columns, sys.argv[1:3])
assert one.keys() == other.keys(), "other outputs"
rough = [name for name in one if name in ROUGH]
errors = {name: error(one[name], other[name]) for name in one}
worst = max(errors.keys() - rough, key=errors.__getitem__)
unequal = sum(x != y for name in one for x, y in zip(one[name], other[name])) / sum(map(len, one.values()))
if unequal:
    print(f"        {unequal:.1%} of the values differ, most in {worst}, by {errors[worst]:.1e}", end="")
    print(*(f", in {name} by {errors[name]:.1e}" for name in rough))
bound = float(sys.argv[3])
if bound == 0.0:
    # Bit by bit, signs of zeros included.
    sys.exit(Path(sys.argv[1]).read_bytes() != Path(sys.argv[2]).read_bytes())
sys.exit(errors[worst] > bound or any(errors[name] > ROUGH[name] for name in rough))
