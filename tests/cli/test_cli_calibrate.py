"""`calibore calibrate`: what is asked for is done or refused in a sentence; what is printed is what was found."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibore.calibration import Calibration, Comparison, InputFile, Observations, read_calibration, write_calibration
from calibore.calibration._dispatch import KINDS, calibrate
from calibore.cli import main
from calibore.cli._calibrate_words import aligned, digits_for, said_in
from calibore.errors import InputError
from calibore.fitting import least_squares
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, ValidRegion
from calibore.uncertainty import Covariance, Quantity

NAMES = ("laser.baseline", "laser.tilt_x", "camera.k")
VALUES = (0.3, 0.01, 570.0)


def found(*, refused: str = "", set_aside: str = "", k: float = VALUES[2]) -> Calibration:
    """Of a plane rig, in gauges."""
    rng = np.random.default_rng(1)
    jacobian = rng.normal(size=(90, 3)) * [2e3, 800.0, 0.4]
    noise = rng.normal(0, 0.2, 90)
    fit = least_squares(lambda x: (noise - jacobian @ x, jacobian), np.zeros(3), names=NAMES)
    camera = Camera(1024, 768, Lens("sine-law", k, 384.0), (511.0, 384.0))
    covariance, valid = Covariance(NAMES, fit.covariance), ValidRegion((0.05, 1.0), (0.1, 0.3))
    rig = Rig("perpendicular-plane", camera, (Laser(Plane(0.3, 0.01)),), covariance, 0.1, valid=valid)
    seen = Observations(
        file=np.arange(90) // 45,
        u=rng.uniform(0, 1023, 90),
        v=rng.uniform(0, 767, 90),
        residual=fit.residuals,
        sigma=fit.sigma,
        weight=fit.weights,
        group=np.full(90, -1),
        jacobian=fit.jacobian,
        names=NAMES,
    )
    return Calibration(
        kind="ring-gauge",
        rig=rig,
        camera=camera,
        values=dict(zip(NAMES, (0.3, 0.01, k), strict=True)),
        covariance=covariance,
        degrees_of_freedom=87.0,
        noise=0.2,
        group_sigma=0.0,
        files=(
            InputFile("a.png", "0" * 64),
            InputFile("b.png", "1" * 64, refused),
            InputFile("c.png", "2" * 64, refused, set_aside),
        ),
        observations=seen,
        valid=valid,
        models=(
            Comparison("sine-law", 3, 0.2, 0.0, 0.0, 0.21, {"laser.baseline": Quantity(0.3, 2e-5)}),
            Comparison("perspective", 3, 1.25, 311.0, 310.0, float("nan"), {}, "misfits"),
        ),
        findings=("Use the sine law.", "The gauges agree."),
        warnings=("Mind the gap.",),
    )


@pytest.fixture
def target(tmp_path):
    def write(kind: str = "ring-gauge") -> Path:
        folder = tmp_path / "target"
        folder.mkdir(exist_ok=True)
        (folder / "target.toml").write_text(f'format = "calibore-target/1"\nkind = "{kind}"\nimages = "*.png"\n')
        return folder

    return write


@pytest.fixture
def call(monkeypatch, capsys):
    """`calibore calibrate ...` in this process: exit status, standard output, standard error."""

    def run(*words: object) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["calibore", "calibrate", *map(str, words)])
        with pytest.raises(SystemExit) as left:
            main()
        return int(left.value.code or 0), *capsys.readouterr()

    return run


@pytest.fixture
def gauges(monkeypatch):
    """Sets what a calibration in gauges finds, or that it fails."""

    def finds(result: Calibration | Exception) -> None:
        def calibrate_gauges(path, *, progress=None):
            if isinstance(result, Exception):
                raise result
            progress and progress(1, 1)
            return result

        monkeypatch.setattr("calibore.calibration._rig._gauges.calibrate_gauges", calibrate_gauges)

    return finds


def test_what_was_found_is_printed_and_written(target, call, gauges, tmp_path):
    gauges(found())
    out = tmp_path / "new" / "rig.toml"
    status, said, remarks = call("rig", target(), "--out", out)
    assert (status, remarks) == (0, "Warning: Mind the gap.\n")
    lines = said.splitlines()
    assert lines[0] == "Use the sine law."
    assert lines[-1] == f"Calibration: {out}"
    u = found().covariance.u
    assert re.search(rf"laser.baseline +300.000 +{1e3 * u[0]:.3f} +mm$", said, re.MULTILINE)
    assert re.search(rf"camera.k +570.\d+ +{u[2]:.2f}\d* +px$", said, re.MULTILINE)
    assert "valid: zenith 2.9 to 57.3 deg, radius 100 to 300 mm" in said
    assert re.search(r"sine-law +3 +0.2000 +0.0 +0.0 +0.2100 +300.000 \+- 0.020$", said, re.MULTILINE)
    assert re.search(r"perspective +3 +1.2500 +311.0 +310.0 +- +- +misfits$", said, re.MULTILINE)
    assert "Not used" not in said
    assert np.array_equal(read_calibration(out).covariance.matrix, found().covariance.matrix)


def test_lengths_are_printed_in_inches_where_asked_for(target, call, gauges, tmp_path):
    gauges(found())
    said = call("rig", target(), "--out", tmp_path / "rig.toml", "--unit", "in")[1]
    assert re.search(r"laser.baseline +11.811\d+ +0.000\d+ +in$", said, re.MULTILINE)
    assert "radius 3.937 to 11.81 in" in said
    assert "laser.baseline [in]" in said
    status, _, remarks = call("rig", target(), "--out", tmp_path / "rig.toml", "--unit", "ell")
    assert status == 2
    assert 'Unit "ell" is not known; use "mm" or "in"' in remarks


def test_refused_images_are_named_with_their_reason_and_the_exit_status_says_so(target, call, gauges, tmp_path):
    gauges(found(refused="no line was found"))
    status, said, _ = call("rig", target(), "--out", tmp_path / "rig.toml")
    assert status == 3
    assert "Not used, 2 of 4 files:\n  b.png, c.png: no line was found\n" in said
    assert read_calibration(tmp_path / "rig.toml").files[1].refused == "no line was found"


def test_images_set_aside_are_named_in_one_line_and_are_no_fault(target, call, gauges, tmp_path):
    gauges(found(set_aside="it has room light"))
    status, said, _ = call("rig", target(), "--out", tmp_path / "rig.toml")
    assert status == 0
    assert "\n\nSet aside: c.png: it has room light\n" in said
    assert "Not used" not in said
    assert read_calibration(tmp_path / "rig.toml").files[2].set_aside == "it has room light"
    facts = json.loads(call("rig", target(), "--out", tmp_path / "rig.toml", "--json")[1])
    assert [one["set_aside"] for one in facts["files"]] == ["", "", "it has room light", ""]


def test_json_says_everything(target, call, gauges, tmp_path):
    gauges(found(refused="no line"))
    status, said, remarks = call("rig", target(), "--out", tmp_path / "rig.toml", "--json")
    facts = json.loads(said)
    assert (status, remarks) == (3, "Warning: Mind the gap.\n")
    assert [one["name"] for one in facts["parameters"]] == list(NAMES)
    assert [one["unit"] for one in facts["parameters"]] == ["m", "", "px"]
    assert np.array_equal(facts["covariance"], found().covariance.matrix)
    assert facts["models"][1]["cross_validated"] is None
    assert facts["files"][2]["refused"] == "no line"
    assert facts["valid"] == {"zenith_rad": [0.05, 1.0], "radius_m": [0.1, 0.3]}
    assert facts["findings"][0] == "Use the sine law."
    assert facts["file"] == str(tmp_path / "rig.toml")


def test_a_calibration_that_fails_leaves_nothing_under_the_final_name(target, call, gauges, tmp_path):
    gauges(InputError("rings cover zenith 0 to 31 deg only; photograph the target from nearer."))
    status, said, remarks = call("rig", target(), "--out", tmp_path / "out" / "rig.toml")
    assert (status, said) == (1, "")
    assert remarks == "calibore: rings cover zenith 0 to 31 deg only; photograph the target from nearer.\n"
    assert not (tmp_path / "out").exists()


def test_a_destination_that_is_not_ours_is_refused_before_any_work(target, call, gauges, tmp_path):
    gauges(AssertionError("no work is done"))
    (tmp_path / "rig.toml").write_text("mine")
    status, _, remarks = call("rig", target(), "--out", tmp_path / "rig.toml")
    assert status == 1
    assert "is no calibration that this program wrote; choose another name" in remarks
    assert (tmp_path / "rig.toml").read_text() == "mine"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("verb", sorted({verb for verb, *_ in KINDS.values()}))
def test_a_target_of_another_kind_is_told_which_command_to_use(target, monkeypatch, kind, verb):
    def calibrated(path, *, progress=None):
        return replace(found(), kind=f"{path} {kind}")

    asked, module, function = KINDS[kind]
    monkeypatch.setattr(f"calibore.calibration.{module}.{function}", calibrated)
    folder = target(kind)
    if asked == verb:
        for path in (folder, folder / "target.toml"):
            made = calibrate(verb, path)
            assert made.kind == f"{folder / 'target.toml'} {kind}"
            assert [file.name for file in made.files] == ["a.png", "b.png", "c.png", "target.toml"]
    else:
        with pytest.raises(InputError, match=rf"target.toml is of kind {kind}: use `calibore calibrate {asked}`"):
            calibrate(verb, folder)


def test_what_is_no_target_is_told(target, call, tmp_path):
    (tmp_path / "empty").mkdir()
    cases = {
        tmp_path / "empty": r"empty holds no target.toml; write one that says what was photographed",
        tmp_path / "nowhere": r"nowhere does not exist",
        target("tea-leaves"): r'kind = "tea-leaves" is not known; allowed: concentric-rings, chessboard',
    }
    for path, sentence in cases.items():
        status, said, remarks = call("lens", path, "--out", tmp_path / "lens.toml")
        assert (status, said) == (1, "")
        assert sentence in remarks
        assert remarks.count("\n") == 1


@pytest.fixture
def file(tmp_path):
    write_calibration(found(refused="no line"), tmp_path / "rig.toml")
    return tmp_path / "rig.toml"


def test_a_calibration_is_shown_with_what_it_means_on_the_wall(file, call):
    status, said, remarks = call("show", file)
    assert (status, remarks) == (0, "Warning: Mind the gap.\n")
    assert "On the wall, u of the radius shared by a whole scan [mm]:" in said
    assert re.search(r"^ +100 +[\d.]+ +[\d.]+$", said, re.MULTILINE)
    assert "Over the image, u of the direction behind a pixel:" in said
    assert re.search(r"Evidence: 90 residuals, 0 of them left out; .* differs by [\d.e-]+ of the stated", said)
    facts = json.loads(call("show", file, "--json", "--radius", "150 mm")[1])
    assert facts["wall"]["radius_m"][0] == pytest.approx(0.105)
    assert facts["evidence"]["largest_change_of_covariance"] < 1e-6
    assert facts["changed_inputs"] is None


def test_inputs_that_changed_since_are_named(file, call, tmp_path):
    (tmp_path / "a.png").write_bytes(b"another picture")
    said = call("show", file, "--inputs", tmp_path)[1]
    assert "Inputs: a.png is changed." in said
    assert "Inputs: b.png is missing." in said


def test_the_same_calibration_differs_from_itself_by_nothing_and_another_is_told_apart(file, call, tmp_path):
    status, said, _ = call("diff", file, file, "--radius", "150 mm")
    assert status == 0
    assert said.strip()
    assert json.loads(call("diff", file, file, "--radius", "150 mm", "--json")[1])["p"] > 0.9
    write_calibration(found(k=580.0), tmp_path / "other.toml")
    facts = json.loads(call("diff", file, tmp_path / "other.toml", "--radius", "150 mm", "--json")[1])
    assert facts["p"] < 1e-6
    assert facts["changes"][0]["name"] == "camera.k"


def test_the_next_pictures_are_planned(file, call, tmp_path):
    (tmp_path / "target.toml").write_text(
        'format = "calibore-target/1"\nkind = "concentric-rings"\nimages = "*.png"\nring_spacing = "1 in"\nrings = 12\n'
        'spokes = 8\nnominal_baseline = "12 in"\n'
    )
    status, said, _ = call("plan", file, tmp_path, "--count", "2", "--radius", "150 mm")
    assert status == 0
    assert re.search(r"On a wall of 150 mm u of the radius is [\d.]+ mm now", said)
    assert len(re.findall(r"^ +\d\. ", said, re.MULTILINE)) == 2
    before, after = (float(re.findall(pattern, said)[-1]) for pattern in (r"is ([\d.]+) mm now", r"([\d.]+) mm\n"))
    assert after <= before
    assert re.search(r"^The best next picture of the target: (at|standing) ", said, re.MULTILINE)
    status, said, _ = call("plan", file, tmp_path, "--count", "1", "--radius", "150 mm", "--out", tmp_path / "plan")
    assert status == 0
    assert said.splitlines()[-1] == f"Page: {tmp_path / 'plan' / 'plan.html'}"
    assert (tmp_path / "plan" / "plan.html").is_file()
    facts = json.loads(call("plan", file, tmp_path, "--json", "--out", tmp_path / "plan")[1])
    assert facts["page"].endswith("plan.html")
    assert facts["advice"].startswith("The best next picture")


def test_a_radius_without_a_unit_is_wrong_usage(file, call):
    for words in (("show", file, "--radius", "6"), ("diff", file, file, "--radius", "6")):
        status, _, remarks = call(*words)
        assert status == 2
        assert '"6" has no unit' in remarks


def test_a_radius_that_no_wall_has_is_wrong_usage(file, call):
    status, _, remarks = call("show", file, "--radius", "0 mm")
    assert status == 2
    assert 'must be positive, not "0 mm"' in remarks


def test_numbers_show_two_digits_of_their_uncertainty_in_the_units_people_use():
    assert [digits_for(u) for u in (12.0, 1.2, 0.12, 0.0012, 0.0, float("inf"))] == [0, 1, 2, 4, 4, 4]
    assert said_in("m", "in") == ("in", 0.0254)
    assert said_in("m/rad^2", "mm") == ("mm/rad^2", 1e-3)
    assert said_in("rad", "in") == ("deg", pytest.approx(0.0174533))
    assert said_in("px", "mm") == ("px", 1.0)


def test_tables_are_aligned():
    rows = [("", "value", ""), ("a", "1.5", "mm"), ("long name", "12.25", "")]
    assert list(aligned(rows)) == ["             value", "  a            1.5  mm", "  long name  12.25"]


def test_a_lens_has_no_wall_but_an_image(call, tmp_path):
    rig = found()
    names = ("camera.k",)
    lens = replace(rig, rig=None, values={"camera.k": 570.0}, covariance=rig.covariance.restricted(names))
    write_calibration(lens, tmp_path / "lens.toml")
    status, said, _ = call("show", tmp_path / "lens.toml")
    assert status == 0
    assert "On the wall" not in said
    assert "Over the image" in said


def test_pages_are_written_where_asked_for(file, call, tmp_path):
    status, said, _ = call("show", file, "--radius", "150 mm", "--out", tmp_path / "page")
    assert status == 0
    assert said.splitlines()[-1] == f"Page: {tmp_path / 'page' / 'calibration.html'}"
    assert (tmp_path / "page" / "calibration.html").is_file()
