"""Pictures of a profile: one function per figure, each returning a matplotlib Figure drawn without pyplot.

Every function takes `(dataset, rings, *, nominal_radius, unit="mm", ...)`: a profile as `calibore.scans.open_profile`
gives it, its ring quantities, and the nominal radius [m]. Files are the caller's business: `save_picture` writes one.

`deviation_map`, `uncertainty_map`   the wall unrolled, crown in the middle
`ovality_along`, `diameter_along`    ring quantities along the pipe with 95 % bands
`worst_sections`                     the worst rings against the ideal circle
`shaded_view`                        the wall as a solid, cut open
`detected_line`                      one camera image with the line found in it
`STANDARD_PICTURES`                  all but the last, with titles and captions, in report order
`design_pictures`                    all pictures of an analysed design, with titles and captions
`published_picture`                  a table or figure of the source, drawn anew; `published_number` of it
`design_chart`                       the designs that an optimisation found
`calibration_pictures`, `difference_pictures`, `plan_pictures`   what a calibration means, how two differ, what to
                                     photograph next
`comparison_pictures`                two profiles compared
`experiment_pictures`                the dissertation's experiment again
`known_rig`, `nominal_radius_of`, `shown_radii`, `image_lattice`   where those pictures look
`length_unit`, `plain_text`          the reader's unit; numbers without exponents
`save_picture`, `save_vector`        a figure as PNG, as SVG
`worst_stations`, `governing_ovality`, `clock_text`   what pictures and reports must say alike
"""

from calibore.plotting._along import diameter_along, ovality_along
from calibore.plotting._calibration import calibration_pictures, difference_pictures, plan_pictures
from calibore.plotting._calibration_parts import image_lattice, known_rig, nominal_radius_of, shown_radii
from calibore.plotting._comparison import comparison_pictures
from calibore.plotting._design import DesignPicture, design_pictures, save_vector
from calibore.plotting._design_build import limit_text, parameter_words
from calibore.plotting._experiment import experiment_pictures
from calibore.plotting._figures import COVERAGE_FACTOR, save_picture
from calibore.plotting._lengths import LengthUnit, axial_unit, length_unit, plain_text
from calibore.plotting._line import detected_line
from calibore.plotting._maps import deviation_map, uncertainty_map
from calibore.plotting._optimise import design_chart
from calibore.plotting._published import published_number, published_picture
from calibore.plotting._rings import GOVERNING_OVALITY, OVALITY_DEFINITIONS, governing_ovality, worst_stations
from calibore.plotting._sections import worst_sections
from calibore.plotting._shaded import shaded_view
from calibore.plotting._standard import DETECTED_LINE_CAPTION, DETECTED_LINE_TITLE, STANDARD_PICTURES, Picture
from calibore.plotting._walls import clock_text

__all__ = [
    "COVERAGE_FACTOR",
    "DETECTED_LINE_CAPTION",
    "DETECTED_LINE_TITLE",
    "GOVERNING_OVALITY",
    "OVALITY_DEFINITIONS",
    "STANDARD_PICTURES",
    "DesignPicture",
    "LengthUnit",
    "Picture",
    "axial_unit",
    "calibration_pictures",
    "clock_text",
    "comparison_pictures",
    "design_chart",
    "design_pictures",
    "detected_line",
    "deviation_map",
    "diameter_along",
    "difference_pictures",
    "experiment_pictures",
    "governing_ovality",
    "image_lattice",
    "known_rig",
    "length_unit",
    "limit_text",
    "nominal_radius_of",
    "ovality_along",
    "parameter_words",
    "plain_text",
    "plan_pictures",
    "published_number",
    "published_picture",
    "save_picture",
    "save_vector",
    "shaded_view",
    "shown_radii",
    "uncertainty_map",
    "worst_sections",
    "worst_stations",
]
