"""What a user waits for before anything happens."""

import subprocess
import sys
import time

import numpy as np

COMMANDS = {
    "calibore --help": ["-m", "calibore", "--help"],
    "calibore profile --help": ["-m", "calibore", "profile", "--help"],
    "python -c 'import numpy'": ["-c", "import numpy"],
    "python -c 'import numpy, calibore'": ["-c", "import numpy, calibore"],
    "python -c 'import numpy, calibore.stripe'": ["-c", "import numpy, calibore.stripe"],
}


def report(rounds: int = 15) -> list[str]:
    """Markdown lines: seconds of whole processes."""
    seconds = {name: [] for name in COMMANDS}
    for _ in range(rounds):
        for name, arguments in COMMANDS.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
            seconds[name].append(time.perf_counter() - start)
    lines = ["## Start-up, whole processes", "| command | median s | least s | most s |", "|---|---|---|---|"]
    return lines + [f"| `{n}` | {np.median(s):.3f} | {min(s):.3f} | {max(s):.3f} |" for n, s in seconds.items()]
