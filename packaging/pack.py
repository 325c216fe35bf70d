"""Packs the module of pages: pack.py MODULE FILE writes it as LZMA with its length, and behind it the name of its sources."""

import lzma
import re
import sys
from pathlib import Path

module = Path(sys.argv[1]).read_bytes()
options = {"id": lzma.FILTER_LZMA1, "preset": 9 | lzma.PRESET_EXTREME, "lc": 4, "lp": 0, "pb": 0, "dict_size": 1 << 22, "nice_len": 273}
packed = bytearray(lzma.compress(module, format=lzma.FORMAT_ALONE, filters=[options]))
# Python leaves the length open.
packed[5:13] = len(module).to_bytes(8, "little")
Path(sys.argv[2]).write_bytes(packed + re.search(rb"camdrive page [0-9a-f]{16}", module)[0])
