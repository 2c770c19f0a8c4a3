"""Where an export is written."""

from __future__ import annotations

from pathlib import Path

from ...codegen.targets.c99 import DOUBLE, FLOAT, c_files
from ...codegen.targets.manifest import Manifest
from ..files.writing import refuse_overwriting, writable_folder, write_whole


def save_c(manifest: Manifest, folder: Path, single: bool = False) -> list[Path]:
    """The files of an observer as C99, written in a folder that is made if need be; their paths.

    single: its numbers are floats. ResultError if something is there that hillobs has not written, BlockError for what
    cannot be expressed in C.
    """
    files = c_files(manifest, FLOAT if single else DOUBLE)
    texts = {writable_folder(folder) / name: text for name, text in files.items()}
    refuse_overwriting(list(texts))
    for path, text in texts.items():
        write_whole(path, text.encode())
    return list(texts)
