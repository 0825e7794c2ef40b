"""What an optimisation leaves behind: rig files, numbers, a chart and a page, whole or not at all."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from calibore.cli import app
from calibore.design import optimise, read_requirement, verify_best
from calibore.errors import OutputError
from calibore.reports import write_optimisation
from calibore.rigs import read_rig

SPEC = """
format = "calibore-design/1"
name = "test pipe"
[pipe]
nominal_radius = "150 mm"
tolerance = "5 %"
[requirement]
u95 = "{budget}"
deflection = "10 %"
[crawler]
length = "450 mm"
diameter = "220 mm"
[laser]
length = "50 mm"
diameter = "20 mm"
[noise]
stripe = 0.4
length = "0.1 %"
[[camera]]
name = "only one"
width = 640
height = 480
body_length = "60 mm"
body_diameter = "30 mm"
lenses = ["perspective"]
field_of_view_range = ["15 deg", "90 deg"]
[search]
steps = 4
configurations = ["perpendicular-plane", "single-cone", "side-facing"]
"""


@pytest.fixture(scope="module")
def spec(tmp_path_factory):
    path = tmp_path_factory.mktemp("spec") / "spec.toml"
    path.write_text(SPEC.format(budget="1 %"), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def found(spec):
    return optimise(read_requirement(spec))


@pytest.fixture(scope="module")
def verified(found):
    return verify_best(found, draws=200)


def _contents(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()
    }


def test_equal_requirements_give_equal_bytes(found, verified, tmp_path):
    for name in ("one", "two"):
        write_optimisation(found, tmp_path / name, verified=verified)
    one, two = _contents(tmp_path / "one"), _contents(tmp_path / "two")
    assert one == two
    assert {"pareto.json", "optimise.html", "pareto.png", "pareto.svg", "recommended.toml"} < set(one)


def test_every_design_has_a_rig_file_that_says_the_same(found, verified, tmp_path):
    plain = write_optimisation(found, tmp_path / "out", verified=verified)
    assert plain == json.loads((tmp_path / "out" / "pareto.json").read_text(encoding="utf-8"))
    assert plain["recommended"] in {design["name"] for design in plain["designs"]}
    for design in plain["designs"]:
        rig = read_rig(tmp_path / "out" / design["rig"])
        assert rig.configuration == design["configuration"]
        assert rig.camera.lens.k == design["k_px"]
        assert rig.covariance is not None
    recommended = next(design for design in plain["designs"] if design["name"] == plain["recommended"])
    assert (tmp_path / "out" / "recommended.toml").read_bytes() == (tmp_path / "out" / recommended["rig"]).read_bytes()
    named = {*plain["by_configuration"].values(), *plain["by_camera"].values()}
    assert named <= {design["name"] for design in plain["designs"]}


def test_the_page_says_what_to_build_and_why_not_the_single_cone(found, verified, tmp_path):
    write_optimisation(found, tmp_path / "out", verified=verified, unit="in")
    page = (tmp_path / "out" / "optimise.html").read_text(encoding="utf-8")
    assert f"Build a {found.recommended.design.candidate.configuration} rig with a baseline of" in page
    assert "The binding requirement is" in page
    assert "A single-cone rig covers at most" in page
    assert "://" not in page


def test_an_earlier_result_is_replaced_and_anything_else_is_not(found, verified, tmp_path):
    out = tmp_path / "out"
    for _ in range(2):
        write_optimisation(found, out, verified=verified)
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    before = _contents(out)
    with pytest.raises(OutputError, match=r"notes\.txt"):
        write_optimisation(found, out, verified=verified)
    assert _contents(out) == before
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_where_nothing_meets_the_budget_the_page_says_what_to_relax(tmp_path):
    path = tmp_path / "spec.toml"
    path.write_text(SPEC.format(budget="0.05 mm").replace('"single-cone", ', ""), encoding="utf-8")
    plain = write_optimisation(optimise(read_requirement(path)), tmp_path / "out", verified={})
    assert plain["recommendation"][0].startswith("No design meets all requirements. Nearest is")
    assert any(
        "allow a U95 of" in sentence and "instead of 0.05 mm" in sentence for sentence in plain["recommendation"]
    )


def test_the_command_line_prints_the_recommendation_or_json(spec, tmp_path):
    command = ["design", "optimise", str(spec), "--out", str(tmp_path / "out"), "--workers", "1", "--no-verify"]
    run = CliRunner().invoke(app, command)
    assert run.exit_code == 0, run.output
    assert run.stdout.startswith("Build a ")
    plain = json.loads(CliRunner().invoke(app, [*command, "--json"]).stdout)
    assert plain == json.loads((tmp_path / "out" / "pareto.json").read_text(encoding="utf-8"))
