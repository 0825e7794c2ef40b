"""Print the worst station of a result, with the 95 % interval of its ovality and deflection.

    python examples/read_a_result.py RESULT

RESULT is a folder that `calibore profile` or `calibore demo` wrote.
"""

import sys
from pathlib import Path

import numpy as np

from calibore.scans import read_rings
from calibore.uncertainty import Quantity

OVALITIES = ("ovality_f1216_max_percent", "ovality_f1216_min_percent")


def worst_station(result: Path) -> str:
    """One sentence about the station with the largest ovality (the larger of the two ASTM F1216 forms)."""
    rings = read_rings(result)
    forms = np.stack([rings[name] for name in OVALITIES])
    if not np.isfinite(forms).any():
        return f"No ring of {result} has an ovality."
    form, row = np.unravel_index(np.nanargmax(forms), forms.shape)

    def interval(name: str) -> str:
        quantity = Quantity(float(rings[name][row]), float(rings[f"u_{name}"][row]))
        low, high = quantity.interval()
        return f"{quantity.value:.2f} % ({low:.2f} to {high:.2f} %)"

    return (
        f"Worst station {rings['station'][row]} at {rings['axial_m'][row]:.3f} m: "
        f"ovality {interval(OVALITIES[form])}, deflection {interval('deflection_percent')}."
    )


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    print(worst_station(Path(sys.argv[1])))
