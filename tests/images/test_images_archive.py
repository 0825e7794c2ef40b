"""Archives hand out what the files held, bit for bit, say what is damaged, and go on where they were interrupted."""

import json
import pickle
import re
import struct
import tracemalloc
from pathlib import Path

import cv2
import google_crc32c
import numpy as np
import pytest
import zarr
from calibore._native import interleave
from numcodecs.zstd import Zstd

from calibore.errors import CaliboreError, ImageError, InputError
from calibore.images import ImageArchive, ImageFileError, ImageFolder, write_archive
from calibore.images._archived_picture import Form, packed, unpacked

NAMES = "ring {station:03d} {take}.png"
WORKERS = 2
KINDS = [(colour, dtype, look) for colour in (False, True) for dtype in (np.uint8, np.uint16) for look in range(4)]


def drawn(rng, colour, dtype, look, size=None):
    """A picture: noise, darkness with noise, one grey value, or a smooth ramp."""
    shape = (*(size or rng.integers(1, 60, 2)), *(3,) * colour)
    white = np.iinfo(dtype).max
    if look == 0:
        return rng.integers(0, white, shape, dtype=dtype, endpoint=True)
    if look == 1:
        return rng.poisson(4, shape).astype(dtype)
    if look == 2:
        return np.full(shape, rng.integers(0, white, endpoint=True), dtype)
    return np.linspace(0, white, int(np.prod(shape))).reshape(shape).astype(dtype)


def save(path: Path, picture: np.ndarray) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), picture[..., ::-1] if picture.ndim == 3 else picture)
    return path


def imported(folder: Path, store: Path, pattern: str = NAMES, **options):
    options = {"workers": WORKERS, "journal": store.with_suffix(".jsonl")} | options
    return write_archive(ImageFolder(folder, pattern), store, **options)


@pytest.fixture
def pictures(tmp_path):
    """Eight small colour pictures, the folder they are in."""
    rng = np.random.default_rng(5)
    for station in range(4):
        for take in range(2):
            save(tmp_path / "scan" / NAMES.format(station=station, take=take), drawn(rng, True, np.uint8, 1, (24, 32)))
    return tmp_path / "scan"


@pytest.fixture
def archive(pictures, tmp_path):
    """The archive of `pictures`: its store."""
    imported(pictures, tmp_path / "images.zarr")
    return tmp_path / "images.zarr"


def contents(store: Path) -> dict[str, bytes]:
    return {path.relative_to(store).as_posix(): path.read_bytes() for path in store.rglob("*") if path.is_file()}


@pytest.mark.parametrize("suffix", ["png", "tif"])
def test_every_kind_of_picture_comes_back_bit_for_bit_here_and_in_any_other_zarr_reader(tmp_path, suffix):
    rng, pattern = np.random.default_rng(1), f"{{station}}.{suffix}"
    for station, kind in enumerate(3 * KINDS):
        save(tmp_path / "scan" / f"{station}.{suffix}", drawn(rng, *kind))
    imported(tmp_path / "scan", tmp_path / "images.zarr", pattern)
    folder, archive = ImageFolder(tmp_path / "scan", pattern), ImageArchive(tmp_path / "images.zarr", pattern)
    group = zarr.open_group(tmp_path / "images.zarr", mode="r")
    arrays = [group[name] for name in group.attrs["forms"]]
    for row, (station, code) in enumerate(zip(group["station"][:], group["form"][:], strict=True)):
        want = folder.read(int(station))
        got, other = archive.read(int(station)), arrays[code][row]
        assert (got.dtype, got.shape) == (want.dtype, want.shape)
        assert np.array_equal(got, want)
        assert np.array_equal(np.moveaxis(other, 0, -1) if want.ndim == 3 else other, want)
        for band, channel in enumerate(("red", "green", "blue")):
            one = archive.read_band(int(station), channel=channel)
            assert np.array_equal(one, want[..., band] if want.ndim == 3 else want)


@pytest.mark.parametrize("suffix", ["jpg", "bmp"])
def test_other_formats_are_kept_as_they_are_decoded(tmp_path, suffix):
    save(tmp_path / "scan" / f"7.{suffix}", drawn(np.random.default_rng(2), True, np.uint8, 0, (40, 50)))
    imported(tmp_path / "scan", tmp_path / "images.zarr", f"{{station}}.{suffix}")
    archive = ImageArchive(tmp_path / "images.zarr", f"{{station}}.{suffix}")
    assert np.array_equal(archive.read(7), ImageFolder(tmp_path / "scan", f"{{station}}.{suffix}").read(7))


def test_an_archive_lists_what_the_folder_listed_under_the_same_names(tmp_path):
    rng, pattern = np.random.default_rng(3), "stop{angular}/ring {station:03d} {take}.png"
    for station, angular, take in rng.integers(0, 12, (25, 3)):
        save(tmp_path / "scan" / f"stop{angular}/ring {station:03d} {take}.png", drawn(rng, False, np.uint8, 0))
    imported(tmp_path / "scan", tmp_path / "images.zarr", pattern)
    folder, archive = ImageFolder(tmp_path / "scan", pattern), ImageArchive(tmp_path / "images.zarr", pattern)
    assert archive.expected_stations == folder.expected_stations
    for ours, theirs in zip(archive.stations(), folder.stations(), strict=True):
        assert (ours.station, ours.angular, ours.takes, ours.names) == (
            theirs.station,
            theirs.angular,
            theirs.takes,
            theirs.names,
        )
        sent = pickle.loads(pickle.dumps(ours.read))  # as another machine gets it
        assert all(np.array_equal(sent(take), theirs.read(take)) for take in ours.takes)


def test_any_flipped_byte_is_found_its_picture_is_named_and_the_others_are_read(pictures, archive):
    folder, source = ImageFolder(pictures, NAMES), ImageArchive(archive, NAMES)
    path = archive / "colour8_32x24/c/3/0/0/0"  # station 1, take 1
    whole = path.read_bytes()
    for place in range(len(whole)):
        spoilt = bytearray(whole)
        spoilt[place] ^= 1 << place % 8
        path.write_bytes(spoilt)
        with pytest.raises(ImageFileError, match=r'Image "ring 001 1.png" cannot be used: its bytes .* have changed'):
            source.read(1, 1)
    for station, take in ((1, 0), (2, 0)):
        assert np.array_equal(source.read(station, take), folder.read(station, take))


@pytest.mark.parametrize("left", [0, 1, 40, 51, 52, 200, -1])
def test_a_shortened_or_lengthened_file_is_found(archive, left):
    path = archive / "colour8_32x24/c/3/0/0/0"
    path.write_bytes(path.read_bytes()[:left] if left >= 0 else path.read_bytes() + b"\0")
    source = ImageArchive(archive, NAMES)
    for read in (source.read, lambda *key: source.read_band(*key, channel="red")):
        with pytest.raises(ImageError, match="have changed"):
            read(1, 1)


def test_a_file_that_is_gone_is_named(archive):
    (archive / "colour8_32x24/c/3/0/0/0").unlink()
    with pytest.raises(ImageError, match=r'"ring 001 1.png" cannot be used: the archive\'s file of it cannot be read'):
        ImageArchive(archive, NAMES).read(1, 1)


def test_a_file_whose_checksums_fit_but_that_holds_too_much_is_refused_without_the_memory_for_it(archive):
    def sealed(body):
        return body + struct.pack("<I", google_crc32c.value(body))

    plane = sealed(bytes(Zstd(1).encode(bytes(200_000_000))))
    places = struct.pack("<6Q", *(number for band in range(3) for number in (band * len(plane), len(plane))))
    (archive / "colour8_32x24/c/3/0/0/0").write_bytes(3 * plane + sealed(places))
    tracemalloc.start()
    with pytest.raises(ImageError, match="have changed"):
        ImageArchive(archive, NAMES).read(1, 1)
    assert tracemalloc.get_traced_memory()[1] < 10_000_000
    tracemalloc.stop()


def test_a_damaged_list_of_pictures_is_told_in_a_sentence_or_does_no_harm(pictures, archive):
    """Any byte of any metadata and number file changed: an InputError, or pictures as they were."""
    folder, rng = ImageFolder(pictures, NAMES), np.random.default_rng(6)
    files, told = [path for path in archive.rglob("*") if path.is_file() and "colour8_32x24/c" not in str(path)], []
    for path in files:
        whole = path.read_bytes()
        for place in rng.integers(0, len(whole), 12):
            spoilt = bytearray(whole)
            spoilt[place] ^= int(rng.integers(1, 255))
            path.write_bytes(spoilt)
            try:
                source = ImageArchive(archive, NAMES)
                assert np.array_equal(source.read(1, 1), folder.read(1, 1))
            except CaliboreError as error:
                told.append(str(error))
        path.write_bytes(whole)
    assert len(told) > 20
    assert not any("\n" in sentence for sentence in told)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("zarr.json", r'"pictures": \d+', '"pictures": 1e999'),
        ("station/zarr.json", r'"chunk_shape": \[\s*\d+', '"chunk_shape": [0'),
        ("station/zarr.json", r'"fill_value": \d+', '"fill_value": 1000000000000000000000000000000'),
        ("station/zarr.json", r'"shape": \[\s*\d+', '"shape": [2000000000'),
    ],
)
def test_numbers_that_no_archive_has_are_told_in_a_sentence(archive, name, old, new):
    """Found by fuzzing: infinity, chunks of nothing, numbers too large, a list of two thousand million pictures."""
    path = archive / name
    changed, count = re.subn(old, new, path.read_text(encoding="utf-8"), count=1)
    assert count == 1
    path.write_text(changed, encoding="utf-8")
    with pytest.raises(InputError, match="archive"):
        ImageArchive(archive, NAMES)


def test_what_is_no_archive_is_told(tmp_path):
    (tmp_path / "images.zarr").mkdir()
    with pytest.raises(InputError, match="is no archive of pictures"):
        ImageArchive(tmp_path / "images.zarr", NAMES)


def test_a_picture_that_was_refused_stays_listed_with_the_same_reason(pictures, tmp_path):
    spoilt = pictures / NAMES.format(station=2, take=0)
    spoilt.write_bytes(spoilt.read_bytes()[:100])
    done = imported(pictures, tmp_path / "images.zarr")
    assert [entry.name for entry in done if not entry.form] == ["ring 002 0.png"]
    with pytest.raises(ImageFileError) as before:
        ImageFolder(pictures, NAMES).read(2, 0)
    with pytest.raises(ImageFileError) as after:
        ImageArchive(tmp_path / "images.zarr", NAMES).read(2, 0)
    assert after.value.reason == before.value.reason


def test_where_no_picture_is_usable_there_is_no_archive(pictures, tmp_path):
    for path in pictures.glob("*.png"):
        path.write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"None of the 8 images is usable; the first: ring 000 0\.png: "):
        imported(pictures, tmp_path / "images.zarr")


class Interrupted(Exception):
    """The run ends here."""


def interrupted_after(count: int):
    def progress(done, total):
        if done == count:
            raise Interrupted

    return progress


@pytest.mark.parametrize("count", [1, 3, 8])
def test_an_interrupted_import_goes_on_where_it_was_and_ends_as_if_undisturbed(pictures, archive, tmp_path, count):
    store = tmp_path / "again.zarr"
    with pytest.raises(Interrupted):
        imported(pictures, store, progress=interrupted_after(count))
    written = {path: path.stat().st_ino for path in store.rglob("c/*/0/0/0")}
    assert len(written) >= count
    imported(pictures, store)
    listed = {json.loads(line).get("number") for line in store.with_suffix(".jsonl").read_text().splitlines()}
    kept = sum(path.stat().st_ino == inode for path, inode in written.items())
    assert kept >= count - WORKERS  # the journal names what the run has seen finished
    assert listed == {None, *range(8)}
    assert contents(store) == contents(archive)


def test_a_run_that_goes_on_does_again_what_was_damaged_torn_or_changed_meanwhile(pictures, tmp_path):
    store, journal = tmp_path / "images.zarr", tmp_path / "images.jsonl"
    with pytest.raises(Interrupted):
        imported(pictures, store, progress=interrupted_after(8))
    damaged = store / "colour8_32x24/c/1/0/0/0"
    damaged.write_bytes(damaged.read_bytes()[:-60] + bytes(60))
    grey = save(pictures / NAMES.format(station=1, take=0), np.full((9, 7), 100, np.uint8))
    journal.write_bytes(journal.read_bytes()[:-20])
    imported(pictures, store)
    assert not (store / "colour8_32x24/c/2").exists() or not any((store / "colour8_32x24/c/2").rglob("0/0/0"))
    source, folder = ImageArchive(store, NAMES), ImageFolder(pictures, NAMES)
    assert source.read(1, 0).shape == (9, 7)
    assert grey.exists()
    for station, _, take in folder.paths:
        assert np.array_equal(source.read(station, take), folder.read(station, take))


def test_a_run_that_finds_other_pictures_begins_anew(pictures, tmp_path):
    store = tmp_path / "images.zarr"
    with pytest.raises(Interrupted):
        imported(pictures, store, progress=interrupted_after(5))
    (pictures / NAMES.format(station=0, take=0)).unlink()  # every number shifts
    imported(pictures, store)
    source, folder = ImageArchive(store, NAMES), ImageFolder(pictures, NAMES)
    assert source.expected_stations == 4
    for station, _, take in folder.paths:
        assert np.array_equal(source.read(station, take), folder.read(station, take))
    assert len(list(store.rglob("c/*/0/0/0"))) == 7


def test_memory_does_not_grow_with_the_number_of_pictures(tmp_path):
    picture, peaks = drawn(np.random.default_rng(8), True, np.uint8, 1, (480, 640)), []
    for count in (3, 15):
        for station in range(count):
            save(tmp_path / f"{count}" / NAMES.format(station=station, take=0), picture)
        tracemalloc.start()
        imported(tmp_path / f"{count}", tmp_path / f"{count}.zarr", workers=1)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] - peaks[0] < picture.nbytes / 4


def test_pictures_read_one_after_the_other_keep_their_own_pixels() -> None:
    rng = np.random.default_rng(9)
    pictures = [rng.integers(0, 256, (12, 14, 3), dtype=np.uint8) for _ in range(3)]
    pictures.append(rng.integers(0, 65536, (12, 14, 3), dtype=np.uint16))
    files = [(packed(picture), Form.of(picture)) for picture in pictures]
    read = [unpacked(data, form) for data, form in files + files]
    assert all(np.array_equal(one, two) for one, two in zip(read, pictures + pictures, strict=True))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_planes_are_interleaved_as_numpy_stacks_them(dtype: type) -> None:
    rng = np.random.default_rng(10)
    for height, width in [(1, 1), (3, 11), (40, 67)]:
        planes = list(rng.integers(0, np.iinfo(dtype).max, (3, height, width), dtype=dtype, endpoint=True))
        assert np.array_equal(interleave(planes), np.stack(planes, axis=-1))


def test_planes_that_do_not_belong_together_are_refused() -> None:
    plane = np.zeros((4, 5), np.uint8)
    for other in (plane[:3], plane.astype(np.uint16), plane.astype(float), plane[None]):
        with pytest.raises(ValueError, match="one shape"):
            interleave([plane, plane, other])
