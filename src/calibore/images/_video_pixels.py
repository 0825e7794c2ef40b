"""The pixels of a decoded frame."""

from typing import Any

import numpy as np

from calibore.errors import ImageError
from calibore.images._source import Pixels


def frame_pixels(frame: Any, channel: str) -> Pixels:
    """Luma (h, w), or all three colours (h, w, 3); raises ImageError where the decoder's library cannot make them."""
    from av.error import FFmpegError

    try:
        return _converted(frame, channel)
    except FFmpegError as error:
        raise ImageError(
            "the kind of colours that the frame claims cannot be turned into red, green and blue"
        ) from error


def _converted(frame: Any, channel: str) -> Pixels:
    if channel != "luma":
        return frame.to_ndarray(format="rgb24")
    if not frame.format.name.startswith(("yuv4", "yuvj4", "gray", "nv12", "nv21", "p01")):
        return frame.to_ndarray(format="gray")
    return _plane(frame, frame.format.components[0].bits)


def _plane(frame: Any, bits: int) -> Pixels:
    """The first plane without the padding at the end of its lines."""
    plane = frame.planes[0]
    lines = np.frombuffer(plane, np.uint8)[: plane.line_size * frame.height].reshape(frame.height, plane.line_size)
    if bits <= 8:
        return lines[:, : frame.width].copy()
    order = ">u2" if frame.format.name.endswith("be") else "<u2"
    stored_high = frame.format.name.startswith("p01")  # these hold their bits at the top already
    scaled = lines[:, : 2 * frame.width].copy().view(order).astype(np.uint16)
    return np.left_shift(scaled, np.uint16(0 if stored_high else 16 - bits), dtype=np.uint16)
