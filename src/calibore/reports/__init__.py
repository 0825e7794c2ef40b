"""The report of a profile: one page that needs nothing but itself.

`finisher`         for `profiling.profile_scan`: pictures, report and exports beside the arrays
`illustrate`       the pictures and the report alone
`write_report`     folder, summary, rings and pictures in; OUT/report.html out
`write_reproduction`   what the source published beside what this program computes, as a page of its own
`write_design`     an analysed design as a folder of pictures, numbers (design.json) and one page; `design_data`
`expanded_text`    `(304.62 ± 0.13) mm`: a value with its expanded uncertainty, rounded to what it can carry
`write_calibration_page`, `write_difference_page`, `write_plan_page`   what a calibration means, how two differ, which
                   picture is next: a folder each
`write_comparison`  two profiles compared: arrays, numbers (summary.json), pictures and one page
`write_experiment`  the dissertation's experiment again: numbers, pictures and one page
`write_optimisation`   the rigs that an optimisation found as a folder of rig files, chart, numbers and one page
"""

from calibore.reports._calibration import write_calibration_page, write_difference_page
from calibore.reports._calibration_plan import write_plan_page
from calibore.reports._comparison import write_comparison
from calibore.reports._design import design_data, write_design
from calibore.reports._experiment import write_experiment
from calibore.reports._finisher import finisher, illustrate
from calibore.reports._numbers import expanded_text
from calibore.reports._optimise import fill_optimisation, optimisation_folder, write_optimisation
from calibore.reports._report import write_report
from calibore.reports._reproduction import write_reproduction

__all__ = [
    "design_data",
    "expanded_text",
    "fill_optimisation",
    "finisher",
    "illustrate",
    "optimisation_folder",
    "write_calibration_page",
    "write_comparison",
    "write_design",
    "write_difference_page",
    "write_experiment",
    "write_optimisation",
    "write_plan_page",
    "write_report",
    "write_reproduction",
]
