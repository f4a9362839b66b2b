"""One command that says what differs; see `--help`."""

import argparse
import os
import sys
from pathlib import Path

SUPPORT = Path(__file__).resolve().parents[1]
sys.path[0] = str(SUPPORT)
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"


def arguments():
    parser = argparse.ArgumentParser(prog="python tests/support/judge")
    commands = parser.add_subparsers(dest="command", required=True)
    exact = commands.add_parser("exact", help="random problems beside exact arithmetic")
    exact.add_argument("--count", type=int, default=20_000, help="problems")
    exact.add_argument("--first", type=int, default=0, help="the seed of the first")
    exact.add_argument("--seed", type=int, help="this problem alone")
    exact.add_argument("--jobs", type=int, default=2, help="processes")
    exact.add_argument("--minutes", type=float, help="stop then, with what is done")
    shown = commands.add_parser("notebooks", help="what notebooks show otherwise")
    speed = commands.add_parser("timings", help="ratios of times to an older checkout")
    speed.add_argument("--rounds", type=int, default=7, help="turns of each")
    speed.add_argument("--only", default="", help="rows whose name has these words")
    for one in shown, speed:
        one.add_argument("--against", default="1118657", help="the older commit")
    return parser.parse_args()


def main():
    given = arguments()
    if given.command == "exact":
        from judge import exact

        if given.seed is not None:
            return exact.main(1, given.seed, 1)
        return exact.main(given.count, given.first, given.jobs, given.minutes)
    from judge import checkout

    if given.command == "notebooks":
        return checkout.notebooks(given.against)
    return checkout.timings(given.against, given.rounds, given.only)


if __name__ == "__main__":
    sys.exit(main())
