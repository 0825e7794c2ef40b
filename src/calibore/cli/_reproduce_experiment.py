"""`calibore reproduce --experiment`: chapters 6 to 8 on a simulated pipe whose truth is known."""

from pathlib import Path

import typer

from calibore.cli._profile import as_json, crew_of, progress_bar


def reproduce_experiment(
    out: Path, *, size: str, seed: int, workers: int | None, scheduler: str | None, keep_pictures: bool, json: bool
) -> None:
    """Runs what is missing of the experiment in `out`, and writes its page."""
    import os
    from dataclasses import replace

    from calibore.experiment import PLANS, run_experiment
    from calibore.reports import write_experiment

    plan = replace(PLANS[size], seed=seed)
    with crew_of(workers, scheduler) as crew, progress_bar("Experiment", quiet=json) as progress:
        hands = crew or os.cpu_count() or 1
        found = run_experiment(out, plan, crew=hands, keep_pictures=keep_pictures, progress=progress)
    facts = write_experiment(found, out)
    if json:
        typer.echo(as_json(facts))
        return
    for sentence in facts["answer"]:
        typer.echo(sentence)
    typer.echo(f"Page: {out / 'experiment.html'}")
