"""Pictures of the examples dgmpm_bar, dgmpm_svk_bar and dgmpm_plate. Needs NumPy and matplotlib.

    plot_dgmpm.py bar RECORD PICTURE
    plot_dgmpm.py svk_bar RECORD_FAN RECORD_SHOCK PICTURE
    plot_dgmpm.py plate RECORD PICTURE

RECORD is what `bia run --record` writes.
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

BLUE, ORANGE, GREY = "#2060a0", "#d06010", "#606060"
YOUNG, DENSITY, LENGTH = 2e11, 7800.0, 6.0


def states(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)["snapshots"]


def component(state, field, index=0):
    """One component of a field of the points."""
    return np.array([row[index] for row in state["mp"][field]])


def nearest(all_states, time):
    return min(all_states, key=lambda state: abs(state["time"] - time))


def bar(record, picture):
    """Stress along the elastic bar against d'Alembert's solution, before and after the turn at the end."""
    all_states, speed, load = states(record), (YOUNG / DENSITY) ** 0.5, 1e9
    place = component(all_states[0], "MP_COORD")
    x = np.linspace(0, LENGTH, 3001)
    figure, axes = plt.subplots(1, 3, figsize=(10, 3), layout="constrained", sharey=True)
    for axis, time in zip(axes, [4e-4, 9e-4, 1.5e-3]):
        state = nearest(all_states, time)
        front = speed * state["time"]
        exact = np.where(x < min(front, LENGTH), -load, 0.0)
        if front > LENGTH:
            exact = np.where(x > 2 * LENGTH - front, 0.0, exact)
        axis.plot(x, exact / 1e9, color=GREY, label="exact")
        axis.plot(place, component(state, "MP_CAUCHY_STRESS_VECTOR") / 1e9, ".", color=BLUE, ms=3, label="Bia")
        axis.set(title=f"{1e3 * state['time']:.3f} ms", xlabel="x [m]")
    axes[0].set(ylabel="stress [GPa]")
    axes[0].legend(frameon=False)
    figure.savefig(picture, dpi=110)


def stress(stretch):
    return YOUNG / 2 * stretch * (stretch**2 - 1)


def exact_wave(load, x, time):
    """P of the bar: a fan in compression, a shock in tension."""
    loaded = 1.0
    for _ in range(60):
        loaded -= (stress(loaded) - load) / (YOUNG / 2 * (3 * loaded**2 - 1))
    xi = x / time
    if load > 0:
        return np.where(xi < (load / (DENSITY * (loaded - 1))) ** 0.5, load, 0.0)
    speed = lambda f: (YOUNG * (3 * f**2 - 1) / (2 * DENSITY)) ** 0.5
    fan = stress(((2 * DENSITY * xi**2 / YOUNG + 1) / 3) ** 0.5)
    return np.where(xi < speed(loaded), load, np.where(xi > speed(1.0), 0.0, fan))


def svk_bar(fan, shock, picture):
    """First Piola-Kirchhoff stress along the Saint-Venant-Kirchhoff bar."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    x = np.linspace(1e-3, LENGTH, 3001)
    for axis, record, load, title in [(axes[0], fan, -1e10, "compression: fan"), (axes[1], shock, 1e10, "tension: shock")]:
        all_states = states(record)
        place = component(all_states[0], "MP_COORD")
        for time, colour in [(2e-4, ORANGE), (8e-4, BLUE)]:
            state = nearest(all_states, time)
            axis.plot(x, exact_wave(load, x, state["time"]) / 1e9, color=GREY, lw=1)
            label = f"{1e3 * state['time']:.2f} ms"
            axis.plot(place, component(state, "MP_PK1_STRESS_TENSOR") / 1e9, ".", color=colour, ms=3, label=label)
        axis.set(title=title, xlabel="X [m]", ylabel="P [GPa]")
        axis.legend(frameon=False)
    figure.savefig(picture, dpi=110)


def plate(record, picture):
    """Longitudinal stress in the plate and along its bottom row."""
    all_states = states(record)
    state = all_states[-1]
    x, y = (component(all_states[0], "MP_COORD", axis) for axis in range(2))
    sxx = component(state, "MP_CAUCHY_STRESS_VECTOR") / 1e6
    columns, rows = len(np.unique(x.round(9))), len(np.unique(y.round(9)))
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.4), layout="constrained")
    image = left.imshow(sxx.reshape(rows, columns), origin="lower", extent=(0, 4, 0, 3), cmap="viridis", vmin=-260, vmax=60)
    figure.colorbar(image, ax=left, label="stress xx [MPa]")
    left.set(title=f"{1e3 * state['time']:.2f} ms", xlabel="x [m]", ylabel="y [m]")
    for time, colour in [(2e-4, ORANGE), (4e-4, GREY), (5.5e-4, BLUE)]:
        state = nearest(all_states, time)
        row = component(state, "MP_CAUCHY_STRESS_VECTOR")[:columns] / 1e6
        right.step(x[:columns], row, where="mid", color=colour, label=f"{1e3 * state['time']:.2f} ms")
    right.axhline(-229.129, color="0.8", zorder=0)
    right.set(xlabel="x [m]", ylabel="stress xx of the bottom row [MPa]")
    right.legend(frameon=False)
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    {"bar": bar, "svk_bar": svk_bar, "plate": plate}[sys.argv[1]](*sys.argv[2:])
