"""The pages are true: links lead somewhere, files parse, tables list what the code has, cited tests exist."""

import csv
import inspect
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer
from markdown_pages import ROOT, blocks, pages, prose

import calibore
from calibore.cli import app
from calibore.errors import CaliboreError
from calibore.profiling import prepare, profile_scan
from calibore.rigs import read_rig
from calibore.scans import default_export_name, open_points, open_profile, read_scan
from calibore.simulation import demo_survey, simulate_scan
from calibore.status import MEANING, Status
from calibore.stripe import Estimator, detect_ring

LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)|!\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)
REFERENCE = ROOT / "docs" / "reference"
RIG_OF_OTHER_FILES = """format = "calibore-rig/1"
configuration = "perpendicular-plane"
[camera]
width = 1024
height = 768
lens = "sine-law"
k = 571.0
principal_point = [512.0, 384.0]
[laser]
baseline = "13.1 in"
"""


def anchors(page):
    """Anchors of the headings of `page`, as code hosts make them."""
    titles = (re.sub(r"[`*]|\]\([^)]*\)|\[", "", title) for title in HEADING.findall(prose(page)))
    return {re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-") for title in titles}


def rows(page, first):
    """Cells of the rows of all tables of `page` whose heading begins with `first`."""
    found, inside = [], False
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith(f"| {first} |"):
            inside = True
        elif inside and line.startswith("|"):
            found.append([cell.strip() for cell in line.strip("|").split("|")])
        else:
            inside = False
    return [row for row in found if set(row[0]) - set("-: ")]


def names(row):
    """What stands in backticks in the first cell."""
    return re.findall(r"`([^`]+)`", row[0])


def read_both(folder):
    return read_scan(folder), read_rig(folder / "rig.toml")


def test_every_relative_link_leads_to_a_file_and_every_anchor_to_a_heading():
    broken = []
    for page in pages():
        for target in (one or other for one, other in LINK.findall(prose(page))):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            if not file.exists() or (anchor and anchor not in anchors(file)):
                broken.append(f"{page.relative_to(ROOT)}: {target}")
    assert not broken, "\n".join(broken)


def test_every_page_can_be_reached_from_the_readme():
    reached, todo = set(), [ROOT / "README.md"]
    while todo:
        page = todo.pop()
        if page in reached or page.suffix != ".md":
            continue
        reached.add(page)
        targets = (one or other for one, other in LINK.findall(prose(page)))
        todo += [(page.parent / t.partition("#")[0]).resolve() for t in targets if not re.match(r"[a-z]+:|#", t)]
    assert set(pages()) <= reached


def test_the_index_lists_every_page_of_the_documentation():
    index = ROOT / "docs" / "README.md"
    listed = {(index.parent / (one or other)).resolve() for one, other in LINK.findall(prose(index))}
    assert {page for page in pages() if index.parent in page.parents} <= listed | {index}


@pytest.mark.parametrize("page", ["README.md", "docs/reference/scan-and-rig.md"])
def test_every_scan_and_rig_file_on_the_page_is_read_and_fits_together(page, tmp_path):
    files = [block.text for block in blocks(ROOT / page) if block.language == "toml"]
    scans, rigs = ([f for f in files if f'"calibore-{kind}/1"' in f] for kind in ("scan", "rig"))
    assert scans
    assert rigs
    assert len(scans) + len(rigs) == len(files)
    for name in ("survey.mp4", "odometry.csv"):
        (tmp_path / name).touch()
    for rig in rigs:
        (tmp_path / "rig.toml").write_text(rig, encoding="utf-8")
        read_rig(tmp_path / "rig.toml")
        for scan in scans:
            (tmp_path / "scan.toml").write_text(scan, encoding="utf-8")
            spec = read_scan(tmp_path)
            if spec.pattern is not None:
                (tmp_path / spec.pattern.format(station=0, take=0)).touch()
                prepare(spec, estimator="zero-crossing")  # the ring lies in the picture


def test_the_mistakes_on_the_page_read_as_the_program_words_them(tmp_path):
    page = REFERENCE / "scan-and-rig.md"
    scan = next(b.text for b in blocks(page) if "calibore-scan/1" in b.text)
    shown = next(b.text for b in blocks(page) if b.language == "text").splitlines()
    changes = {
        '"6 in"': "150",
        "plane12in {station:03d} {take}": "ring {stop}",
        'step = "0.1 in" }': 'step = "0.1 in" }\ntable = "stations.csv"',
        '"sine-law"': '"fisheye"',
        "k = 571.0": "",
        "perpendicular-plane": "single-cone",
        '[laser]\nbaseline = "13.1 in"': '[laser]\nbaseline = "13.1 in"\n[uncertainty]\ntilt = 0.001',
    }
    assert len(shown) == len(changes)
    for sentence, (old, new) in zip(shown, changes.items(), strict=True):
        (tmp_path / "scan.toml").write_text(scan.replace(old, new), encoding="utf-8")
        (tmp_path / "rig.toml").write_text(RIG_OF_OTHER_FILES.replace(old, new), encoding="utf-8")
        with pytest.raises(CaliboreError) as caught:
            read_both(tmp_path)
        assert str(caught.value).replace(f"{tmp_path}/", "") == sentence


def test_the_table_of_statuses_is_that_of_the_code():
    table = [
        (int(value), name.strip("`"), meaning) for value, name, meaning in rows(REFERENCE / "conventions.md", "value")
    ]
    assert table == [(int(status), status.name.lower(), MEANING[status]) for status in Status]


def test_the_table_of_defaults_is_that_of_the_code(tmp_path):
    defaults = {row[0]: row[1] for row in rows(REFERENCE / "conventions.md", "what")}
    (tmp_path / "rig.toml").write_text(RIG_OF_OTHER_FILES, encoding="utf-8")
    rig = read_rig(tmp_path / "rig.toml").with_default_uncertainty(1.0)
    assert rig.covariance is not None
    assert rig.covariance.names == ("laser.baseline",)
    assert defaults["standard uncertainty of the baseline"].startswith(
        "0.001 of the nominal radius as limits, so 0.001 / √3"
    )
    assert rig.covariance.u[0] == pytest.approx(0.001 / np.sqrt(3))
    (tmp_path / "scan.toml").write_text(
        'format = "calibore-scan/1"\nname = "a"\nrig = "rig.toml"\n[pipe]\nnominal_radius = "1 m"\n[images]\n'
        'pattern = "{station}.png"\n[motion]\naxial = { origin = "0 m", step = "1 m" }\n',
        encoding="utf-8",
    )
    spec = read_scan(tmp_path)
    assert defaults["search region"] == f"{spec.search_inner} to {spec.search_outer} times the nominal radius"
    parameters = inspect.signature(detect_ring).parameters
    assert defaults["rays per picture"] == str(parameters["rays"].default)
    assert defaults["estimator"] == f"`{parameters['estimator'].default}`"


def test_the_result_of_the_page_is_the_result_of_the_program(tmp_path):
    survey = demo_survey(seed=1)
    survey = replace(survey, stations=survey.stations[9:])
    summary = profile_scan(simulate_scan(tmp_path / "scan", survey, seed=1), tmp_path / "out")
    page = REFERENCE / "results.md"
    text, listed = page.read_text(encoding="utf-8"), {n for row in rows(page, "variable") for n in names(row)}
    profile, points = open_profile(tmp_path / "out"), open_points(tmp_path / "out")
    assert listed == {*map(str, profile.variables), *map(str, points.variables)}
    for row in rows(page, "variable"):
        for name in names(row):
            if name in profile.variables and len(row) == 4:
                assert row[1] == ", ".join(map(str, profile[name].dims))
                assert row[2] == profile[name].attrs.get("units", "")
    with (tmp_path / "out" / "rings.csv").open(encoding="utf-8", newline="") as file:
        header = next(csv.reader(file))
    columns = {name for row in rows(page, "column") for name in names(row)}
    assert columns == {name for name in header if not name.startswith("u_")}
    assert not [key for key in summary if f"`{key}`" not in text]


def test_every_export_of_the_page_exists_under_its_name():
    for row in rows(REFERENCE / "results.md", "format"):
        formats, files = names(row), re.findall(r"`([^`]+)`", row[1])
        assert [default_export_name(format) for format in formats] == files


def test_estimators_are_named_as_the_program_knows_them():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert not [e.label for e in Estimator if e is not Estimator.CROSSING and f"`{e.label}`" not in readme]


def commands(group=None, before=()):
    """The verbs of the program by their words, those of groups too: ("profile",), ("design", "dual-cone"), ..."""
    group = group or typer.main.get_command(app)
    found = {}
    for name, command in group.commands.items():
        found |= commands(command, (*before, name)) if hasattr(command, "commands") else {(*before, name): command}
    return found


def options_of(command):
    return {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)} | {"--help"}


def test_every_command_on_the_pages_has_verbs_and_options_that_exist():
    verbs = commands()
    seen, named = set(), "|".join(sorted({words[0] for words in verbs}))
    for page in pages():
        shell = "\n".join(b.text for b in blocks(page) if b.language in ("sh", "powershell"))
        inline = re.findall(r"`(calibore [^`]*)`", prose(page))
        for line in [*re.findall(rf"\bcalibore (?:{named})\b.*", shell), *inline]:
            words = shlex.split(re.sub(r"\[|\]", "", line), comments=True)[1:]
            verb = next((words[:n] for n in (2, 1) if tuple(words[:n]) in verbs), None)
            if verb is None:
                assert any(known[: len(words)] == tuple(words) for known in verbs), f"{page.name}: {line}"
                continue
            given = {word for word in words if word.startswith("--")}
            assert given <= options_of(verbs[tuple(verb)]), f"{page.name}: {line}"
            seen.add(words[0])
    assert seen == {words[0] for words in verbs}


def test_every_option_that_a_page_names_exists():
    known = set().union(*map(options_of, commands().values())) | {"--version"}
    named = {name for page in pages() for name in re.findall(r"`(--[\w-]+)", prose(page))}
    assert len(named) > 5
    assert named <= known


def test_make_knows_the_targets_of_the_readme():
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    used = {target for page in pages() for target in re.findall(r"^make (\w+)", page.read_text(encoding="utf-8"), re.M)}
    assert {"demo", "test"} <= used <= targets


def test_every_test_that_a_page_names_exists():
    written = {
        name
        for path in (ROOT / "tests").rglob("test_*.py")
        for name in re.findall(r"^def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    }
    named = {name for page in pages() for name in re.findall(r"`(test_\w+)`", page.read_text(encoding="utf-8"))}
    assert len(named) > 15
    assert named <= written


def test_every_path_that_the_map_of_the_code_names_exists():
    roots = (ROOT, ROOT / "src" / "calibore")
    for page in pages():
        if page.name in ("ARCHITECTURE.md", "0003-results-appear-whole.md"):
            for name in re.findall(r"`((?:[\w.-]+/)+[\w.-]*)`", prose(page)):
                assert any((root / name).exists() for root in roots), f"{page.name}: {name}"


def test_the_map_of_the_code_names_every_package_and_only_names_that_exist():
    table = {names(row)[0]: row for row in rows(ROOT / "ARCHITECTURE.md", "package")}
    source = Path(calibore.__file__).parent
    present = {p.name for p in source.iterdir() if (p / "__init__.py").exists()} | {
        p.stem for p in source.glob("*.py") if not p.stem.startswith("__")
    }
    assert set(table) == present
    for package, row in table.items():
        module = __import__(f"calibore.{package}", fromlist=["__all__"])
        for name in re.findall(r"`([^`]+)`", row[2]):
            assert hasattr(module, name), f"{package} has no {name}"


def test_no_page_names_a_machine():
    for page in pages():
        text = page.read_text(encoding="utf-8")
        assert not re.search(r"(?<![\w.])/(home|root|work|tmp|Users)/|localhost|[A-Z]:\\", text), page.name
