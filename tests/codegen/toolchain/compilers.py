"""A source that compiles in no time, and processes that build it."""

import ctypes
import os
import re
import subprocess
import sys
import textwrap

import pytest

from hillobs.codegen import cache
from hillobs.codegen.cache import BuildError
from hillobs.codegen.shared_library import open_library
from hillobs.codegen.toolchain import build

EXPORT = 'extern "C" __attribute__((visibility("default")))'
SOURCE = f"""
#include <math.h>
{EXPORT} int hillobs_abi(void) {{ return HILLOBS_ABI; }}
{EXPORT} double twice(double x) {{ return 2.0 * x + 0.0 * exp(x); }}
"""
DESCRIPTION = {"names": ["x"], "size": 1}


def twice(path, x=4.0):
    library = open_library(path)
    library.twice.restype, library.twice.argtypes = ctypes.c_double, [ctypes.c_double]
    return library.twice(x)


def fails(words):
    """The build must end with a sentence that holds `words`, and leave nothing in the cache but the lock."""
    with pytest.raises(BuildError) as caught:
        build(SOURCE, DESCRIPTION)
    assert re.search(words, str(caught.value)), str(caught.value)
    left = list(cache.cache_folder().iterdir())
    assert [path.suffix for path in left] in ([], [".lock"])
    return str(caught.value)


def python(program, *arguments, env=None, **options):
    """A process of its own that has SOURCE, build, twice, and counts its compiles in `compiled`."""
    head = f"""
        import ctypes, os, resource, signal, sys
        from hillobs.codegen import cache, toolchain
        SOURCE, DESCRIPTION = {SOURCE!r}, {DESCRIPTION!r}
        compiled, compile_library = [], toolchain.compile_library
        def counting(*arguments, **options):
            compiled.append(1)
            return compile_library(*arguments, **options)
        toolchain.compile_library = counting
        def twice(path):
            function = ctypes.CDLL(str(path)).twice
            function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
            return function(4.0)
    """
    command = [sys.executable, "-c", textwrap.dedent(head) + textwrap.dedent(program), *map(str, arguments)]
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"} | (env or {})
    return subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def finish(process):
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


BUILD = "path = toolchain.build(SOURCE, DESCRIPTION); print(path, len(compiled), twice(path))"
