"""How pictures are stored: each one in a PNG or JPEG file, or all of them as frames of a video. Real encoders."""

from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.simulation._files import png_bytes

Pixels = NDArray[np.uint8 | np.uint16]
Album = Callable[[str, Any], None]
"""Called with the name of every picture and what is `prepared` of it."""

SUBSAMPLING = {"4:4:4": 0, "4:2:2": 1, "4:2:0": 2}


class _Codec(NamedTuple):
    """`encoder` of FFmpeg, `suffix` of the file, pixel format by chroma, the range of `quality`, finest first, and what
    `rates` [1/s] it knows.
    """

    encoder: str
    suffix: str
    pixels: dict[str, str]
    finest: int
    coarsest: int
    rates: Container[int] = range(1, 241)


CODECS = {
    "h264": _Codec("libx264", "mp4", {"4:2:0": "yuv420p", "4:4:4": "yuv444p"}, 1, 51),
    "mjpeg": _Codec("mjpeg", "avi", {"4:2:0": "yuvj420p", "4:4:4": "yuvj444p"}, 2, 31),
    "mpeg2": _Codec("mpeg2video", "mpg", {"4:2:0": "yuv420p"}, 2, 31, rates=(24, 25, 30, 50, 60)),
}


@dataclass(frozen=True)
class Still:
    """A file for each picture: "png" without loss, or "jpeg" of `quality` 1 ... 100 and `chroma` at full or half
    resolution.
    """

    format: str = "png"
    quality: int = 90
    chroma: str = "4:2:0"

    def __post_init__(self) -> None:
        if self.format not in ("png", "jpeg"):
            raise InputError(f'Pictures are stored as "png" or "jpeg", not "{self.format}".')
        if not 1 <= self.quality <= 100:
            raise InputError(f"The quality of a JPEG must be between 1 and 100, got {self.quality}.")
        _check(self.chroma, SUBSAMPLING, of="a JPEG")

    @property
    def suffix(self) -> str:
        return "png" if self.format == "png" else "jpg"

    @property
    def bits(self) -> tuple[int, ...]:
        """What a sensor may give."""
        return (8, 16) if self.format == "png" else (8,)

    @contextmanager
    def album(self, folder: Path, prefix: str, shape: tuple[int, int]) -> Iterator[Album]:
        """What puts pictures into `folder`, each into the file of its name."""

        def add(name: str, content: Any) -> None:
            (folder / name).write_bytes(content)

        yield add

    def prepared(self, image: Pixels) -> bytes:
        """What the album takes: the file of `image` (h, w, 3)."""
        if self.format == "png":
            return png_bytes(image)
        from PIL import Image

        file = BytesIO()
        Image.fromarray(image).save(file, "JPEG", quality=self.quality, subsampling=SUBSAMPLING[self.chroma])
        return file.getvalue()


@dataclass(frozen=True)
class Film:
    """A video of `codec` h264, mjpeg or mpeg2, `rate` frames a second. `quality` is the codec's quantiser, less is
    finer: 1 ... 51 of h264, where 18 looks like the original, 2 ... 31 of the others.
    """

    codec: str = "h264"
    rate: int = 25
    quality: int = 20
    chroma: str = "4:2:0"

    def __post_init__(self) -> None:
        _check(self.codec, CODECS, of="a video (codec)")
        _check(self.chroma, CODECS[self.codec].pixels, of=f"a video in {self.codec}")
        codec = CODECS[self.codec]
        if self.rate not in codec.rates:
            allowed = "1 to 240" if isinstance(codec.rates, range) else "24, 25, 30, 50 or 60"
            raise InputError(f"A video in {self.codec} has {allowed} frames a second, got {self.rate}.")
        if not codec.finest <= self.quality <= codec.coarsest:
            raise InputError(
                f"The quality of {self.codec} must be between {codec.finest} (finest) and {codec.coarsest}, got "
                f"{self.quality}."
            )

    @property
    def suffix(self) -> str:
        return CODECS[self.codec].suffix

    @property
    def bits(self) -> tuple[int, ...]:
        """What a sensor may give."""
        return (8,)

    def prepared(self, image: Pixels) -> Pixels:
        """What the album takes: frames are encoded in their order."""
        return image

    @contextmanager
    def album(self, folder: Path, prefix: str, shape: tuple[int, int]) -> Iterator[Album]:
        """What makes pictures of `shape` (h, w), in their order, the frames of a video `prefix` in `folder`. By one
        thread, so that the same pictures give the same bytes.
        """
        import av

        if self.chroma == "4:2:0" and (shape[0] % 2 or shape[1] % 2):
            raise InputError(
                f"The camera has {shape[1]} x {shape[0]} px, a video of chroma 4:2:0 needs even numbers; use another "
                "rig or store single pictures."
            )
        codec = CODECS[self.codec]
        with av.open(str(folder / f"{prefix}.{self.suffix}"), "w", options={"fflags": "+bitexact"}) as container:
            stream: Any = container.add_stream(codec.encoder, rate=self.rate)
            stream.height, stream.width = shape
            stream.pix_fmt = codec.pixels[self.chroma]
            stream.codec_context.time_base = Fraction(1, self.rate)
            stream.codec_context.options = self._options() | {"threads": "1", "flags": "+bitexact"}
            number = 0

            def add(name: str, content: Any) -> None:
                nonlocal number
                frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(content), format="rgb24")
                frame = frame.reformat(format=stream.pix_fmt)
                frame.pts, number = number, number + 1
                container.mux(stream.encode(frame))

            yield add
            container.mux(stream.encode())

    def _options(self) -> dict[str, str]:
        if self.codec == "h264":
            return {"crf": str(self.quality), "preset": "fast"}
        return {"qmin": str(self.quality), "qmax": str(self.quality)}


def _check(chosen: str, known: Any, *, of: str) -> None:
    if chosen not in known:
        raise InputError(f'"{chosen}" is not known of {of}; allowed: {", ".join(known)}.')
