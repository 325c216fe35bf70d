"""Joins thin Mach-O files into a universal one: universal.py THIN… UNIVERSAL."""

import struct
import sys
from pathlib import Path

PAGE = 14  # 2^14 bytes, the page of Apple's own processors

*inputs, output = map(Path, sys.argv[1:])
parts = [path.read_bytes() for path in inputs]
table = struct.pack(">II", 0xCAFEBABE, len(parts))
body = b""
for part in parts:
    magic, cpu, subtype = struct.unpack("<III", part[:12])
    assert magic == 0xFEEDFACF, "no thin 64 bit Mach-O file"
    body += bytes(-len(body) % (1 << PAGE))
    table += struct.pack(">IIIII", cpu, subtype, (1 << PAGE) + len(body), len(part), PAGE)
    body += part
output.write_bytes(table.ljust(1 << PAGE, b"\0") + body)
