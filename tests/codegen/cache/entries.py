"""An entry of the cache for tests: the step that makes a library writes a few bytes, so that no compiler is needed."""

import errno
import hashlib
import json
import os
import random
import subprocess
import sys
import textwrap

import pytest

from hillobs.codegen import cache
from hillobs.codegen.cache import CacheWarning, Order

DESCRIPTION = {"names": ["x1", "x2", "Φ_S"], "sizes": {"x": 2, "u": 1}}
CONTENT = random.Random(1).randbytes(9000)
SOURCE = b"// a test\nint one(void) { return 1; }\n"
KEY = cache.entry_key({"source": "a test"})
OTHER = cache.entry_key({"source": "another test"})


class Maker:
    """Stands for the compiler; counts its calls."""

    def __init__(self, content=CONTENT):
        self.content, self.calls = content, 0

    def __call__(self, folder):
        self.calls += 1
        (folder / "made.so").write_bytes(self.content)
        return folder / "made.so"


def order(key=KEY, description=DESCRIPTION, source=SOURCE):
    return Order(key, description, source)


def obtain(maker, patience=30.0, **changed):
    return cache.obtain(order(**changed), maker, patience)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def assert_whole(folder, pattern="*.json"):
    """Every file under a final name is what its manifest says, found without the code under test."""
    for path in folder.glob(pattern):
        said = json.loads(path.read_bytes())
        content = (folder / said["library"]).read_bytes()
        assert said["key"] == path.stem
        assert hashlib.sha256(content).hexdigest() == said["sha256"]
        assert len(content) == said["size"]
        assert path.with_suffix(".cpp").exists()


def assert_rebuilt(folder):
    """The damage is seen, said once, repaired, and gone at the next look."""
    maker = Maker()
    with pytest.warns(CacheWarning) as said:
        path = obtain(maker)
    assert len(said) == 1
    assert "built again" in str(said[0].message)
    assert str(folder) in str(said[0].message)
    assert maker.calls == 1
    assert path.read_bytes() == CONTENT
    assert obtain(maker) == path
    assert maker.calls == 1
    assert_whole(folder, f"{KEY}.json")
    assert not list(folder.glob("*.tmp"))


def failing(folder):
    raise OSError(errno.EIO, os.strerror(errno.EIO))


def flip(path, bit):
    content = bytearray(path.read_bytes())
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


RUN = """
    import os, sys, warnings
    from pathlib import Path
    from hillobs.codegen import cache
    KEY = {key!r}
    content = bytes(range(256)) * 40

    def make(folder):
        (folder / "made.so").write_bytes(content)
        return folder / "made.so"

    def run(key=KEY):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                path = cache.obtain(cache.Order(key, {{"names": ["x"]}}, b"// x"), make, 30)
            except cache.BuildError as error:
                print("sentence:", error)
                return 1
        print("warnings:", len(said), *(warning.message for warning in said))
        print("path:", path)
        return 0 if path.read_bytes() == content else 9
"""


def child(program, folder, *arguments, **options):
    """Run a program after RUN in a process of its own."""
    text = textwrap.dedent(RUN.format(key=KEY)) + textwrap.dedent(program)
    environment = os.environ | {"HILLOBS_CACHE": str(folder), "PYTHONDONTWRITEBYTECODE": "1"} | options.pop("env", {})
    command = [sys.executable, *options.pop("switches", []), "-c", text, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment, **options)
