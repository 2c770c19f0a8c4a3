"""Texts that follow from our code alone: made once, then found in the cache, without what it takes to make them."""

from __future__ import annotations

import warnings
from collections.abc import Callable

from ...codegen.cache import CacheWarning, entry_key, kept
from ...codegen.own_code import own_code

# all that a text may follow from
_PACKAGES = ("codegen", "model", "observers", "studies")


def kept_text(name: str, make: Callable[[], str]) -> str:
    """The text called `name`, from the cache if the same code has made it; else from `make`."""
    if not (code := own_code(*_PACKAGES)):
        return make()
    key = entry_key({"code": code, "text": name})
    with warnings.catch_warnings():
        # who asks for a text has not asked for the cache
        warnings.simplefilter("ignore", CacheWarning)
        return kept(key, lambda: make().encode()).decode()
