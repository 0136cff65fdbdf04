"""Picture of the example cook_incompressible. Needs NumPy, VTK and matplotlib.

    plot_cook.py NONE OSGS RESET NEVER PICTURE

The first four are output folders of `bia run`: the static project without and with stabilisation, and the dynamic
one with and without the grid's reset. References are those beside the example.
"""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy
from vtk_files import fields_of, points_of, read_grid

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "cook_incompressible"
BLUE, ORANGE, GREY = "#2060a0", "#d06010", "#606060"
LARGEST = 15.0


def table(path):
    """Columns of a table by heading."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return {name: numpy.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}


def body(axes, folder, title):
    """The points where they are, coloured by their pressure."""
    grid = read_grid(max(Path(folder).glob("vtk_output/*.vtu"), key=lambda path: path.stat().st_mtime))
    x, fields = points_of(grid), fields_of(grid.GetPointData())
    pressure = 1e-6 * fields["MP_PRESSURE"]
    shown = axes.scatter(x[:, 0], x[:, 1], c=pressure, s=2.0, lw=0, cmap="coolwarm", vmin=-LARGEST, vmax=LARGEST)
    axes.set(title=title, aspect="equal", xlabel="x [m]", xlim=(-0.1, 4.9), ylim=(-0.1, 7.0))
    return shown


def main(none, osgs, reset, never, picture):
    figure, ((a, b), (c, d)) = plt.subplots(2, 2, figsize=(9, 7.4), layout="constrained")
    body(a, none, "no stabilisation")
    shown = body(b, osgs, "osgs")
    a.set_ylabel("y [m]")
    figure.colorbar(shown, ax=(a, b), label="pressure, tension positive [MPa]")
    reference = table(EXAMPLE / "reference_pressure.csv")
    for folder, colour, label in ((none, ORANGE, "no stabilisation"), (osgs, BLUE, "osgs")):
        found = table(Path(folder) / "pressure.csv")
        c.plot(found["Y [m]"], 1e-6 * found["PRESSURE [Pa]"], color=colour, lw=0.9, label=label)
    exact = 1e-6 * reference["PRESSURE at 6.25 MN/m [Pa]"]
    c.plot(reference["Y [m]"], exact, ".", color=GREY, ms=4, label="reference")
    c.set(xlabel="Y [m] at X = 2.4 m", ylabel="pressure [MPa]", ylim=(-40, 40))
    history = table(EXAMPLE / "reference_tip.csv")
    d.plot(1e3 * history["TIME [s]"], history["DISPLACEMENT_Y [m]"], color=GREY, lw=1, label="reference")
    for folder, colour, label in ((reset, ORANGE, "osgs, grid reset"), (never, BLUE, "osgs, no reset")):
        found = table(Path(folder) / "tip.csv")
        d.plot(1e3 * found["TIME [s]"], found["MPC_DISPLACEMENT_Y [m]"], ".", color=colour, ms=3, label=label)
    d.set(xlabel="t [ms]", ylabel="rise of the corner [m]", xlim=(0, 100))
    for axes in (c, d):
        axes.legend(loc="lower center" if axes is d else "best", framealpha=0.9)
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    main(*sys.argv[1:])
