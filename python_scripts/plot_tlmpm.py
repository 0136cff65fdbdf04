"""Pictures of the examples tlmpm_column, tlmpm_step_bar and tlmpm_energy. Needs NumPy and matplotlib.

    plot_tlmpm.py column RECORD DOCUMENT_RECORD PICTURE
    plot_tlmpm.py step_bar RECORD PICTURE
    plot_tlmpm.py energy ENERGY.dat DOCUMENT_ENERGY.dat PICTURE

RECORD is what `bia run --record` writes.
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

BLUE, ORANGE, GREY = "#2060a0", "#d06010", "#606060"


def states(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)["snapshots"]


def along(state, field):
    """First components of a field of the points."""
    return np.array([row[0] if isinstance(row, list) else row for row in state["mp"][field]])


def column(record, document, picture):
    """Displacement and stress of the column at rest against the equilibrium."""
    young, poisson, length, weight, pressure = 5e3, 0.3, 0.1, 98.1, 1e4
    lam = young * poisson / (1 + poisson) / (1 - 2 * poisson)
    mu = young / 2 / (1 + poisson)
    x = np.linspace(0, length, 2001)
    target = -pressure - weight * (length - x)
    f = np.full_like(x, 0.6)
    for _ in range(50):
        slope = mu * (1 + 1 / f**2) + lam * (1 - np.log(f)) / f**2
        f -= (mu * (f - 1 / f) + lam * np.log(f) / f - target) / slope
    u = np.concatenate([[0], np.cumsum((f[1:] + f[:-1]) / 2 - 1)]) * (x[1] - x[0])
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    left.plot(1e3 * x, 1e3 * u, color=GREY, label="equilibrium")
    right.plot(1e3 * x, target + pressure, color=GREY, label="equilibrium")
    for path, colour, marker, label in [
        (record, BLUE, "o", "moved by the grid"),
        (document, ORANGE, "x", "moved as in the document"),
    ]:
        first, *_, last = states(path)
        place = 1e3 * along(first, "MP_COORD")
        left.plot(place, 1e3 * along(last, "MP_DISPLACEMENT"), marker, color=colour, ms=4, label=label)
        right.plot(place, along(last, "MP_CAUCHY_STRESS_VECTOR") + pressure, marker, color=colour, ms=4, label=label)
    left.set(xlabel="X [mm]", ylabel="displacement [mm]")
    right.set(xlabel="X [mm]", ylabel="stress + 10 kPa [Pa]")
    left.legend(frameon=False)
    figure.savefig(picture, dpi=110)


def step_bar(record, picture):
    """Displacement of the last point in time against d'Alembert's solution of the linear bar."""
    young, density, length, traction = 250.0, 1.9355e-3, 5.0, -1.27
    c = np.sqrt(young / density)
    run = states(record)
    x = along(run[0], "MP_COORD")[-1]

    def rise(s):
        s = np.maximum(s, 0)
        return 2 * length * np.floor(s / (4 * length)) + np.minimum(s % (4 * length), 2 * length)

    t = np.linspace(0, 0.2, 2001)
    exact = traction / young * (rise(c * t - (length - x)) - rise(c * t - (length + x)))
    figure, axes = plt.subplots(figsize=(9, 3.4), layout="constrained")
    axes.plot(t, exact, color=GREY, lw=1, label="linear bar, d'Alembert")
    times = [state["time"] for state in run]
    end = [along(state, "MP_DISPLACEMENT")[-1] for state in run]
    axes.plot(times, end, ".", color=BLUE, ms=4, label="neo-Hookean bar")
    axes.set(xlabel="t [ms]", ylabel="displacement of the end [mm]", xlim=(0, 0.2))
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(picture, dpi=110)


def energy(conserving, document, picture):
    """Total energies of both schemes, and what the conserving one changes."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    for path, colour, label in [(conserving, BLUE, "Yoshida"), (document, ORANGE, "the document's, α = 0.5")]:
        # Time, potential, kinetic, strain, total.
        table = np.loadtxt(path, comments="#")
        t, total = table[:, 0], table[:, 2] + table[:, 3]
        left.plot(1e3 * t, total / 5e-5, color=colour, label=label)
        if path == conserving:
            left.plot(1e3 * t, table[:, 2] / 5e-5, color=GREY, lw=0.7, label="its kinetic part")
            right.plot(1e3 * t, total / 5e-5 - 1, color=colour, lw=0.8)
    left.set(xlabel="t [ms]", ylabel="energy / energy at the start")
    left.legend(frameon=False)
    right.set(xlabel="t [ms]", ylabel="relative change, Yoshida")
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    plots = {"column": (column, 3), "step_bar": (step_bar, 2), "energy": (energy, 3)}
    chosen, count = plots.get(sys.argv[1] if len(sys.argv) > 1 else "", (None, 0))
    if chosen is None or len(sys.argv) != 2 + count:
        sys.exit(__doc__)
    chosen(*sys.argv[2:])
