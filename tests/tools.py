"""Programs that a machine may have or not; what needs one is skipped without it, and says so."""

import shutil
from importlib.util import find_spec

import pytest

NODE = shutil.which("node")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

needs_node = pytest.mark.skipif(NODE is None, reason="there is no node")
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")
needs_zig = pytest.mark.skipif(find_spec("ziglang") is None, reason="ziglang is not installed")
