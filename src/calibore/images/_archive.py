"""Pictures in an archive: lossless, checksummed, and read several times as fast as from PNG files."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from pathlib import Path

from calibore.errors import ImageError, InputError
from calibore.images._archive_metadata import Key, read_metadata
from calibore.images._archived_picture import CHANNELS, DamagedError, Form, read_band, unpacked
from calibore.images._pattern import FIELDS
from calibore.images._reading import LIMIT, ImageFileError
from calibore.images._source import Pixels, Refusal, StationImages


class ArchivedImageError(ImageFileError):
    """A picture that an archive cannot hand out, or that was unusable when it was imported; `reason` says why."""

    def __init__(self, name: str, reason: str) -> None:
        self.reason = reason
        ImageError.__init__(self, f'Image "{name}" cannot be used: {reason}.')


@dataclass(frozen=True)
class _Picture:
    """One picture: its file in the archive and its form, or `reason`, why it was refused."""

    name: str
    file: Path
    form: Form | None
    reason: str = ""

    def pixels(self) -> Pixels:
        form = self._usable()
        try:
            return unpacked(self.file.read_bytes(), form)
        except (DamagedError, OSError) as error:
            raise self._lost(error) from error

    def band(self, channel: str) -> Pixels:
        form = self._usable()
        try:
            return read_band(self.file, form, band=CHANNELS.index(channel) if form.colour else 0)
        except (DamagedError, OSError) as error:
            raise self._lost(error) from error

    def _usable(self) -> Form:
        if self.form is None:
            raise ArchivedImageError(self.name, self.reason)
        return self.form

    def _lost(self, error: Exception) -> ArchivedImageError:
        if isinstance(error, DamagedError):
            what = f"its bytes in the archive have changed since it was imported ({error})"
        else:
            what = f"the archive's file of it cannot be read ({getattr(error, 'strerror', None) or error})"
        return ArchivedImageError(
            self.name, f'{what}; restore "{self.file}" from a copy, or import the picture again, or go on without it'
        )


@dataclass(frozen=True)
class ImageArchive:
    """The pictures in the archive `store`, called as `pattern` says: what `ImageFolder` was before they were imported.

    Raises InputError where there is no archive, or what lists its pictures is damaged; a picture that is damaged, or
    was refused when it was imported, raises ImageError when read.
    """

    store: Path
    pattern: str
    limit: int = LIMIT
    _pictures: dict[Key, _Picture] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        contents = read_metadata(self.store)
        for form in {form for form in contents.forms if form and form.bytes > self.limit}:
            raise InputError(
                f'Pictures of archive "{self.store}" have {form.width} x {form.height} px, more than the {self.limit} '
                "bytes that one picture may have; use smaller ones."
            )
        object.__setattr__(self, "_pictures", {})
        for number, (key, form) in enumerate(zip(contents.keys, contents.forms, strict=True)):
            name = self.pattern.format(**dict(zip(FIELDS, key, strict=True)))
            file = form.file(self.store, number) if form else self.store
            self._pictures[key] = _Picture(name, file, form, contents.reasons.get(number, ""))

    @property
    def expected_stations(self) -> int:
        return len({key[:2] for key in self._pictures})

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        """Always empty: every picture is listed, and `read` says what is wrong with one."""
        return ()

    def stations(self) -> Iterator[StationImages]:
        """One entry per station (and angular stop), sorted."""
        for (station, angular), keys in groupby(self._pictures, key=lambda key: key[:2]):
            pictures = {key[2]: self._pictures[key] for key in keys}
            names = tuple(picture.name for picture in pictures.values())
            yield StationImages(station, tuple(pictures), partial(_read_one, pictures), angular=angular, names=names)

    def read(self, station: int, take: int = 0, *, angular: int = 0) -> Pixels:
        """The pixels of one picture; raises ImageError naming it and why."""
        return self._picture(station, take, angular).pixels()

    def read_band(self, station: int, take: int = 0, *, angular: int = 0, channel: str) -> Pixels:
        """One colour, "red", "green" or "blue", shape (h, w), without decoding the others; grey is every colour."""
        return self._picture(station, take, angular).band(channel)

    def _picture(self, station: int, take: int, angular: int) -> _Picture:
        try:
            return self._pictures[station, angular, take]
        except KeyError:
            raise ImageError(f'There is no image of station {station}, take {take} in "{self.store}".') from None


def _read_one(pictures: dict[int, _Picture], take: int) -> Pixels:
    return pictures[take].pixels()
