"""Many cases on some processes, and what is printed of them."""

from __future__ import annotations

import contextlib
import os
import selectors
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hostile.case import as_json, merged
from hostile.recipe import recipe
from hostile.shrink import kind, shrunk
from hostile.warm import Warm

# one case in so many is run twice
_AGAIN = 20


def campaign(seed: int, numbers: Iterable[int], workers: int) -> int:
    """Try cases of a seed; 1 if a promise was broken."""
    start, codes, fresh, broken = time.monotonic(), Counter[int](), 0, []
    with own_cache():
        for number, layers, verdict in _answers(seed, iter(numbers), workers):
            codes[verdict["code"]] += 1
            fresh += merged(layers).fresh
            if verdict["wrong"]:
                broken.append((number, layers, verdict))
                print(f"case {number}: {'; '.join(verdict['wrong'])}", flush=True)
            if codes.total() % 200 == 0:
                print(f"{codes.total()} cases, {len(broken)} broken, {time.monotonic() - start:.0f} s", flush=True)
        _report(seed, broken)
    counts = ", ".join(f"{count} × {code}" for code, count in sorted(codes.items()))
    print(f"seed {seed}: {codes.total()} cases, {fresh} in processes of their own, {time.monotonic() - start:.0f} s")
    print(f"exit codes: {counts}\n{len(broken)} broke a promise")
    return 1 if broken else 0


@contextlib.contextmanager
def own_cache() -> Iterator[None]:
    """A cache of libraries for all cases; one that is named stays."""
    with tempfile.TemporaryDirectory(prefix="hostile-") as folder:
        os.environ.setdefault("HILLOBS_CACHE", f"{folder}/cache")
        yield


def _answers(seed: int, numbers: Iterator[int], workers: int) -> Iterator[tuple[int, Any, Mapping[str, Any]]]:
    """Number, layers and verdict of each case, as they come."""
    with contextlib.ExitStack() as stack, selectors.DefaultSelector() as selector:
        for _ in range(workers):
            warm = stack.enter_context(Warm())
            if (number := next(numbers, None)) is not None:
                warm.ask(seed=seed, number=number, again=number % _AGAIN == 0)
                selector.register(warm, selectors.EVENT_READ, number)
        while selector.get_map():
            for key, _ in selector.select():
                warm = key.fileobj
                answer, number = warm.answer(), key.data
                selector.unregister(warm)
                if (following := next(numbers, None)) is not None:
                    warm.ask(seed=seed, number=following, again=following % _AGAIN == 0)
                    selector.register(warm, selectors.EVENT_READ, following)
                yield number, answer["layers"], answer["verdict"]


def _report(seed: int, broken: list[tuple[int, Any, Mapping[str, Any]]]) -> None:
    """The first case of each kind of mistake: shrunk, as a recipe, and as a file for the corpus."""
    kinds: dict[str, list[int]] = {}
    for number, _, verdict in broken:
        kinds.setdefault(kind(verdict["wrong"][0]), []).append(number)
    if not broken:
        return
    cases = {number: (layers, verdict) for number, layers, verdict in broken}
    folder = Path("results/hostile")
    folder.mkdir(parents=True, exist_ok=True)
    with Warm() as warm:
        for of_kind in kinds.values():
            layers, verdict = cases[of_kind[0]]
            case = merged(shrunk(warm, layers, verdict["wrong"]))
            path = folder / f"{seed}-{of_kind[0]}.json"
            path.write_text(as_json(case))
            print(f"\n{verdict['wrong'][0]}\n  cases {', '.join(map(str, of_kind))}; {path}; in short:")
            print("\n".join(f"  {line[:2000]}" for line in recipe(case)))
    sys.stdout.flush()
