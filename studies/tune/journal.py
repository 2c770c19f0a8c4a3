"""The file of a search: Optuna's journal, written whole after each round, so that a kill loses a round at most."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from optuna.storages.journal import BaseJournalBackend

from ..files.errors import ResultError
from ..files.writing import refuse_overwriting, write_pieces

# the key of the first line, which says whose search it is
_SEARCH = "hillobs search"
# what Optuna notes of who made a trial when: in the file always this, so that the same search makes the same file
_NOBODY = {"worker_id": "", "datetime_start": "1970-01-01T00:00:00", "datetime_complete": "1970-01-01T00:00:00"}


class Journal(BaseJournalBackend):
    """Optuna's own storage in a file, which is never half written; without a path in memory alone.

    ResultError if something else is there, or another search than `identity` names.
    """

    def __init__(self, path: Path | None, identity: str) -> None:
        self._path, self._head = path, json.dumps({_SEARCH: identity})
        # as text: Optuna goes on changing what it has appended
        self._entries = self._earlier()
        self._lines = list(self._entries)

    def read_logs(self, log_number_from: int) -> Iterable[dict[str, Any]]:
        """What Optuna has appended, from a number on."""
        return map(json.loads, self._entries[log_number_from:])

    def append_logs(self, logs: list[dict[str, Any]]) -> None:
        """What Optuna does; it is in the file with the next `keep`."""
        self._entries += map(json.dumps, logs)
        self._lines += (json.dumps({key: log[key] and _NOBODY.get(key, log[key]) for key in log}) for log in logs)

    def keep(self) -> None:
        """Write the file. ResultError if that fails."""
        if self._path is not None:
            write_pieces(self._path, (f"{line}\n".encode() for line in [self._head, *self._lines]))

    def _earlier(self) -> list[str]:
        if self._path is None:
            return []
        refuse_overwriting([self._path])
        if not self._path.exists():
            return []
        # to the byte what was written here: nobody else's lines get this far
        head, *entries = self._path.read_text(encoding="utf-8").splitlines()
        if head != self._head:
            raise ResultError(
                f"{self._path} is of another search: other numbers, ranges, quantities, seeds or code; "
                "move it away, or name another --out"
            )
        return entries
