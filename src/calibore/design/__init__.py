"""Design: how well a rig will measure, before it is built.

`Assumptions`     how well lengths and line positions are known: `AS_PUBLISHED`, `HONEST`, or any other
`plane_rig`, `cone_rig`, `side_rig`, `coaxial_rig`, `asymmetric_rig`, `reversed_rig`, `spot_rig`,
`spot_array_rig`   reference rigs; `Study` names one of `KINDS` with its lengths, to be varied
`predict`         R, H and their uncertainties at pixels -> `Prediction`; `predict_on_wall` at places of a round wall
`combine_lasers`  several lasers on the same wall: the better one, or minimum variance; `predict_ring` round the pipe
`image_map`       R, H and their uncertainties over the image, and which `Region` is which
`measuring_limits`, `round_pipe`, `against_radius`, `against_baseline`, `against_projection`, `misalignments`
`occlusion`, `shadows`, `longest_body`, `deployment`   what stands in the way, and does it fit through the manhole
`tolerances`      how well it must be built
`analyse`, `analyse_rig`   all of that -> `Analysis`; `plain_analysis` for JSON
`read_requirement`, `optimise`   the Pareto set of rigs for a `Requirement` -> `Optimised`; `verify` by simulation
"""

from calibore.design._analysis import Analysis, Wishes, analyse, analyse_rig
from calibore.design._appraisal import Design, appraise
from calibore.design._assumptions import AS_PUBLISHED, HONEST, Assumptions
from calibore.design._candidates import Candidate
from calibore.design._choice import Option, demands_of
from calibore.design._curves import (
    RoundPipe,
    Sweep,
    against_baseline,
    against_projection,
    against_radius,
    round_pipe,
    useful_clocks,
)
from calibore.design._deployment import Deployment, deployment, longest_body, rig_length
from calibore.design._fusion import Combined, combine_lasers
from calibore.design._limits import Limits, measuring_limits
from calibore.design._misalignment import Misalignment, misalignments
from calibore.design._occlusion import Occlusion, Shadow, occlusion, shadows, source_of
from calibore.design._optimise import Optimised, optimise
from calibore.design._optimise_plain import PARETO_FORMAT, numbered, plain_optimisation
from calibore.design._pareto import non_dominated, spread
from calibore.design._plain import FORMAT, plain_analysis
from calibore.design._prediction import STRIPE, Part, Prediction, in_image, predict, predict_on_wall, scan_direction
from calibore.design._regions import ImageMap, Region, image_map, maps_of
from calibore.design._requirement import Requirement, read_requirement
from calibore.design._ring import RingPrediction, predict_ring, ring_clocks
from calibore.design._shares import grouped, ring_shares
from calibore.design._spots import spot_array_rig
from calibore.design._studies import (
    asymmetric_rig,
    coaxial_rig,
    cone_rig,
    plane_rig,
    reversed_rig,
    side_rig,
    side_view,
    spot_rig,
)
from calibore.design._study import KINDS, Kind, Study
from calibore.design._tolerances import Tolerance, Tolerances, tolerances, unit_of
from calibore.design._verification import Verification, verify, verify_best

__all__ = [
    "AS_PUBLISHED",
    "FORMAT",
    "HONEST",
    "KINDS",
    "PARETO_FORMAT",
    "STRIPE",
    "Analysis",
    "Assumptions",
    "Candidate",
    "Combined",
    "Deployment",
    "Design",
    "ImageMap",
    "Kind",
    "Limits",
    "Misalignment",
    "Occlusion",
    "Optimised",
    "Option",
    "Part",
    "Prediction",
    "Region",
    "Requirement",
    "RingPrediction",
    "RoundPipe",
    "Shadow",
    "Study",
    "Sweep",
    "Tolerance",
    "Tolerances",
    "Verification",
    "Wishes",
    "against_baseline",
    "against_projection",
    "against_radius",
    "analyse",
    "analyse_rig",
    "appraise",
    "asymmetric_rig",
    "coaxial_rig",
    "combine_lasers",
    "cone_rig",
    "demands_of",
    "deployment",
    "grouped",
    "image_map",
    "in_image",
    "longest_body",
    "maps_of",
    "measuring_limits",
    "misalignments",
    "non_dominated",
    "numbered",
    "occlusion",
    "optimise",
    "plain_analysis",
    "plain_optimisation",
    "plane_rig",
    "predict",
    "predict_on_wall",
    "predict_ring",
    "read_requirement",
    "reversed_rig",
    "rig_length",
    "ring_clocks",
    "ring_shares",
    "round_pipe",
    "scan_direction",
    "shadows",
    "side_rig",
    "side_view",
    "source_of",
    "spot_array_rig",
    "spot_rig",
    "spread",
    "tolerances",
    "unit_of",
    "useful_clocks",
    "verify",
    "verify_best",
]
