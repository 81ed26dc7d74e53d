"""Compare stones from Python; without arguments, the paper's section 4: three samples, paper beside program.

python scripts/score_comparisons.py [STONE ...] [--engine auto] [--resolution 1024] [--out FOLDER]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import gemrender
from gemrender.engines import DEFAULT_ENGINE, ENGINES
from gemrender.report.comparison import comparison_figure, difference_figure, format_scores, panel

#: What the paper prints of its samples (section 4).
PAPER = {
    "inoue-1": {"Average": "45.10", "Rear": "22.8", ">= 75": "0.5"},
    "inoue-2": {"Average": "49", "Rear": "18.2", "60-75": "a little under 52"},
    "inoue-3": {"Average": "over 60", "Rear": "5.43"},
}


def main() -> None:
    """Trace, print, and draw if asked to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("stones", nargs="*", metavar="STONE", help="stone files, or names of bundled stones")
    parser.add_argument("--engine", choices=ENGINES, default=DEFAULT_ENGINE)
    parser.add_argument("--resolution", type=int, default=1024)
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where to put the figures")
    options = parser.parse_args()

    names = options.stones or list(PAPER)
    stones = [gemrender.load_stone(name) for name in names]
    observations = [
        gemrender.observe(stone, engine=options.engine, resolution=options.resolution) for stone in stones
    ]
    panels = [panel(observation) for observation in observations]
    scores = [score for score, _ in panels]

    if options.stones:
        print(format_scores(scores, "markdown"))
    else:
        print_beside_paper(scores)
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        comparison_figure(panels).savefig(options.out / "comparison.png")
        if len(observations) == 2:
            difference_figure(*observations).savefig(options.out / "difference.png")
        print(f"figures written to {options.out}")


def print_beside_paper(scores: list[gemrender.Score]) -> None:
    """Print what the paper reports of its three samples beside the program's figures."""
    print(f"{'':<16}{'':<10}{'paper':>20}{'gemrender':>12}")
    for published, score in zip(PAPER.values(), scores, strict=True):
        bright, second = score.bands[:2]
        computed = {
            "Average": score.average,
            "Rear": score.rear,
            ">= 75": bright.share,
            "60-75": second.share,
        }
        for number, value in computed.items():
            label = score.name if number == "Average" else ""
            print(f"{label:<16}{number:<10}{published.get(number, ''):>20}{value:>12.2f}")
    print("All in per cent. The paper traced samples 1 and 2 as measured, and calls the symmetry of 1 poor;")
    print("here all three are perfectly symmetric. See: gemrender symmetry inoue-2")


if __name__ == "__main__":
    main()
