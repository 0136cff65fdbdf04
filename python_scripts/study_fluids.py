#!/usr/bin/env python3
"""The study of Newtonian fluids with mixed elements: runs examples/dam_break, examples/sloshing_tank, a tank at
rest and channels in all variants, one after the other on one thread, and prints its tables as Markdown.

    study_fluids.py [dam_break] [rest] [channel] [sloshing] [--bia PROGRAM] [--into FILE.md]

Without a name all parts run. --into puts the tables into a text, each between the lines `<!-- table NAME -->` and
`<!-- end -->`. All numbers are from the tables that the runs' own measurements write; here they are only compared
with references. CPU times are of the loop over time steps. Needs numpy.

References: Martin & Moyce 1952 (tables 2 and 6, n² = 2, a = 2.25 in), linear theory of waves, series of the
channel flows.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
from study_cook import insert

ROOT = Path(__file__).resolve().parents[1]
GRAVITY = 9.81
SOLVER = "/solver_settings/"
VARIABLES = SOLVER + "material_import_settings/materials/0/Material/Variables/"
# Front z/a at t sqrt(2 g/a), and height of the column over 2 a at t sqrt(g/a).
FRONT = numpy.array([
    (0.41, 1.11), (0.84, 1.22), (1.19, 1.44), (1.43, 1.67), (1.63, 1.89), (1.83, 2.11), (1.98, 2.33), (2.20, 2.56),
    (2.32, 2.78), (2.51, 3.00), (2.65, 3.22), (2.83, 3.44), (2.98, 3.67), (3.11, 3.89), (3.33, 4.11),
])  # fmt: skip
HEIGHT = numpy.array([
    (0.56, 0.94), (0.77, 0.89), (0.93, 0.83), (1.08, 0.78), (1.28, 0.72), (1.46, 0.67), (1.66, 0.61), (1.84, 0.56),
    (2.00, 0.50), (2.21, 0.44), (2.45, 0.39), (2.70, 0.33),
])  # fmt: skip


class Run:
    """A run of the program and what it measured; `code` is its exit status."""

    def __init__(self, program, project, settings):
        with tempfile.TemporaryDirectory() as folder:
            if isinstance(project, dict):
                file = Path(folder) / "ProjectParameters.json"
                file.write_text(json.dumps(project), encoding="utf-8")
            else:
                file = ROOT / "examples" / project / "ProjectParameters.json"
                settings = {"/output_processes/vtk_output": []} | settings
            command = [program, "run", str(file), "--threads", "1", "--output", folder]
            for pointer, value in settings.items():
                command += ["--set", f"{pointer}={json.dumps(value)}"]
            ended = subprocess.run(command, capture_output=True, text=True)
            self.code = ended.returncode
            if self.code not in (0, 3):
                sys.exit(f"{' '.join(command)}\n{ended.stderr}")
            self.tables = {path.stem: read(path) for path in Path(folder).glob("*.csv")}
            energy = Path(folder) / "energy.dat"
            self.energy = numpy.loadtxt(energy) if energy.is_file() else None
            done = re.search(r"done: (\d+) steps? .*, (\d+) Newton", ended.stdout)
            cpu = re.search(r"time of the loop.* CPU (\S+) s", ended.stdout)
        self.steps, self.iterations = (int(number) for number in done.groups()) if done else (0, 0)
        self.cpu = float(cpu.group(1)) if cpu else numpy.nan


def read(path):
    """The rows of a table."""
    return numpy.genfromtxt(path, delimiter=",", skip_header=1, ndmin=2)


def rms(values):
    return float(numpy.sqrt(numpy.mean(numpy.square(values))))


def largest(values):
    return float(numpy.abs(values).max())


def process(module, **parameters):
    return {"python_module": module, "Parameters": parameters}


def held(part, components):
    """Motion of a part of the grid in each step; None leaves a component free."""
    constrained = [component is not None for component in components]
    parameters = {"model_part_name": f"Background_Grid.{part}", "variable_name": "DISPLACEMENT"}
    return process("assign_vector_variable_process", **parameters, constrained=constrained, value=components)


def scene(shape, points, grid, body, material, solver, processes, outputs, end_time):
    """A project of one fluid; `grid` and `body` are parameters of their modelers, `solver` beside the usual."""
    law = material.pop("law")
    fluid = {
        "model_part_name": "Initial_MPM_Material.Fluid",
        "properties_id": 1,
        "Material": {
            "constitutive_law": {"name": law},
            "Variables": {"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": points, **material},
        },
    }
    imported = {"input_type": "use_input_model_part"}
    kind = {"shape": shape} | ({"diagonal": "fixed"} if shape == "triangle" else {})
    bodies = [{"name": "Fluid", **kind, **body}]
    energy = process("mpm_write_energy_output_process", model_part_name="MPM_Material", print_format=".16e")
    return {
        "problem_data": {"problem_name": "scene", "start_time": 0.0, "end_time": end_time},
        "modelers": [
            {"name": "RegularGridModeler", "parameters": {**kind, **grid}},
            {"name": "BodyModeler", "parameters": {"bodies": bodies}},
        ],
        "solver_settings": {
            "solver_type": "dynamic",
            "domain_size": 2,
            "model_import_settings": imported,
            "grid_model_import_settings": imported,
            "material_import_settings": {"materials": [fluid]},
            **solver,
        },
        "processes": {"list": processes},
        "output_processes": {"list": [energy, *outputs]},
    }


def cells(shape, size=None, points=None):
    """Settings of the examples' cells."""
    settings = {}
    for modeler in ("/modelers/0/parameters/", "/modelers/1/parameters/bodies/0/"):
        settings[modeler + "shape"] = shape
        if size:
            settings[modeler + "cell_size"] = size
    settings[VARIABLES + "MATERIAL_POINTS_PER_ELEMENT"] = points or {"triangle": 6, "quadrilateral": 9}[shape]
    return settings


class Study:
    def __init__(self, program):
        self.program, self.tables = program, {}

    def run(self, project, settings=None):
        return Run(self.program, project, settings or {})

    def table(self, name, headings, rows):
        lines = ["| " + " | ".join(headings) + " |", "|" + "---|" * len(headings)]
        lines += ["| " + " | ".join(str(entry) for entry in row) + " |" for row in rows]
        self.tables[name] = "\n".join(lines)
        print(f"\n{name}\n\n{self.tables[name]}", flush=True)

    def dam_break(self):
        """All stabilisations, sizes and moduli on triangles; then one choice changed at a time."""
        rows = []
        for size in (0.2, 0.1):
            for stabilization in ("asgs", "osgs", "ppp"):
                for modulus in (None, 2.2e9):
                    title = ["T3, 6 points", size, stabilization, "2.2e9" if modulus else "∞", "1 ms"]
                    settings = {SOLVER + "stabilization": stabilization}
                    settings |= {VARIABLES + "BULK_MODULUS": modulus} if modulus else {}
                    rows.append(self.collapse(title, "triangle", size, settings))
        bulk, step, key = "∞", "1 ms", SOLVER + "time_stepping"
        parameters = SOLVER + "stabilization_parameters"
        both = "/modelers/0/parameters/diagonal", "/modelers/1/parameters/bodies/0/diagonal"
        others = [
            (["T3, 6 points", 0.1, "asgs", bulk, "0.5 ms"], "triangle", {key: {"time_step": 5e-4}}, None),
            (["T3, 6 points", 0.1, "asgs", bulk, "2 ms"], "triangle", {key: {"time_step": 2e-3}}, None),
            (["T3, 6 points", 0.05, "asgs", bulk, step], "triangle", {}, None),
            (["T3, 3 points", 0.1, "asgs", bulk, step], "triangle", {}, 3),
            (["T3, 12 points", 0.1, "asgs", bulk, step], "triangle", {}, 12),
            (["T3, alternating", 0.1, "asgs", bulk, step], "triangle", {name: "alternating" for name in both}, None),
            (["T3, 6 points", 0.1, "asgs, c2 = 0", bulk, step], "triangle", {parameters: {"c2": 0.0}}, None),
            (["Q4, 9 points", 0.1, "asgs, c2 = 0", bulk, step], "quadrilateral", {parameters: {"c2": 0.0}}, None),
        ]
        for size in (0.2, 0.1):
            for kind in ("asgs", "osgs", "ppp"):
                settings = {SOLVER + "stabilization": kind}
                others.append((["Q4, 9 points", size, kind, bulk, step], "quadrilateral", settings, None))
        for title, shape, settings, points in others:
            rows.append(self.collapse(title, shape, title[1], settings, points))
        headings = ["cells", "h [m]", "stabilisation", "κ [Pa]", "Δt", "front %", "shifted % (by)", "height", "largest"]
        headings += ["E(0.9 s)/E(0)", "largest", "overfill %", "iterations a step", "CPU s"]
        self.table("dam_break", headings, rows)

    def collapse(self, title, shape, size, settings, points=None):
        measures = "/output_processes/measurements/{}/Parameters/{}"
        settings = cells(shape, size, points) | settings
        settings[measures.format(1, "high")] = [size, None, None]
        settings[measures.format(2, "overfill_block")] = [2 * size, 2 * size, 0.0]
        run = self.run("dam_break", settings)
        if run.code:
            return [*title, *["fails"] * 9]
        time = run.tables["front"][:, 0] * numpy.sqrt(GRAVITY)

        def deviation(shift):
            found = numpy.interp(FRONT[:, 0] + shift, time * numpy.sqrt(2.0), run.tables["front"][:, 1])
            return 100.0 * rms(found / FRONT[:, 1] - 1.0)

        shift = min(numpy.linspace(-0.2, 0.2, 81), key=deviation)
        height = numpy.interp(HEIGHT[:, 0], time, run.tables["height"][:, 1] / 2.0) - HEIGHT[:, 1]
        energy = run.energy[:, 4] / run.energy[0, 4]
        row = [f"{deviation(0.0):.1f}", f"{deviation(shift):.1f} ({shift:+.2f})", f"{rms(height):.3f}"]
        row += [f"{largest(height):.3f}", f"{energy[-1]:.4f}", f"{energy.max():.6f}"]
        row += [f"{100.0 * run.tables['totals'][:, 2].max():.1f}", f"{run.iterations / run.steps:.2f}", f"{run.cpu:.1f}"]
        return [*title, *row]

    def rest(self):
        """1,000 steps of 1 ms in a tank 1 m wide, level or tilted by 30 degrees."""
        rows = []
        for shape, points in (("triangle", 6), ("quadrilateral", 9)):
            for stabilization in ("asgs", "osgs", "ppp"):
                for tilted in (False, True):
                    row = [f"{shape}, {points} points", stabilization, "tilted" if tilted else "level", "∞"]
                    rows.append(row + self.settle(shape, points, stabilization, tilted, None))
            row = [f"{shape}, {points} points", "asgs", "level", "2.2e9"]
            rows.append(row + self.settle(shape, points, "asgs", False, 2.2e9))
        headings = ["cells", "stabilisation", "tank", "κ [Pa]", "rms speed after 1 step", "10", "100", "1000 [m/s]"]
        headings += ["error of pressure after 10 steps", "1000 [ρ g H]", "CPU s"]
        self.table("rest", headings, rows)

    def settle(self, shape, points, stabilization, tilted, modulus):
        run = self.run(tank(shape, points, stabilization, tilted, modulus))
        if run.code:
            return ["fails"] * 7
        speed = numpy.sqrt(2.0 * run.energy[:, 2] / run.energy[0, 1] * GRAVITY * centre(tilted))
        errors = []
        for time in (0.01, 1.0):
            rows = run.tables["pressure"][numpy.abs(run.tables["pressure"][:, 0] - time) < 1e-6]
            errors.append(largest(rows[:, 4] + 1000.0 * GRAVITY * (SURFACE - rows[:, 2])) / (1000.0 * GRAVITY * SURFACE))
        shown = [f"{speed[step]:.0e}" for step in (1, 10, 100, 1000)] + [f"{error:.0e}" for error in errors]
        return [*shown, f"{run.cpu:.1f}"]

    def channel(self):
        """Couette and Poiseuille flow between plates, from rest to the steady state."""
        rows = []
        for flow in ("couette", "poiseuille", "film"):
            for form in ("displacement", "asgs", "osgs", "ppp"):
                for shape in ("triangle", "quadrilateral"):
                    early, steady = [], []
                    for count in (4, 8, 16):
                        run = self.run(channel(flow, form, shape, count))
                        table = run.tables["profile"]
                        for list_, time in ((early, 0.1), (steady, 1.5)):
                            at = table[numpy.abs(table[:, 0] - time) < 1e-6]
                            exact = profile(flow, at[:, 2], time)
                            list_.append(rms(at[:, 4] - exact) / rms(exact))
                    orders = [numpy.log2(errors[-2] / errors[-1]) for errors in (early, steady)]
                    row = [flow, form, shape, *(f"{100 * error:.2f}" for error in early), f"{orders[0]:.2f}"]
                    row += [*(f"{100 * error:.2f}" for error in steady), f"{orders[1]:.2f}", f"{run.cpu:.1f}"]
                    rows.append(row)
        headings = ["flow", "form", "cells", "t = 0.1: n = 4 %", "8 %", "16 %", "order", "t = 1.5: n = 4 %", "8 %", "16 %"]
        self.table("channel", [*headings, "order", "CPU s"], rows)

    def sloshing(self):
        """First frequency and damping of small and larger waves."""
        rows = []
        small, large = 0.001, 0.01
        never = {SOLVER + "grid_reset": "never"}
        corrected = {SOLVER + "stabilization_parameters": {"volume_correction": 0.1}, SOLVER + "flip_fraction": 0.99}
        for title, amplitude, shape, size, settings in [
            ("osgs", small, "triangle", 0.1, {}),
            ("osgs", small, "triangle", 0.05, {}),
            ("asgs", small, "triangle", 0.05, {SOLVER + "stabilization": "asgs"}),
            ("ppp", small, "triangle", 0.05, {SOLVER + "stabilization": "ppp"}),
            ("osgs", small, "quadrilateral", 0.05, {}),
            ("osgs", large, "triangle", 0.05, {}),
            ("osgs, volume_correction 0.1, flip_fraction 0.99", large, "triangle", 0.05, corrected),
            ("osgs, grid_reset never", small, "triangle", 0.05, never),
            ("osgs, grid_reset never", large, "triangle", 0.05, never),
            ("osgs, grid_reset never", large, "quadrilateral", 0.05, never),
        ]:
            wave = cells(shape, size) | settings
            speed = f"{amplitude / 0.001 * SLOSHING_SPEED:.8f}"
            start = [f"{speed}*sin(pi*x)*cosh(pi*y)", f"-{speed}*cos(pi*x)*sinh(pi*y)", 0.0]
            wave["/processes/start/0/Parameters/value"] = start
            wave["/output_processes/measurements/0/Parameters/overfill_block"] = [2 * size, 2 * size, 0.0]
            wave["/modelers/0/parameters/max"] = [1.0, 0.7, 0.0]
            run = self.run("sloshing_tank", wave)
            row = [shape, size, title, f"{1e3 * amplitude:.0f}"]
            if run.code:
                rows.append(row + ["fails"] * 6)
                continue
            totals = run.tables["totals"]
            frequency, damping, rest = damped(totals[:, 0], totals[:, 1] - 0.5, SLOSHING)
            row += [f"{100 * (frequency / SLOSHING - 1):+.2f}", f"{100 * damping / frequency:+.2f}", f"{100 * rest:.1f}"]
            sunk = 1e3 * (totals[0, 2] - totals[-1, 2])
            rows.append(row + [f"{sunk:.2f}", f"{100 * totals[:, -1].max():.1f}", f"{run.cpu:.1f}"])
        headings = ["cells", "h [m]", "method", "amplitude [mm]", "frequency %", "damping ratio %", "not of the fit %"]
        self.table("sloshing", [*headings, "centre sunk [mm]", "overfill %", "CPU s"], rows)


# First mode of a tank 1 m wide with water 0.5 m deep, and the start's speed for 1 mm: a ω/sinh(k H).
SLOSHING = numpy.sqrt(GRAVITY * numpy.pi * numpy.tanh(numpy.pi / 2.0))
SLOSHING_SPEED = 0.001 * SLOSHING / numpy.sinh(numpy.pi / 2.0)


def damped(time, signal, frequency):
    """Angular frequency, decay and what is left of a fit by c + exp(-γ t) (a cos ω t + b sin ω t)."""

    def fit(unknowns):
        decay = numpy.exp(-unknowns[1] * time)
        waves = [decay * numpy.cos(unknowns[0] * time), decay * numpy.sin(unknowns[0] * time)]
        functions = numpy.stack([numpy.ones_like(time), *waves], axis=1)
        factors = numpy.linalg.lstsq(functions, signal, rcond=None)[0]
        return functions @ factors - signal, numpy.hypot(factors[1], factors[2])

    unknowns = numpy.array([frequency, 0.0])
    for _ in range(50):
        rest, amplitude = fit(unknowns)
        slopes = numpy.stack([(fit(unknowns + d)[0] - rest) / 1e-6 for d in 1e-6 * numpy.eye(2)], axis=1)
        unknowns += numpy.linalg.lstsq(slopes, -rest, rcond=None)[0]
    rest, amplitude = fit(unknowns)
    return unknowns[0], unknowns[1], rms(rest) / amplitude


# Height of the water above the lowest corner, and half of it on average above the floor.
SURFACE = 0.9
TILT = numpy.pi / 6.0


def centre(tilted):
    """Height of the centre of mass of the water."""
    if not tilted:
        return 0.5 * SURFACE
    corners = numpy.array(water_corners(True))
    following = numpy.roll(corners, -1, axis=0)
    areas = corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1]
    return float(((corners[:, 1] + following[:, 1]) * areas).sum() / (3.0 * areas.sum()))


def water_corners(tilted):
    """Corners of the water: floor, right wall, surface, left wall."""
    if not tilted:
        return [[0.0, 0.0], [1.0, 0.0], [1.0, SURFACE], [0.0, SURFACE]]
    cosine, sine = numpy.cos(TILT), numpy.sin(TILT)
    right = (SURFACE - sine) / cosine
    left = SURFACE / cosine
    return [[0.0, 0.0], [cosine, sine], [cosine - sine * right, SURFACE], [-sine * left, SURFACE]]


def tank(shape, points, stabilization, tilted, modulus):
    """Water in a tank whose cells follow the water's surface."""
    corners = water_corners(tilted)
    count = [8, 6]
    walls = ("min_x", "max_x", "min_y")
    grid = {"min": [0.0, 0.0, 0.0], "max": [1.0, 1.5, 0.0], "divisions": [8, 9], "map": corners}
    grid["parts"] = [{"name": wall, "side": wall, "conditions": "LineCondition2D2N"} for wall in walls]
    body = {"primitive": {"type": "box", "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0]}, "divisions": count}
    body["map"] = corners
    material = {"law": "DispNewtonianFluidPlaneStrainUP2DLaw", "DENSITY": 1000.0, "DYNAMIC_VISCOSITY": 1e-3}
    material |= {"BULK_MODULUS": modulus} if modulus else {}
    solver = {"scheme_type": "newmark", "pressure_dofs": True, "stabilization": stabilization}
    solver |= {"time_stepping": {"time_step": 0.001}, "residual_relative_tolerance": 1e-9}
    floor = [sum(corner[axis] for corner in corners[:2]) / 2.0 for axis in (0, 1)]
    top = [sum(corner[axis] for corner in corners[2:]) / 2.0 for axis in (0, 1)]
    processes = [
        *(process("apply_mpm_slip_boundary_process", model_part_name=f"Background_Grid.{wall}") for wall in walls),
        process(
            "assign_gravity_to_material_point_process",
            model_part_name="MPM_Material", modulus=GRAVITY, direction=[0.0, -1.0, 0.0],
        ),
    ]  # fmt: skip
    line = process(
        "line_output_process",
        model_part_name="Background_Grid", start_point=[*floor, 0.0], end_point=[*top, 0.0], sampling_points=13,
        output_variables=["PRESSURE"], output_times=[0.01, 1.0], output_file_settings={"file_name": "pressure"},
    )  # fmt: skip
    return scene(shape, points, grid, body, material, solver, processes, [line], 0.9995)


# The channels are 1 m high, of a fluid of 1 kg/m³ and 1 Pa s, with speeds of 1 mm/s: displacements stay small.
SPEED = 1e-3


def profile(flow, y, time):
    """Speed in a channel that starts at rest: series of Couette and Poiseuille flow."""
    speed = numpy.zeros_like(y)
    for n in range(1, 200):
        if flow == "couette":
            speed += 2.0 / (n * numpy.pi) * (-1) ** n * numpy.exp(-((n * numpy.pi) ** 2) * time) * numpy.sin(n * numpy.pi * y)
        else:
            k = (2 * n - 1) * numpy.pi / (2.0 if flow == "film" else 1.0)
            height = 2.0 if flow == "film" else 1.0
            speed -= 4.0 / (height * k**3) * numpy.exp(-(k**2) * time) * numpy.sin(k * y)
    steady = {"couette": y, "poiseuille": 0.5 * y * (1.0 - y), "film": 0.5 * y * (2.0 - y)}[flow]
    force = {"couette": 1.0, "poiseuille": 8.0, "film": 2.0}[flow]
    return SPEED * force * (steady + speed)


def channel(flow, form, shape, count):
    """A piece of a channel; at its ends nothing pulls along it and nothing moves across it."""
    step = 0.0025
    length, size = 0.5, 1.0 / count
    box = {"type": "box", "min": [0.0, 0.0, 0.0], "max": [length, 1.0, 0.0]}
    grid = {"min": [0.0, 0.0, 0.0], "max": [length + size, 1.0, 0.0], "cell_size": size}
    inner = {"min": [0.0, 0.5 * size, 0.0], "max": [0.0, 1.0 - 0.5 * size, 0.0]}
    outer = {"min": [length, 0.5 * size, 0.0], "max": [length + size, 1.0 - 0.5 * size, 0.0]}
    parts = [("Bottom", {"side": "min_y"}), ("Top", {"side": "max_y"}), ("Inlet", {"box": inner}), ("Outlet", {"box": outer})]
    grid["parts"] = [{"name": name, **choice} for name, choice in parts]
    mixed = form != "displacement"
    material = {"law": "DispNewtonianFluidPlaneStrain" + ("UP2DLaw" if mixed else "2DLaw")}
    material |= {"DENSITY": 1.0, "DYNAMIC_VISCOSITY": 1.0} | ({} if mixed else {"BULK_MODULUS": 1000.0})
    solver = {"scheme_type": "bossak", "time_stepping": {"time_step": step}, "residual_relative_tolerance": 1e-8}
    solver |= {"residual_absolute_tolerance": 1e-16}
    solver |= {"pressure_dofs": True, "stabilization": form} if mixed else {}
    top = {"couette": [SPEED * step, 0.0, None], "poiseuille": [0.0, 0.0, None], "film": [None, 0.0, None]}[flow]
    processes = [held("Bottom", [0.0, 0.0, None]), held("Top", top)]
    processes += [held("Inlet", [None, 0.0, None]), held("Outlet", [None, 0.0, None])]
    force = {"couette": 0.0, "poiseuille": 8.0, "film": 2.0}[flow]
    pull = {"model_part_name": "MPM_Material", "modulus": SPEED * force, "direction": [1.0, 0.0, 0.0]}
    if force:
        processes.append(process("assign_gravity_to_material_point_process", **pull))
    line = process(
        "line_output_process",
        model_part_name="Background_Grid", start_point=[0.25, 0.0, 0.0], end_point=[0.25, 1.0, 0.0], sampling_points=33,
        output_variables=["VELOCITY"], output_times=[0.1, 1.5], output_file_settings={"file_name": "profile"},
    )  # fmt: skip
    points = 6 if shape == "triangle" else 4
    return scene(shape, points, grid, {"primitive": box, "cell_size": size}, material, solver, processes, [line], 1.5 - 0.5 * step)


def main():
    parts = ("dam_break", "rest", "channel", "sloshing")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*parts, []], default=[])
    parser.add_argument("--bia", default=str(ROOT / "target" / "release" / "bia"))
    parser.add_argument("--into", type=Path)
    arguments = parser.parse_args()
    study = Study(arguments.bia)
    for part in arguments.parts or parts:
        getattr(study, part)()
    if arguments.into:
        insert(arguments.into, study.tables)


if __name__ == "__main__":
    main()
