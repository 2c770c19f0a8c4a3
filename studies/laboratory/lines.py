"""A text file of any size in blocks of whole lines, plain or gzip, within limits."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from ..files.errors import RecordingError
from ..files.progress import Progress, unseen
from ..files.reading import cause, open_regular

# a day at 1 kHz with twenty columns is 15 GB
_LARGEST_FILE = 16_000_000_000
LONGEST_LINE = 1_000_000
_BLOCK = 1 << 20
_GZIP = b"\x1f\x8b"
# tables of numbers shrink 2 to 50 times, bombs a thousand; a small file may be as regular as it likes
_LARGEST_RATIO = 200
_SMALL = 16_000_000


def blocks(path: Path, progress: Progress = unseen) -> Iterator[bytes]:
    r"""Blocks of whole lines, each line ending with \n; a byte-order mark is left out.

    `progress` is given the part of the file that has been read. RecordingError if the file is no regular one, too
    large, a damaged gzip file, not in an ASCII-compatible encoding, or has a line of more than a million bytes.
    """
    ready, rest, line = b"", b"", 1
    for piece in _checked(path, progress):
        text = rest + piece
        # half of a CR LF waits for its other half
        text, held_back = (text[:-1], b"\r") if text.endswith(b"\r") else (text, b"")
        if b"\r" in text:
            text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        end = text.rfind(b"\n") + 1
        rest = text[end:] + held_back
        if end:
            if ready:
                yield ready
            ready = text[:end]
            line += ready.count(b"\n")
        if len(rest) > LONGEST_LINE:
            raise RecordingError(f"row {line} is longer than {LONGEST_LINE:,} bytes")
    # a last line without an end belongs to the last block, which may be the first
    if ready or rest:
        yield ready + (rest.rstrip(b"\r") + b"\n" if rest else b"")


def _checked(path: Path, progress: Progress) -> Iterator[bytes]:
    try:
        with open_regular(path, _LARGEST_FILE) as (file, size):
            first = True
            for piece in _unfolded(file):
                if first and piece.startswith((b"\xff\xfe", b"\xfe\xff")):
                    raise RecordingError("is UTF-16; save it as UTF-8")
                if b"\0" in piece:
                    raise RecordingError("holds zero bytes: it is no text file")
                yield piece.removeprefix(b"\xef\xbb\xbf") if first else piece
                first = False
                progress(file.tell() / max(size, 1))
    except RecordingError:
        raise
    except EOFError as error:
        raise RecordingError("cannot be read: the gzip file ends early") from error
    except (gzip.BadGzipFile, zlib.error) as error:
        raise RecordingError("cannot be read: the gzip file is damaged") from error
    except (OSError, ValueError) as error:
        raise RecordingError(f"cannot be read: {cause(error)}") from error


def _unfolded(file: BinaryIO) -> Iterator[bytes]:
    """The file in pieces of at most a block; of gzip no more than the ratio allows."""
    packed = file.read(len(_GZIP)) == _GZIP
    file.seek(0)
    unpacked = 0
    source = gzip.GzipFile(fileobj=file) if packed else file
    while piece := source.read(_BLOCK):
        unpacked += len(piece)
        if packed and unpacked > max(_SMALL, _LARGEST_RATIO * file.tell()):
            raise RecordingError(f"unfolds to more than {_LARGEST_RATIO} times its size: it is no recording")
        yield piece


def text_of(line: bytes) -> str:
    """Bytes as text: UTF-8, or what older spreadsheets write. Numbers are ASCII in both."""
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("latin1")
