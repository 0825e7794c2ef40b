"""What a calibration from boards says to people."""

from collections.abc import Sequence

import numpy as np

from calibore.calibration._boards._fit import BENDS, BoardFit
from calibore.calibration._boards._models import Trial
from calibore.calibration._boards._pictures import BoardPictures
from calibore.calibration._in_words import PIXEL
from calibore.calibration._input_files import InputFile
from calibore.rigs import ValidRegion

FEW = 8  # pictures
CLEAR = 4.0  # standard uncertainties of a bend that is there
VISIBLE = 2e-5  # m: a bend that matters to nobody
RELATED = 0.25  # correlation of neighbouring residuals that says more than chance


def findings_of(
    found: BoardFit, pictures: BoardPictures, trials: Sequence[Trial], chosen: Trial, valid: ValidRegion
) -> tuple[str, ...]:
    """The recommendation first."""
    low, high = np.degrees(valid.zenith or (0, 0))
    k = PIXEL.said(found.fit.value("camera.k"), found.u("camera.k"))
    said = [
        f"Lens: {chosen.model.name}, k = {k} with u = {found.u('camera.k'):.2g} px. {_reason(trials, chosen)}",
        f"{found.data.boards} pictures, {len(found.data.owner)} {pictures.target.board.mark}: residuals "
        f"{found.estimate.rms:.4f} px (rms), {chosen.cross_validated:.4f} px on boards left out; "
        f"zenith {low:.0f}-{high:.0f} deg.",
    ]
    return (*said, *_bend(found, pictures))


def _reason(trials: Sequence[Trial], chosen: Trial) -> str:
    """Why not a simpler model, and why no other."""
    simpler = [trial for trial in trials if trial.estimate is not None and trial.parameters < chosen.parameters]
    others = [trial for trial in trials if trial.estimate is not None and trial.parameters >= chosen.parameters]
    reason = "No model of more parameters predicts boards left out significantly better"
    if simpler:
        best = min(simpler, key=lambda trial: trial.cross_validated)
        reason += f"; the best simpler one ({best.model.name}) leaves {best.cross_validated:.4f} px"
    else:
        rivals = [trial for trial in others if trial is not chosen and trial.parameters == chosen.parameters]
        if rivals:
            best = min(rivals, key=lambda trial: trial.cross_validated)
            reason += f"; the next law ({best.model.name}) leaves {best.cross_validated:.4f} px"
    return f"{reason}, this one {chosen.cross_validated:.4f} px."


def _bend(found: BoardFit, pictures: BoardPictures) -> list[str]:
    if not found.data.u_bend:
        return []
    bends = np.array([found.fit.value(name) for name in BENDS])
    u = np.array([found.u(name) for name in BENDS])
    seen = (np.abs(bends) > CLEAR * u) & (np.abs(bends) > VISIBLE)
    if not seen.any():
        return []
    worst = int(np.argmax(np.abs(bends)))
    stated = "" if pictures.target.flatness is not None else ' (state its flatness = ".. mm" if you know it)'
    return [
        f"The board is not flat: it rises by {1e3 * abs(bends[worst]):.3f}({1e3 * u[worst]:.3f}) mm from its middle to "
        f"its sides; this is taken into account{stated}."
    ]


def warnings_of(found: BoardFit, files: Sequence[InputFile], coverage: Sequence[str]) -> tuple[str, ...]:
    said = list(coverage)
    refused = [file for file in files if file.refused]
    if refused:
        names = ", ".join(file.name for file in refused[:3]) + (", ..." if len(refused) > 3 else "")
        said.append(f"{len(refused)} of {len(files)} pictures were not used ({names}): {refused[0].refused}")
    if found.data.boards < FEW:
        said.append(f"only {found.data.boards} pictures: better take 12 to 20.")
    related = found.fit.partial_autocorrelation
    if related.size and related[0] > RELATED:
        said.append(
            f"residuals of neighbouring marks resemble each other (correlation {related[0]:.2f}): board, print or lens "
            "differ from the model; the uncertainty takes it into account."
        )
    return tuple(said)
