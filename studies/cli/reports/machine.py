"""On what it runs: versions, compiler, folders, and what is compiled."""

from __future__ import annotations

import platform
from collections.abc import Iterator

from ....codegen.cache import BuildError, describe_cache, kept_sources
from ....codegen.toolchain import find_compiler
from ...files.pages import documentation, recordings
from ...files.versions import versions
from .number import counted


def information() -> Iterator[str]:
    """The lines of `hillobs info`."""
    for name, version in versions().items():
        yield f"{name:9} {version}"
    yield f"machine   {platform.machine()}, {platform.system()} {platform.release()}"
    try:
        compiler = find_compiler()
        yield f"compiler  {' '.join(compiler.command)}: {compiler.version.splitlines()[0]}"
    except BuildError as error:
        yield f"compiler  {error}"
    yield f"pages     {documentation()}"
    yield f"shipped   {recordings()}"
    cache = describe_cache()
    libraries = counted(int(str(cache["libraries"])), "library", "libraries")
    yield f"cache     {cache['folder']}: {libraries}, {cache['bytes']:,} bytes"
    if cache["problem"]:
        yield f"          it {cache['problem']}"


def sources() -> Iterator[str]:
    """The lines of `hillobs info --source`: each generated file, and what it is."""
    kept = kept_sources()
    for path, sentence in kept.items():
        yield str(path)
        yield f"    {sentence}"
    if not kept:
        yield "nothing is compiled yet"
