"""`python -m hostile`: draw cases, try them on all cores, print what is broken and how to see it again."""

from __future__ import annotations

import argparse
import os
import sys

from hostile.campaign import campaign
from hostile.one import one_again


def main() -> int:
    """0 if nothing is broken, 1 otherwise."""
    parser = argparse.ArgumentParser(prog="hostile", description=__doc__)
    parser.add_argument("--seed", type=int, default=0, help="of all that is drawn")
    parser.add_argument("--cases", type=int, default=2000, help="how many")
    parser.add_argument("--case", metavar="K|FILE.json", help="this one again, with its command, files and verdict")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes that try cases")
    asked = parser.parse_args()
    if asked.case is not None:
        return one_again(asked.seed, asked.case)
    return campaign(asked.seed, range(asked.cases), asked.workers)


if __name__ == "__main__":
    sys.exit(main())
