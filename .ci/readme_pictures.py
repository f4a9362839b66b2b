"""Draw the README's two pictures again: python .ci/readme_pictures.py

They are what the first command shows of its record, and a chain beside its code.
`tests/test_readme.py` draws them too, and compares their words with the README's.
"""

import textwrap
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import pandas as pd  # noqa: E402

import luenberger as lb  # noqa: E402
from luenberger.kernels.text import numpy_source  # noqa: E402
from luenberger.papers.leondes_novak.derivation import best_coordinates  # noqa: E402
from luenberger.show import describe  # noqa: E402
from matrixproof import latex, text  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "notebooks" / "pages" / "pictures"
PLANTS = ROOT / "notebooks" / "plants"
CHAIN = "(33) the gain that runs"
GREY, GREEN = "0.4", "#0a7d32"
SHOWN = slice(100, 400)  # rows of the record: 30 s


def ball_on_a_beam():
    """The record of the first command, its estimates, and what each design costs."""
    plant = lb.Plant.from_json(PLANTS / "ball-and-beam.json").sampled(0.1)
    record = pd.read_csv(PLANTS / "ball-and-beam.csv", index_col="time")
    y, u = record[list(plant.output_names)], record[list(plant.input_names)]
    y, u, time = y.to_numpy(), u.to_numpy(), record.index
    plant = lb.fit_noise(plant, lb.Record(y, u), Q="diagonal").plant
    found = lb.Filter(plant).run(lb.Record(y, u))
    figure, axes = plt.subplots(1, 3, figsize=(11, 3), layout="constrained")
    for state, ax in enumerate(axes[:2]):
        rows = time[SHOWN], found.x[SHOWN], found.std[SHOWN]
        measured = y[SHOWN, 0] if state == 0 else None
        lb.plot.estimates(plant, *rows, state, ax, y=measured)
    axes[0].legend(loc="upper left", fontsize="small")
    lb.plot.pareto(lb.compare(plant), axes[2])
    axes[2].set_title("every design: error against work")
    return figure


def chain_beside_code():
    """The chain of the gain that runs, and the NumPy that its stages become."""
    chain = best_coordinates.page.steps[CHAIN]
    _, source = numpy_source(best_coordinates.gain_step)
    body = textwrap.dedent("\n".join(source.splitlines()[1:-1]))
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11, 2.1), layout="constrained", width_ratios=(1, 0.95)
    )
    for ax in (left, right):
        ax.set(xlim=(0, 1), ylim=(0, 1))
        ax.set_axis_off()
    left.set_title("Each line is checked against its reason", loc="left")
    right.set_title("and the stages it proves become code", loc="left")
    for k, row in enumerate(chain.rows(latex)):
        at = 0.85 - 0.3 * k
        size = dict(fontsize=15, va="center", math_fontfamily="stix")
        left.text(0, at, f"${row.left}$" if row.left else "", **size)
        left.text(0.05, at, rf"${row.sign}\; {row.right}$", **size)
        size["fontsize"] = 13
        left.text(0.55, at, f"${row.reason}$", color=GREY, **size)
        left.text(0.93, at, "✓" if row.follows else "✗", color=GREEN, **size)
    look = dict(family="monospace", fontsize=10, va="top", linespacing=1.6)
    right.text(0.03, 0.97, body, **look)
    right.axvline(0, color="0.8")
    assert not chain.check(), text(chain.left)
    return figure


PICTURES = {"ball-on-a-beam": ball_on_a_beam, "chain-and-code": chain_beside_code}


def words(figure):
    """The words that stand for a figure, on one line."""
    return " ".join(describe(figure).split())


def main():
    FOLDER.mkdir(exist_ok=True)
    for name, draw in PICTURES.items():
        figure = draw()
        said = words(figure)
        metadata = {"Software": None, "Description": said}
        figure.savefig(FOLDER / f"{name}.png", dpi=160, metadata=metadata)
        plt.close(figure)
        print(f"![{said}](notebooks/pages/pictures/{name}.png)\n")


if __name__ == "__main__":
    main()
