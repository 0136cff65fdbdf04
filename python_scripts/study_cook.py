#!/usr/bin/env python3
"""The study of Cook's membrane with mixed elements: runs examples/cook_incompressible in all variants, one
after the other on one thread, and prints its tables as Markdown.

    study_cook.py [static] [law] [steps] [dynamic] [--bia PROGRAM] [--csv FOLDER] [--into FILE.md]
                  [--finest N]

Without a name all parts run. --csv keeps each table as comma-separated values; --into puts the tables into a
text, each between the lines `<!-- table NAME -->` and `<!-- end -->`. --finest leaves out finer meshes, of 128
cells a side at most. All numbers are from the tables that the runs' own measurements write; here they are only
compared with references. CPU times are of the loop over time steps.

References: finite elements of order 5 and 4 (Taylor-Hood) on meshes graded to the corners; the pressure along
x = 2.4 m and the history of the corner beside the example.
"""

import argparse
import csv
import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "examples" / "cook_incompressible"
LARGE, SMALL = 6.25e6, 0.0625 * 240.565e6 / 70.0
# Rise of the corner (4.8, 6.0) m at Poisson's ratio 1/2, to 5e-5 and 1e-5 m.
LIMITS = {LARGE: 0.69340, SMALL: 0.027612}
# The same at the large load, a shear modulus of 80.1938 MPa and U = kappa (J - 1 - ln J), by Poisson's ratio; those
# of 0.3 and 0.49 are interpolated (0.33, 0.4, 0.45, 0.499 and 0.5 are computed) to 1e-5.
SHEAR_MODULUS = 80.1938e6
RISES = {0.3: 0.87753, 0.33: 0.85261, 0.49: 0.70372, 0.4999: 0.69345, 0.499999: 0.69335, 0.5: 0.69335}
# First peak of the rise when the large load is put on at once, at 45.5 ms.
FIRST_PEAK = 1.2203
STABILIZATIONS = ("none", "ppp", "asgs", "osgs")
# Shape of the cells and material points in each.
CELLS = {"Q4, 16 points": ("quadrilateral", 16), "T3, 12 points": ("triangle", 12), "T3, 3 points": ("triangle", 3)}
SOLVER = "/solver_settings/"
VARIABLES = SOLVER + "material_import_settings/materials/0/Material/Variables/"
LOAD = "/processes/loads_process_list/0/Parameters/modulus"


class Run:
    """A run of the program and what it measured."""

    def __init__(self, program, project, settings):
        with tempfile.TemporaryDirectory() as folder:
            command = [program, "run", str(EXAMPLE / project), "--threads", "1", "--output", folder]
            for pointer, value in settings.items():
                command += ["--set", f"{pointer}={json.dumps(value)}"]
            ended = subprocess.run(command, capture_output=True, text=True)
            self.code = ended.returncode
            if self.code not in (0, 3):
                sys.exit(f"{' '.join(command)}\n{ended.stderr}")
            self.fault = ended.stderr.strip()
            self.converged = "did not converge" not in self.fault
            self.tables = {path.stem: read(path) for path in Path(folder).glob("*.csv")}
            done = re.search(r"done: (\d+) steps? .*, (\d+) Newton", ended.stdout)
            cpu = re.search(r"time of the loop.* CPU (\S+) s", ended.stdout)
        self.steps, self.iterations = (int(number) for number in done.groups()) if done else (0, 0)
        self.cpu = float(cpu.group(1)) if cpu else math.nan

    def tip(self):
        """Rise of the corner at the end, in m."""
        return self.tables["tip"]["DISPLACEMENT_Y [m]"][-1]

    def checkerboard(self):
        return self.tables["checkerboard"]["OSCILLATION_OF_PRESSURE [1]"][-1]

    def pressure_error(self, load):
        """Root mean square of the error along x = 2.4 m over that of the pressure."""
        reference = read(EXAMPLE / "reference_pressure.csv")
        exact = reference[f"PRESSURE at {'6.25 MN/m' if load == LARGE else '214790 N/m'} [Pa]"]
        found = self.tables["pressure"]["PRESSURE [Pa]"][-len(exact) :]
        return math.sqrt(sum((p - q) ** 2 for p, q in zip(found, exact)) / sum(q * q for q in exact))


def read(path):
    """The columns of a table by their headings."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return {name: [float(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])}


def mesh(count, shape="quadrilateral", points=16):
    """Settings of a mesh of so many cells a side; the dynamic project's grid has a margin."""
    modelers = "/modelers/{}/parameters/{}"
    settings = {VARIABLES + "MATERIAL_POINTS_PER_ELEMENT": points}
    for modeler in ("0/parameters/", "1/parameters/bodies/0/"):
        settings[f"/modelers/{modeler}shape"] = shape
    settings[modelers.format(0, "divisions")] = [count, count]
    settings[modelers.format(1, "bodies/0/divisions")] = [count, count]
    return settings


def roomy(count, shape="quadrilateral", points=16):
    """The same with room for the membrane to move."""
    return mesh(count, shape, points) | {"/modelers/0/parameters/divisions": [count * 5 // 4, count * 5 // 2]}


def element(stabilization, variant="consistent"):
    """Settings of a stabilisation. Without any, incompressible cells leave some pressures undetermined."""
    settings = {SOLVER + "stabilization": stabilization, SOLVER + "stabilization_variant": variant}
    if stabilization == "none":
        settings[VARIABLES + "POISSON_RATIO"] = 0.499999
    return settings


def percent(value):
    return f"{100.0 * value:.2f}"


def order(errors, counts):
    """Order of convergence from the first mesh to the last; none where the error changes its sign or is tiny."""
    if len(errors) < 2 or not all(error * errors[0] > 0.0 for error in errors):
        return "–"
    return f"{math.log(errors[0] / errors[-1]) / math.log(counts[-1] / counts[0]):.2f}"


class Study:
    """Runs, tables and where they go."""

    def __init__(self, arguments):
        self.program, self.csv, self.finest = arguments.bia, arguments.csv, arguments.finest
        self.tables = {}

    def run(self, settings, project="ProjectParameters.json"):
        return Run(self.program, project, settings)

    def counts(self, *counts):
        return [count for count in counts if count <= self.finest]

    def table(self, name, headings, rows):
        lines = ["| " + " | ".join(headings) + " |", "|" + "---|" * len(headings)]
        lines += ["| " + " | ".join(str(entry) for entry in row) + " |" for row in rows]
        self.tables[name] = "\n".join(lines)
        print(f"\n{name}\n\n{self.tables[name]}", flush=True)
        if self.csv:
            self.csv.mkdir(parents=True, exist_ok=True)
            with open(self.csv / f"{name}.csv", "w", encoding="utf-8", newline="") as file:
                csv.writer(file).writerows([headings, *rows])

    def ladder(self, name, load, cells, kinds):
        """Error of the tip over the meshes, and of the pressure and the CPU time on the fourth and finest."""
        counts = self.counts(8, 16, 32, 64, 128)
        rows = []
        for cell in cells:
            for stabilization, variant in kinds:
                settings = {LOAD: load} | element(stabilization, variant)
                runs = [self.run(mesh(count, *CELLS[cell]) | settings) for count in counts]
                errors = [run.tip() / LIMITS[load] - 1.0 if run.code == 0 else math.nan for run in runs]
                fourth = runs[min(3, len(runs) - 1)]
                shown = [percent(error) if error == error else "fails" for error in errors]
                last = [order(errors, counts)]
                if fourth.code == 0:
                    last += [f"{fourth.checkerboard():.4f}", f"{fourth.pressure_error(load):.3f}"]
                else:
                    last += ["–", "–"]
                iterations = [str(run.iterations) if run.code == 0 else "–" for run in runs]
                title = stabilization + (" (Kratos)" if variant == "kratos" else "")
                row = [cell, title, *shown, *last, " ".join(iterations)]
                rows.append(row + [" ".join(f"{run.cpu:.2f}" for run in runs)])
        headings = ["cells", "stabilisation", *(f"n = {count}: tip %" for count in counts), "order"]
        headings += ["checkerboard, n = 64", "pressure error, n = 64", "iterations", "CPU s"]
        self.table(name, headings, rows)

    def static(self):
        both = [(kind, "consistent") for kind in STABILIZATIONS]
        self.ladder("static", SMALL, CELLS, both)
        self.ladder("kratos", SMALL, ["Q4, 16 points", "T3, 3 points"], [("ppp", "kratos"), ("asgs", "kratos")])
        self.ladder("large", LARGE, ["Q4, 16 points", "T3, 12 points"], both)

    def law(self):
        """Poisson's ratio at one shear modulus: neither iterations nor errors nor time grow."""
        rows = []
        counts = self.counts(32, 64)
        for stabilization in STABILIZATIONS[1:]:
            for poisson, limit in RISES.items():
                settings = element(stabilization) | {SOLVER + "volumetric_law": "miehe", LOAD: LARGE}
                settings |= {VARIABLES + "POISSON_RATIO": poisson}
                settings |= {VARIABLES + "YOUNG_MODULUS": 2.0 * SHEAR_MODULUS * (1.0 + poisson)}
                runs = [self.run(mesh(count) | settings) for count in counts]
                row = [stabilization, poisson, " ".join(str(run.iterations) for run in runs)]
                row += [percent(run.tip() / limit - 1.0) for run in runs]
                row += [f"{runs[-1].checkerboard():.4f}", " ".join(f"{run.cpu:.2f}" for run in runs)]
                rows.append(row)
        headings = ["stabilisation", "ν", "iterations", *(f"n = {count}: tip %" for count in counts)]
        self.table("law", headings + ["checkerboard", "CPU s"], rows)

    def steps(self):
        """What the reset of the grid costs: load steps against one step."""
        rows = []
        numbers = (1, 2, 5, 10, 20)
        for cell in ("Q4, 16 points", "T3, 12 points"):
            for reset in ("every_step", "never"):
                for count in self.counts(8, 16, 32):
                    row = [cell, reset, count]
                    for number in numbers:
                        settings = roomy(count, *CELLS[cell]) | element("asgs")
                        settings |= {SOLVER + "solver_type": "static", SOLVER + "grid_reset": reset, LOAD: f"{LARGE}*t"}
                        settings |= {SOLVER + "time_stepping": {"time_step": 1.0 / number}}
                        settings |= {"/problem_data/end_time": 1.0 - 0.5 / number, VARIABLES + "POISSON_RATIO": 0.5}
                        run = self.run(settings, "ProjectParameters_dynamic.json")
                        shown = "fails" if run.code else percent(tip_rise(run)[-1] / LIMITS[LARGE] - 1.0)
                        row.append(shown if run.converged else "no equilibrium")
                    rows.append(row)
        headings = ["cells", "grid reset", "n", *(f"{number} steps: tip %" for number in numbers)]
        self.table("steps", headings, rows)

    def dynamic(self):
        """First peak, with and without the reset."""
        rows, failures = [], []
        for cell in ("Q4, 16 points", "T3, 12 points"):
            for reset in ("every_step", "never"):
                for stabilization in STABILIZATIONS:
                    finest = (64,) if reset == "never" and cell.startswith("T3") else ()
                    for count in self.counts(16, 32, *finest):
                        settings = roomy(count, *CELLS[cell]) | element(stabilization)
                        settings |= {SOLVER + "grid_reset": reset, VARIABLES + "POISSON_RATIO": 0.4999}
                        run = self.run(settings, "ProjectParameters_dynamic.json")
                        row = [cell, reset, stabilization, count]
                        if run.code:
                            failures.append([*row, first_lines(run.fault)])
                            rows.append(row + ["fails"] + ["–"] * 4)
                            continue
                        height, time = peak(run)
                        shown = [f"{height:.4f}", percent(height / FIRST_PEAK - 1.0), f"{1e3 * time:.1f}"]
                        rows.append(row + shown + [f"{run.iterations / run.steps:.1f}", f"{run.cpu:.1f}"])
        headings = ["cells", "grid reset", "stabilisation", "n"]
        more = ["first peak [m]", "error %", "time [ms]", "iterations a step", "CPU s"]
        self.table("dynamic", headings + more, rows)
        self.table("failures", headings + ["the run says"], failures)


def tip_rise(run):
    return run.tables["tip"]["MPC_DISPLACEMENT_Y [m]"]


def peak(run):
    """The first maximum of the corner's rise by the parabola through its highest value, and its time."""
    times, rises = run.tables["tip"]["TIME [s]"], tip_rise(run)
    inside = [i for i, time in enumerate(times) if time < 0.07]
    top = min(max(max(inside, key=lambda i: rises[i]), 1), len(times) - 2)
    before, at, after = rises[top - 1 : top + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * at + after)
    return at - 0.25 * (before - after) * shift, times[top] + shift * (times[top + 1] - times[top])


def first_lines(fault):
    """What the program says failed, and where."""
    lines = fault.splitlines()
    start = next((i for i, line in enumerate(lines) if line.startswith("error")), len(lines) - 1)
    return " — ".join(line.strip() for line in lines[start : start + 2])


def insert(path, tables):
    """Puts the tables between their marks."""
    text = path.read_text(encoding="utf-8")
    for name, table in tables.items():
        pattern = re.compile(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        text, found = pattern.subn(lambda marks: f"{marks[1]}\n{table}\n\n{marks[2]}", text)
        if not found:
            print(f"{path} has no place for the table {name}", file=sys.stderr)
    path.write_text(text, encoding="utf-8")


def main():
    parts = ("static", "law", "steps", "dynamic")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*parts, []], default=[])
    parser.add_argument("--bia", default=str(ROOT / "target" / "release" / "bia"))
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--into", type=Path)
    parser.add_argument("--finest", type=int, default=128)
    arguments = parser.parse_args()
    study = Study(arguments)
    for part in arguments.parts or parts:
        getattr(study, part)()
    if arguments.into:
        insert(arguments.into, study.tables)


if __name__ == "__main__":
    main()
