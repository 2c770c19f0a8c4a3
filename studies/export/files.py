"""Where an export is written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ...codegen.targets.c99 import DOUBLE, FLOAT, c_files
from ...codegen.targets.fmu import fmus
from ...codegen.targets.manifest import Manifest
from ..files.writing import refuse_overwriting, writable_folder, write_whole


def save_c(manifest: Manifest, folder: Path, single: bool = False) -> list[Path]:
    """The files of an observer as C99, written in a folder that is made if need be; their paths.

    single: its numbers are floats. ResultError if something is there that hillobs has not written, BlockError for what
    cannot be expressed in C.
    """
    files = c_files(manifest, FLOAT if single else DOUBLE)
    return _saved({name: text.encode() for name, text in files.items()}, folder)


def save_fmus(manifest: Manifest, folder: Path) -> list[Path]:
    """An observer as FMUs, `NAME-fmi2.fmu` and `NAME-fmi3.fmu`, written in the same way; their paths.

    With libraries for this machine and, where the extra `compiler` is there, for all others. BuildError if nothing can
    be compiled.
    """
    return _saved(fmus(manifest), folder)


def _saved(files: Mapping[str, bytes], folder: Path) -> list[Path]:
    contents = {writable_folder(folder) / name: content for name, content in files.items()}
    refuse_overwriting(list(contents))
    for path, content in contents.items():
        write_whole(path, content)
    return list(contents)
