"""Writes pictures into a folder as badly as cameras do: `python slow_camera.py FROM TO SEED PAUSE`.

Some in pieces with pauses between them, some under another name and then renamed, some after their successor.
"""

import os
import random
import sys
import time
from pathlib import Path

source, target, chance, pause = Path(sys.argv[1]), Path(sys.argv[2]), random.Random(sys.argv[3]), float(sys.argv[4])
names = sorted(path.name for path in source.glob("*.png"))
for first in range(1, len(names) - 1, 4):
    names[first], names[first + 1] = names[first + 1], names[first]
for name in names:
    data = (source / name).read_bytes()
    if chance.random() < 0.4:
        (target / f".{name}.tmp").write_bytes(data)
        os.rename(target / f".{name}.tmp", target / name)
        continue
    with (target / name).open("wb", buffering=0) as file:
        begin = 0
        while begin < len(data):
            end = begin + chance.randint(1, len(data) // 2)
            file.write(data[begin:end])
            begin = end
            time.sleep(pause * chance.random())
    time.sleep(pause * chance.random())
