"""One case again, with all that can be seen of it."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from hostile.campaign import own_cache
from hostile.case import as_json, merged, read_case
from hostile.recipe import recipe
from hostile.warm import Warm


def one_again(seed: int, which: str) -> int:
    """The case of this number, or in this file: printed, tried twice, judged; 1 if a promise is broken."""
    with own_cache(), Warm() as warm:
        if which.isdigit():
            warm.ask(seed=seed, number=int(which), again=True)
        else:
            case, _ = read_case(Path(which))
            warm.ask(layers=[dataclasses.asdict(case)], again=True)
        answer = warm.answer()
    case, verdict = merged(answer["layers"]), answer["verdict"]
    print(as_json(case))
    print("\n".join(recipe(case)))
    print(f"\nexit code {verdict['code']} after {verdict['seconds']:.1f} s\n--- stdout\n{verdict['out'][-3000:]}")
    print(f"--- stderr\n{verdict['err'][-3000:]}\n---")
    print("\n".join(verdict["wrong"]) or "no promise is broken")
    return 1 if verdict["wrong"] else 0
