"""What a user waits for before anything happens."""

import importlib.util
import subprocess
import sys
from functools import partial

import numpy as np

from benchmarks.timing import compare

REFERENCE = "python -c 'import numpy'"
COMMANDS = {
    "calibore --help": ["-m", "calibore", "--help"],
    "calibore profile --help": ["-m", "calibore", "profile", "--help"],
    REFERENCE: ["-c", "import numpy"],
    "python -c 'import numpy, calibore'": ["-c", "import numpy, calibore"],
    "python -c 'import numpy, calibore.stripe'": ["-c", "import numpy, calibore.stripe"],
}
PEERS = {
    "cv2": "import cv2",
    "scipy": "from scipy.ndimage import map_coordinates",
    "skimage": "from skimage.transform import warp_polar",
    "numba": "import numba",
}
COMMANDS |= {
    f"python -c 'import numpy; {statement}'": ["-c", f"import numpy; {statement}"]
    for package, statement in PEERS.items()
    if importlib.util.find_spec(package)
}


def report(rounds: int = 15) -> list[str]:
    """Markdown lines: whole processes, by the wall's clock."""
    contestants = {f"`{name}`": partial(_run, arguments) for name, arguments in COMMANDS.items()}
    result = compare(contestants, peer=f"`{REFERENCE}`", rounds=rounds, rng=np.random.default_rng(1))
    head = ["| command | median ms | import of NumPy / command (95 %) |", "|---|---|---|"]
    return ["## Start-up, whole processes", *head, *result.rows()]


def _run(arguments: list[str]) -> None:
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
