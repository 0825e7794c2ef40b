"""The report: one page that carries everything it shows, and says what a reader must not miss."""

import re
from html import unescape
from html.parser import HTMLParser

import numpy as np
import pytest

from calibore.errors import InputError, OutputError
from calibore.plotting import STANDARD_PICTURES
from calibore.reports import expanded_text, write_report

RADIUS = 0.1524
ONE_PIXEL = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c4890000000d49444154789c6360606060000000050001a5f64540"
    "0000000049454e44ae426082"
)
NASTY = ['<script>alert("1")</script>', "pipe & sons <12 in>", "' onload='x", '"><img src=x>', "{{ 7 * 7 }}"]


def _rings(count: int = 12) -> dict[str, np.ndarray]:
    generator = np.random.default_rng(1)
    mean = 2 * RADIUS + generator.normal(0, 2e-4, count)
    ovality = generator.uniform(0.5, 3, count)
    columns = {
        "axial_m": np.arange(count) * 0.5,
        "fraction": np.full(count, 0.97),
        "diameter_mean_m": mean,
        "diameter_min_m": mean * (1 - ovality / 100),
        "diameter_max_m": mean * (1 + 0.8 * ovality / 100),
        "ovality_f1216_max_percent": 0.8 * ovality,
        "ovality_f1216_min_percent": ovality,
        "deflection_percent": 100 * (1 - mean * (1 - ovality / 100) / (2 * RADIUS)),
        "deflection_clock_rad": np.full(count, np.pi / 2),
    }
    columns |= {f"u_{name}": np.full(count, 2e-4) for name in columns if name.startswith("diameter")}
    columns |= {f"u_{name}": np.full(count, 0.05) for name in columns if name.endswith("percent")}
    flags = np.array(["features gap" if row == 3 else "" for row in range(count)])
    return {"station": np.arange(count) * 11, **columns, "flags": flags}


def _summary(**more):
    return {"name": "Test pipe", "nominal_radius_m": RADIUS} | more


@pytest.fixture
def pictures(tmp_path):
    path = tmp_path / "picture.png"
    path.write_bytes(ONE_PIXEL)
    return {picture.title: path for picture in STANDARD_PICTURES}


def _page(tmp_path, pictures=None, *, rings=None, **options) -> str:
    summary = options.pop("summary", _summary())
    path = write_report(tmp_path, summary=summary, rings=rings or _rings(), pictures=pictures or {}, **options)
    assert path == tmp_path / "report.html"
    return path.read_text(encoding="utf-8")


class _Outline(HTMLParser):
    """Tags, their attributes and the visible text of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL))

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


def test_the_page_needs_nothing_but_itself(tmp_path, pictures):
    page = _page(tmp_path, pictures)
    assert "http://" not in page
    assert "https://" not in page
    assert "url(" not in page
    assert "@import" not in page
    sources = re.findall(r'\bsrc\s*=\s*"([^"]*)"', page)
    assert len(sources) == len(pictures)
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    tags = {tag for tag, _ in _Outline(page).tags}
    assert not tags & {"script", "link", "iframe", "object", "base", "form"}


def test_every_picture_has_its_title_and_a_caption_that_says_how_to_read_it(tmp_path, pictures):
    outline = _Outline(
        _page(tmp_path, pictures | {"My own": pictures["Deviation map"]}, captions={"My own": "Read so."})
    )
    alternatives = [attributes.get("alt") for tag, attributes in outline.tags if tag == "img"]
    assert alternatives == [picture.title for picture in STANDARD_PICTURES] + ["My own"]
    assert "Read so." in outline.text
    for picture in STANDARD_PICTURES:
        assert picture.caption in outline.text


@pytest.mark.parametrize("words", NASTY)
def test_words_from_outside_are_shown_never_obeyed(tmp_path, pictures, words):
    rig = {
        "configuration": words,
        "file": words,
        "parameters": [{"name": words, "value": 1.0, "u": None, "unit": words}],
    }
    skipped = [{"image": words, "reason": words}]
    summary = _summary(
        name=words, command=words, estimator=words, versions={words: words}, counts={words: 3}, rig=rig, skipped=skipped
    )
    summary["warnings"] = [words]
    rings = _rings() | {"flags": np.full(12, words.replace(" ", ""))}
    page = _page(tmp_path, {words: pictures["Deviation map"]}, rings=rings, summary=summary, created=words)
    outline = _Outline(page)
    assert "script" not in {tag for tag, _ in outline.tags}
    assert all("onload" not in attributes for _, attributes in outline.tags)
    assert sum(tag == "img" for tag, _ in outline.tags) == 1
    assert outline.text.count(words) >= 9


def test_every_warning_and_every_skipped_image_is_on_the_page(tmp_path):
    warnings = [f"Warning number {number}: something < wrong." for number in range(200)]
    skipped = [
        {"image": f"plane12in {number:03d} 0.png", "reason": f"truncated after {number} bytes"} for number in range(200)
    ]
    outline = _Outline(_page(tmp_path, summary=_summary(warnings=warnings, skipped=skipped)))
    assert all(warning in outline.text for warning in warnings)
    assert all(one["image"] in outline.text and one["reason"] in outline.text for one in skipped)


def test_a_default_uncertainty_is_said_before_anything_else_and_only_then(tmp_path):
    loud = "a default was used"
    for rig, said in (
        ({"default_uncertainty": True}, True),
        ({"default_uncertainty": "Only the baseline."}, True),
        ({}, False),
    ):
        text = _Outline(_page(tmp_path, summary=_summary(rig=rig))).text
        assert (loud in text) == said
        assert not said or text.index(loud) < text.index("Worst stations")
        assert ("Only the baseline." in text) == isinstance(rig.get("default_uncertainty"), str)


def test_key_numbers_carry_their_expanded_uncertainty_and_place(tmp_path):
    rings = _rings()
    worst = int(np.argmax(rings["ovality_f1216_min_percent"]))
    text = _Outline(_page(tmp_path, rings=rings)).text.replace("\N{NO-BREAK SPACE}", " ")
    mean = 1e3 * rings["diameter_mean_m"].mean()
    assert f"({mean:.2f} ± 0.40) mm" in text
    assert f"({rings['ovality_f1216_min_percent'][worst]:.2f} ± 0.10) %" in text
    assert f"station {worst * 11}, axial {worst * 0.5:.5g} m" in text
    assert "3:00 h" in text
    assert "97.0 %" in text


def test_a_mean_diameter_that_the_caller_propagated_replaces_the_upper_bound(tmp_path):
    summary = _summary(mean_diameter_m=0.3, u_mean_diameter_m=1e-5)
    text = _Outline(_page(tmp_path, summary=summary)).text
    assert "(300.000 ± 0.020) mm" in text
    assert "upper bound" not in text


def test_lengths_read_in_inches_if_wanted(tmp_path):
    rig = {"parameters": [{"name": "laser.baseline", "value": 0.254, "u": 2.54e-4, "unit": "m"}]}
    text = _Outline(
        _page(tmp_path, unit="in", summary=_summary(rig=rig, mean_diameter_m=0.3048, u_mean_diameter_m=1.27e-4))
    ).text
    assert "(12.000 ± 0.010) in" in text
    assert "laser.baseline 10 0.01 in" in text
    assert "Mean diameter ± U95 [in]" in text


def test_limits_are_decided_with_the_uncertainty_taken_into_account(tmp_path):
    rings = _rings(5)
    rings["ovality_f1216_min_percent"] = np.array([4.0, 4.95, 5.05, 6.0, np.nan])
    rings["ovality_f1216_max_percent"] = np.full(5, np.nan)
    rings["u_ovality_f1216_min_percent"] = np.full(5, 0.05)
    text = _Outline(_page(tmp_path, rings=rings, summary=_summary(limits={"ovality_percent": 5.0}))).text
    assert "Ovality 5 % 1 1 2 1" in text


def test_the_worst_stations_are_listed_worst_first_with_their_flags_explained(tmp_path):
    rings = _rings()
    rows = re.findall(r"<tr><td>(\d+)</td>", _page(tmp_path, rings=rings))
    ovality = dict(zip(rings["station"], rings["ovality_f1216_min_percent"], strict=True))
    listed = [ovality[int(row)] for row in rows]
    assert len(rows) == 10
    assert listed == sorted(ovality.values(), reverse=True)[:10]
    assert "dents, rails, edges or openings" in _page(tmp_path, rings=rings)


def test_nothing_measured_reads_as_such(tmp_path):
    rings = _rings(3)
    empty = {n: v if n in ("station", "axial_m", "flags") else np.full(3, np.nan) for n, v in rings.items()}
    text = _Outline(_page(tmp_path, rings=empty | {"fraction": np.zeros(3)})).text
    assert text.count("not measured") >= 3
    assert "No station has a measured ovality" in text
    assert "nan" not in text.lower().split()


def test_equal_input_gives_equal_bytes_and_no_time_unless_given(tmp_path, pictures):
    pages = {_page(tmp_path, pictures) for _ in range(2)}
    assert len(pages) == 1
    assert not re.search(r"\b20\d\d-\d\d-\d\d", pages.pop().split("<body>")[1].split("<h2>Pictures")[0])
    assert "Report of 2031-02-03" in _page(tmp_path, created="2031-02-03")


def test_what_is_missing_is_named(tmp_path):
    with pytest.raises(InputError, match="nominal_radius_m"):
        _page(tmp_path, summary={"name": "x"})
    with pytest.raises(InputError, match=r"absent\.png cannot be read"):
        _page(tmp_path, {"Map": tmp_path / "absent.png"})
    (tmp_path / "text.png").write_text("no picture")
    with pytest.raises(InputError, match="not a PNG file"):
        _page(tmp_path, {"Map": tmp_path / "text.png"})
    with pytest.raises(OutputError, match="cannot be written"):
        write_report(tmp_path / "nowhere", summary=_summary(), rings=_rings(), pictures={})


def test_a_page_that_cannot_be_finished_leaves_the_old_one(tmp_path):
    old = _page(tmp_path)
    with pytest.raises(InputError):
        _page(tmp_path, {"Map": tmp_path / "absent.png"})
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == old
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


@pytest.mark.parametrize(
    ("value", "u", "unit", "text"),
    [
        (304.6231, 0.0651, "mm", "(304.62 ± 0.13) mm"),
        (304.6231, 6.51, "mm", "(305 ± 13) mm"),
        (3.2, 0.0004, "", "3.20000 ± 0.00080"),
        (0.04, 0.0, "%", "(0.040 ± 0.000) %"),
        (1.23456, np.nan, "%", "1.235 % (uncertainty not known)"),
        (np.nan, 0.1, "%", "not measured"),
    ],
)
def test_numbers_are_rounded_to_what_their_uncertainty_carries(value, u, unit, text):
    assert expanded_text(value, u, unit) == text


def test_unescaped_text_is_what_was_given(tmp_path):
    name = "A & B <C>"
    page = _page(tmp_path, summary=_summary(name=name))
    assert unescape(re.search(r"<h1>(.*?)</h1>", page)[1]) == name
