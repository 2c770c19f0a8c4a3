"""`python launch.py REPORT CASE`: the command of a case from its first import on, with its limits and signals."""

from __future__ import annotations

import importlib
import json
import runpy
import sys
from functools import partial
from pathlib import Path

# signals are counted from here on: before it, Python and what catches signals are still being loaded
_FIRST = "studies/cli/main.py"


def main() -> None:
    """Become the command."""
    # the folder of this file is no place for its imports
    sys.path[0] = str(Path(__file__).parents[1])
    from hostile.calls import limit, run_program, strike_at_calls, teller

    report, case = int(sys.argv[1]), json.loads(sys.argv[2])
    sys.path.pop(0)
    sys.argv = ["hillobs", *case["words"]]
    start = partial(runpy.run_module, "hillobs", run_name="__main__", alter_sys=True)
    if case["limits"]:
        # a limit that lets nothing be imported says nothing of ours
        importlib.import_module("hillobs.studies.cli.simulate")
        from hillobs.__main__ import main as start

        limit(case["limits"])
    strike_at_calls(case["signals"], teller(report), _FIRST)
    if case["python"]:
        sys.path.insert(0, str(Path(__file__).parents[1]))
        run_program(case["python"])
    else:
        start()


if __name__ == "__main__":
    main()
