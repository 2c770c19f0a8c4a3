"""`make bench`: check every contender, measure all in turns, print the tables and write docs/performance.md."""

from __future__ import annotations

import sys
from functools import partial

import numpy as np

from hillobs.studies.cli.shell.progress import bar
from hillobs.studies.cli.shell.tables import print_table
from hillobs.studies.cli.shell.terminal import complain, user_errors

from . import report, scaling, startup
from .contenders import Contender, contenders
from .machine import machine
from .problem import Problem, problem, states
from .roofline import PEAKS, peak
from .timing import interleaved, one_core, repeated


def main() -> None:
    """Measure and report."""
    one_core()
    with user_errors():
        of = problem()
        missing: list[str] = []
        taking_part = list(contenders(of, missing.append))
        deviations = checked(of, taking_part)
        with bar("rounds") as progress:
            amounts = {c.name: repeated(partial(counted, c)) for c in taking_part}
            rates = interleaved({**amounts, **{name: partial(peak, name) for name in PEAKS}}, progress)
        sections = [
            report.comparison(taking_part, rates, deviations),
            report.roofline(taking_part, rates),
            report.scaling(scaling.times(), 1 / of.grid.h),
            report.startup(startup.seconds()),
        ]
        memory = report.memory(*scaling.memory())
        for section in sections:
            print(section.title)
            print_table(section.table())
        left_out = [f"Left out: {sentence}." for sentence in missing]
        for line in (memory, *machine(), *left_out):
            print(line)
        report.write([*machine(), *left_out, *(section.markdown() for section in sections), memory])


def checked(of: Problem, taking_part: list[Contender]) -> dict[str, float]:
    """How far each ends from our kernel without noise; ends the program if one is too far."""
    deviations = {}
    for c in taking_part:
        deviations[c.name] = float(np.abs(c.final() - states(of, c.steps)).max())
        if not deviations[c.name] <= c.tolerance:
            complain(f"{c.name} ends {deviations[c.name]:.1e} from our kernel; at most {c.tolerance:g} is allowed")
            sys.exit(1)
    return deviations


def counted(contender: Contender) -> float:
    """Work once; closed-loop steps done."""
    contender.work()
    return contender.runs * contender.steps


if __name__ == "__main__":
    main()
