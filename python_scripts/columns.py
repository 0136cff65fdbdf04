#!/usr/bin/env python3
"""Runs the bending and the twisting column in many ways and prints how far each is from the reference.

    columns.py [--bia PROGRAM] [--threads N] [GROUP ...]

Without a group all of them run, one after the other. Each line of the tables is one run of the project in
`examples/`, changed by `--set`; the numbers come from the tables that its measuring processes write. The
motion of the corner X is x_p + F_p (X - X_p) of the nearest material point p.

The reference is an explicit spectral-element solution in displacements (GLL nodes, order 5 to 7, energy kept
to 4e-5), neo-Hookean with nu = 0.499 (bending, extrapolated; within 0.02 m to 1.25 s), 0.4999 (twisting) and
0.45. Standard library only.
"""

import argparse
import csv
import json
import math
import re
import subprocess
import sys
import tempfile
from bisect import bisect
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# u_x of (0.5, 0, 6) in m every 0.05 s.
BEND = {
    0.5: [
        0.0, 0.4891, 0.9846, 1.5311, 1.9839, 2.3313, 2.5817, 2.7315, 2.8291, 2.8699, 2.8448, 2.7574, 2.5772, 2.3008,
        1.9217, 1.4592, 1.01, 0.5421, 0.0607, -0.48, -1.1159, -1.6841, -2.1472, -2.4841, -2.7069, -2.9139,
    ],
    0.45: [
        0.0, 0.4894, 0.985, 1.5302, 1.9833, 2.3314, 2.5821, 2.7356, 2.8375, 2.8797, 2.8566, 2.7729, 2.5976, 2.3223,
        1.9471, 1.4898, 1.0425, 0.5808, 0.1041, -0.4401, -1.0736, -1.6462, -2.1145, -2.4585, -2.6955, -2.9061,
    ],
}
# Angle of (0.5, 0.5, 6) about the axis in rad: first extreme, first untwisting in s, second extreme, second
# untwisting.
TWIST = {0.5: (-5.983, 0.18083, 5.524, 0.35865), 0.45: (-5.892, 0.17924, 5.506, 0.35568)}

MIXED = "HyperElasticNeoHookeanUP3DLaw"
DISPLACEMENT = "HyperElasticNeoHookean3DLaw"
MATERIAL = "/solver_settings/material_import_settings/materials/0/Material"
COLUMN = "/modelers/1/parameters/bodies/0"
GRID = "/modelers/0/parameters"


class Run:
    """One run of an example with changes."""

    def __init__(self, program, threads, example, changes):
        project = ROOT / "examples" / example / "ProjectParameters.json"
        with tempfile.TemporaryDirectory() as folder:
            command = [program, "run", str(project), "--threads", str(threads), "--output", folder]
            for pointer, value in changes.items():
                command += ["--set", f"{pointer}={json.dumps(value)}"]
            ended = subprocess.run(command, capture_output=True, text=True)
            told = ended.stdout + ended.stderr
            self.failure = None if ended.returncode == 0 else told.strip()
            self.tip = rows(Path(folder) / "tip.csv")
            self.energy = rows(Path(folder) / "energy.dat")
        self.cpu = number(r"CPU ([0-9.e+-]+) s", told)
        steps = number(r"done: (\d+) steps", told)
        self.iterations = number(r"(\d+) Newton iterations", told) / steps if steps else math.nan

    def corner(self, place):
        """Times and displacements of a place that the nearest point carries along."""
        names, table = self.tip
        start = next(i for i, name in enumerate(names) if name.startswith("MP_COORD"))
        gradient = next(i for i, name in enumerate(names) if name.startswith("MP_DEFORMATION_GRADIENT"))
        arm = [place[a] - table[0][start + a] for a in range(3)]
        for row in table:
            f = [row[gradient + 3 * a :][:3] for a in range(3)]
            now = [row[start + a] + sum(f[a][b] * arm[b] for b in range(3)) for a in range(3)]
            yield row[0], [now[a] - place[a] for a in range(3)]

    def energies(self):
        """Times and total energies over the first one."""
        _, table = self.energy
        return [(row[0], row[4] / table[0][4]) for row in table]


def rows(path):
    """Headings and numbers of a table of ours."""
    if not path.exists():
        return [], []
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    if path.suffix == ".csv":
        names, *lines = list(csv.reader(lines))
        return names, [[float(x) for x in line] for line in lines]
    return [], [[float(x) for x in line.split()] for line in lines]


def number(pattern, text):
    found = re.search(pattern, text)
    return float(found.group(1)) if found else math.nan


def at(series, time):
    """Linear between the rows of a series (time, value)."""
    times = [t for t, _ in series]
    i = min(max(bisect(times, time), 1), len(series) - 1)
    (t0, a), (t1, b) = series[i - 1], series[i]
    return a + (b - a) * (time - t0) / (t1 - t0)


def bend_line(run, poisson):
    """Error of the tip in percent of its amplitude, the tip at three times, and the energy."""
    reference = BEND[poisson]
    tip = [(t, u[0]) for t, u in run.corner([0.5, 0.0, 6.0])]
    last = tip[-1][0] + 1e-9
    amplitude = max(abs(u) for u in reference)
    errors = [(0.05 * i, abs(at(tip, 0.05 * i) - u)) for i, u in enumerate(reference) if 0.05 * i <= last]
    until = lambda end: 100 * max(error for time, error in errors if time <= end + 1e-9) / amplitude
    energies = run.energies()
    value = lambda time: f"{at(tip, time):.3f}" if time <= last else "-"
    share = lambda time: f"{at(energies, time):.3f}" if time <= last else "-"
    worst = f"{until(1.25):.1f}" if last >= 1.25 else f"stops at {tip[-1][0]:.2f} s"
    return [f"{until(0.5):.1f}", worst, value(0.5), value(1.0), value(1.25), share(0.5), share(1.25)]


def angles(run):
    """The angle of the corner about the axis, continuous in time."""
    before = 0.0
    for time, u in run.corner([0.5, 0.5, 6.0]):
        angle = math.atan2(0.5 + u[1], 0.5 + u[0]) - math.pi / 4
        angle -= 2 * math.pi * round((angle - before) / (2 * math.pi))
        before = angle
        yield time, angle


def twist_line(run, poisson):
    """Extremes of the angle and untwisting times with their errors in percent, and the energy."""
    series = list(angles(run))
    crossings = [
        t0 - a * (t1 - t0) / (b - a) for (t0, a), (t1, b) in zip(series, series[1:]) if t0 > 0.02 and a * b < 0
    ]
    found = [
        min(a for _, a in series),
        crossings[0] if crossings else None,
        max((a for t, a in series if crossings and t > crossings[0]), default=None),
        crossings[1] if len(crossings) > 1 else None,
    ]
    shown = [
        "-" if value is None else f"{value:.4g} ({100 * (value / exact - 1):+.1f})"
        for value, exact in zip(found, TWIST[poisson])
    ]
    energies = [share for _, share in run.energies()]
    rise = max((b - a for a, b in zip(energies[1:], energies[2:])), default=0.0)
    end = f"{series[-1][0]:.3f}"
    return [end, *shown, f"{max(energies[1:]):.4f}", f"{energies[-1]:.4f}", f"{rise:.1e}"]


HEADS = {
    "bend": ["error to 0.5 s [%]", "to 1.25 s [%]", "u_x 0.5 s", "1.0 s", "1.25 s", "E/E0 0.5 s", "1.25 s"],
    "twist": ["end [s]", "1st extreme [rad] (%)", "untwisted [s] (%)", "2nd extreme", "untwisted",
              "max E/E0", "E/E0 at the end", "largest rise a step"],
}


def material(points, poisson=0.5, law=MIXED):
    return {
        f"{MATERIAL}/Variables/MATERIAL_POINTS_PER_ELEMENT": points,
        f"{MATERIAL}/Variables/POISSON_RATIO": poisson,
        f"{MATERIAL}/constitutive_law/name": law,
    }


def tetrahedra(points=14):
    return {f"{COLUMN}/shape": "tetrahedron", f"{GRID}/shape": "tetrahedron", **material(points)}


def solver(**members):
    return {f"/solver_settings/{key}": value for key, value in members.items()}


def step(length):
    return {"/solver_settings/time_stepping/time_step": length}


def displacement(points, poisson=0.45, **members):
    return material(points, poisson, DISPLACEMENT) | solver(pressure_dofs=False, **members)


def cases(group):
    """Example with its end, Poisson's ratio of the reference, name and changes of the runs of a group."""
    bend, twist = ("bend", 1.2499), ("twist", 0.4999)
    never = {"grid_reset": "never"}
    # Points that hardly reach into a cell leave its nodes with next to no consistent mass.
    every = {"grid_reset": "every_step", "consistent_mass_matrix": False}
    c1 = lambda value: {"stabilization_parameters": {"c1": value}}
    if group == "bend":
        yield bend, 0.5, "hexahedra, 8 points", material(8)
        yield bend, 0.5, "the same, half the step", material(8) | step(0.005)
        yield bend, 0.5, "the same, Newmark", material(8) | solver(scheme_type="newmark")
        yield bend, 0.5, "the same, lumped mass", material(8) | solver(consistent_mass_matrix=False)
        yield bend, 0.5, "hexahedra, 27 points", material(27)
        yield bend, 0.5, "hexahedra, 8 points, c1 = 1", material(8) | solver(**c1(1.0))
        yield bend, 0.5, "hexahedra, 8 points, c1 = 4", material(8) | solver(**c1(4.0))
        yield bend, 0.5, "hexahedra, 8 points, OSGS", material(8) | solver(stabilization="osgs")
        yield bend, 0.5, "hexahedra, 8 points, PPP", material(8) | solver(stabilization="ppp")
        yield bend, 0.5, "hexahedra, 8 points, none", material(8) | solver(stabilization="none")
        yield bend, 0.5, "tetrahedra, 14 points", tetrahedra()
        yield bend, 0.5, "tetrahedra, 14 points, c1 = 1", tetrahedra() | solver(**c1(1.0))
    elif group == "bend_reset":
        for points in (8, 27, 64, 125):
            yield bend, 0.5, f"hexahedra, {points} points", material(points) | solver(**every)
        yield bend, 0.5, "hexahedra, 27 points, half the step", material(27) | solver(**every) | step(0.005)
        yield bend, 0.5, "tetrahedra, 14 points", tetrahedra() | solver(**every)
    elif group == "twist":
        yield twist, 0.5, "hexahedra, 8 points", material(8)
        yield twist, 0.5, "the same, half the step", material(8) | step(0.0005)
        yield twist, 0.5, "the same, Newmark", material(8) | solver(scheme_type="newmark")
        yield twist, 0.5, "the same, lumped mass", material(8) | solver(consistent_mass_matrix=False)
        yield twist, 0.5, "hexahedra, 27 points", material(27)
        yield twist, 0.5, "tetrahedra, 14 points", tetrahedra()
    elif group == "twist_reset":
        for points in (8, 27, 64):
            yield twist, 0.5, f"hexahedra, {points} points", material(points) | solver(**every)
        yield twist, 0.5, "hexahedra, 27 points, half the step", material(27) | solver(**every) | step(0.0005)
        yield twist, 0.5, "tetrahedra, 14 points", tetrahedra() | solver(**every)
    elif group == "displacement":
        for base in (bend, twist):
            yield base, 0.45, "u-p, nu = 0.45", material(8, 0.45) | solver(**never)
            yield base, 0.45, "u, nu = 0.45", displacement(8, **never)
            yield base, 0.5, "u, nu = 0.499", displacement(8, 0.499, **never)
            if base is bend:
                yield base, 0.45, "u, nu = 0.45, 27 points, reset", displacement(27, **every)


def table(group, arguments):
    """Runs a group and prints its lines as they come."""
    kind = None
    for (name, end), poisson, title, changes in cases(group):
        if name != kind:
            kind = name
            heads = ["run", *HEADS[kind], "iterations", "CPU [s]"]
            print(f"\n### {group}: {name}ing column\n\n| {' | '.join(heads)} |\n|{'---|' * len(heads)}", flush=True)
        changes = changes | {"/problem_data/end_time": end}
        run = Run(arguments.bia, arguments.threads, f"{name}ing_column", changes)
        lines = bend_line if kind == "bend" else twist_line
        line = lines(run, poisson) if len(run.tip[1]) > 2 else ["fails at once"] + ["-"] * (len(HEADS[kind]) - 1)
        print(f"| {' | '.join([title, *line, f'{run.iterations:.1f}', f'{run.cpu:.1f}'])} |", flush=True)
        if run.failure:
            print(f"{title}: {run.failure}", file=sys.stderr, flush=True)


GROUPS = ["bend", "bend_reset", "twist", "twist_reset", "displacement"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=", ".join(GROUPS))
    parser.add_argument("--bia", default=str(ROOT / "target/release/bia"))
    parser.add_argument("--threads", default=1, type=int)
    arguments = parser.parse_args()
    if unknown := set(arguments.groups) - set(GROUPS):
        parser.error(f"no group {', '.join(sorted(unknown))}; there are {', '.join(GROUPS)}")
    for group in arguments.groups or GROUPS:
        table(group, arguments)


if __name__ == "__main__":
    main()
