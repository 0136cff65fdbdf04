#!/usr/bin/env python3
"""Pictures of the examples dam_break and sloshing_tank. Needs NumPy, VTK and matplotlib.

    plot_fluids.py dam_break|sloshing_tank FOLDER PICTURE

FOLDER is the output folder of `bia run`. References: Martin & Moyce 1952 and linear theory of waves.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy
from study_fluids import FRONT, GRAVITY, HEIGHT, SLOSHING, read
from vtk_files import fields_of, points_of, read_grid, read_series

BLUE, GREY = "#2060a0", "#606060"


def points(folder, time):
    """Places and fields of the points at a time of the series."""
    entries = read_series(next(Path(folder).glob("vtk_output/*.pvd")))
    nearest = min((entry for entry in entries), key=lambda entry: abs(entry.time - time))
    grid = read_grid(nearest.file)
    return points_of(grid), fields_of(grid.GetPointData())


def dam_break(folder, picture):
    figure = plt.figure(figsize=(7.5, 9), layout="constrained")
    grid = figure.add_gridspec(4, 2)
    for row, time in enumerate((0.25, 0.5, 0.85)):
        axes = figure.add_subplot(grid[row, :])
        x, fields = points(folder, time)
        speed = numpy.linalg.norm(fields["MP_VELOCITY"], axis=1)
        shown = axes.scatter(x[:, 0], x[:, 1], c=speed, s=4.0, lw=0, cmap="viridis", vmin=0.0, vmax=8.0)
        axes.set(aspect="equal", xlim=(0, 6), ylim=(0, 2.1), ylabel="y [m]")
        axes.text(0.99, 0.9, f"t = {time} s", transform=axes.transAxes, ha="right", va="top")
    figure.colorbar(shown, ax=figure.axes, shrink=0.7, label="speed [m/s]")
    front, height = (read(Path(folder) / f"{name}.csv") for name in ("front", "height"))
    left, right = figure.add_subplot(grid[3, 0]), figure.add_subplot(grid[3, 1])
    left.plot(front[:, 0] * numpy.sqrt(2.0 * GRAVITY), front[:, 1], color=BLUE, label="front x/a")
    left.plot(*FRONT.T, ".", color=GREY, label="Martin & Moyce")
    left.set(xlabel="t √(2 g/a)", xlim=(0, 4))
    right.plot(height[:, 0] * numpy.sqrt(GRAVITY), height[:, 1] / 2.0, color=BLUE, label="height η/(2 a)")
    right.plot(*HEIGHT.T, ".", color=GREY, label="Martin & Moyce")
    right.set(xlabel="t √(g/a)", xlim=(0, 2.8))
    for axes in (left, right):
        axes.legend()
    figure.savefig(picture, dpi=110)


def sloshing_tank(folder, picture):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    x, fields = points(folder, 1.2)
    speed = 1e3 * numpy.linalg.norm(fields["MP_VELOCITY"], axis=1)
    shown = left.scatter(x[:, 0], x[:, 1], c=speed, s=4.0, lw=0, cmap="viridis")
    left.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="speed at 1.2 s [mm/s]")
    figure.colorbar(shown, ax=left)
    totals = read(Path(folder) / "totals.csv")
    # The wave a cos(k x) moves the centre of mass by 2 a/(k² H).
    swing = 2e3 * 0.001 / (numpy.pi**2 * 0.5)
    right.plot(totals[:, 0], 1e3 * (totals[:, 1] - 0.5), color=BLUE, label="Bia")
    sign = numpy.sign(totals[20, 1] - 0.5)
    right.plot(totals[::12, 0], sign * swing * numpy.sin(SLOSHING * totals[::12, 0]), ".", color=GREY, label="linear theory")
    right.set(xlabel="t [s]", ylabel="centre of mass aside [mm]")
    right.legend(loc="upper right")
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in ("dam_break", "sloshing_tank"):
        sys.exit(__doc__)
    globals()[sys.argv[1]](*sys.argv[2:])
