"""The one ancestor of all errors that are a sentence for the user: `except hillobs.Error` catches every one."""

from __future__ import annotations


class Error(Exception):
    """What a user has to be told, in one sentence."""
