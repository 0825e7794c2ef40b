"""Where pictures come from: folders of image files, archives, videos, and the tables that say where each was taken.

An `ImageSource` hands out one station after the other, so that a survey never has to fit into memory. Pixels are
measurements: orientation tags, gamma and colour profiles are ignored, alpha is dropped, `image[v, u]` is what the
sensor wrote.
"""

from calibore.images._ahead import read_ahead
from calibore.images._archive import ImageArchive
from calibore.images._archive_writer import JOURNAL, Imported, write_archive
from calibore.images._folder import ImageFolder, names_in
from calibore.images._pattern import FIELDS, NamePattern
from calibore.images._reading import LIMIT, ImageFileError, image_size, read_image
from calibore.images._source import ImageSource, PictureFile, Pixels, Refusal, StationImages
from calibore.images._stream import StreamError, StreamFrame, StreamFrames, opened_stream
from calibore.images._tables import Odometry, StationRow, read_odometry, read_station_table
from calibore.images._video import CHANNELS, Video

__all__ = [
    "CHANNELS",
    "FIELDS",
    "JOURNAL",
    "LIMIT",
    "ImageArchive",
    "ImageFileError",
    "ImageFolder",
    "ImageSource",
    "Imported",
    "NamePattern",
    "Odometry",
    "PictureFile",
    "Pixels",
    "Refusal",
    "StationImages",
    "StationRow",
    "StreamError",
    "StreamFrame",
    "StreamFrames",
    "Video",
    "image_size",
    "names_in",
    "opened_stream",
    "read_ahead",
    "read_image",
    "read_odometry",
    "read_station_table",
    "write_archive",
]
