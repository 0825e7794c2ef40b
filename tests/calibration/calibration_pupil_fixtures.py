"""Two-pin fixtures with a known pupil: marks on the pins, without pictures."""

import numpy as np

from calibore.calibration._pupil._fit import U_LEAN, U_OFFSET, U_POSE, fit_pupil
from calibore.calibration._pupil._model import PinModel, Sightings

INCH = 0.0254
PUPIL = 1.237 * INCH
U_SLIDE, U_TURN = 0.0005 * INCH, np.radians(0.05)
NOISE, BIAS = 0.05, 0.02  # px: of one mark, and of a pin in one picture
SLIDES, TURNS = (0.6, 0.9, 1.2), (-6.5, 0.0, 6.5)
SIZE = (1024, 768)


def marks(
    rng, *, slides=SLIDES, turns=TURNS, rows=10, law="equidistant", distances=(5.0, 22.0), pupil=PUPIL, bias=BIAS
):
    """Readings of the slides and marks of a fixture drawn as uncertain as it is taken to be."""
    read = np.array(slides) * INCH
    places = [(s, np.radians(t)) for s in range(read.size) for t in turns]
    model = PinModel(law, *SIZE, read, np.arange(len(places)))
    camera = rng.normal(0, list(U_POSE.values()))
    pins = [
        [rng.normal(0, aside), z * INCH, *rng.normal(0, U_LEAN, 2)]
        for aside, z in zip((0.001, 0.002), distances, strict=True)
    ]
    k = 3274.0 * (2 if law in ("stereographic", "equisolid-angle") else 1)
    slide, turn = read + rng.normal(0, U_SLIDE, read.size), rng.normal(0, U_TURN, len(places))
    values = np.concatenate([[pupil, k], camera, [rng.normal(0, U_OFFSET)], *pins, slide, turn])
    seen = _places(places, rows)
    u, _ = model.predicted(values, seen)
    off = rng.normal(0, NOISE, u.size) + rng.normal(0, bias, 2 * len(places))[2 * seen.picture + seen.near]
    return read, with_columns(seen, u=u + off)


def with_columns(seen, **columns):
    return Sightings(**({name: getattr(seen, name) for name in seen.__dataclass_fields__} | columns))


def _places(places, rows):
    ones = np.ones(rows)
    parts = []
    for number, (slide, turn) in enumerate(places):
        for near, v in ((True, np.linspace(430, 760, rows)), (False, np.linspace(6, 335, rows))):
            label = (np.full(rows, n) for n in (number, slide))
            half_width = (21 if near else 14) * ones
            parts.append((500 * ones, v, NOISE * ones, half_width, np.full(rows, near), *label, turn * ones))
    return Sightings(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def fitted(read, seen, *, laws=("equidistant",)):
    return fit_pupil(seen, slides=read, size=SIZE, laws=laws, u_slide=U_SLIDE, u_turntable=U_TURN)
