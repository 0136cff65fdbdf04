#!/usr/bin/env python3
"""Runs the plane scenes of the stability survey with Kratos and measures what the survey's criteria look at.

Writes KRATOS.json beside SURVEY.json: measured once, with Kratos's version and the date. `bia survey` judges the
numbers by the criteria of its own runs and shows them beside these ("beside" in SURVEY.json). The script makes the meshes (regular grids and boxes, as Bia's modelers do), gives the points
their initial velocities, and evaluates errors, ranges and totals on Kratos's own points. Errors that the
survey takes over the whole time are sampled a hundred times here. A scene that needs what Kratos does not
have says so in one line.

Kratos must be importable by the Python that runs this script:
    pip install KratosMultiphysics KratosMPMApplication KratosLinearSolversApplication
"""

import argparse
import copy
import datetime
import json
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Headings of Kratos's results by the method of the survey.
METHODS = {"implicit MPM": "implicit MPM", "MPM u-p ASGS": "MPM u-p PPP, triangles", "MPM USL": "MPM USL",
           "MPM MUSL": "MPM MUSL"}
FOREIGN = ["frame", "basis", "basis_order", "flip_fraction", "transfer", "volumetric_law", "point_placement",
           "point_velocity_rule", "held_motion", "grid_reset", "consistent_mass_matrix", "xpic_order",
           "stabilization_parameters"]
WITHOUT = {"frame": "a total-Lagrangian frame", "basis": "B-splines", "flip_fraction": "a share of PIC",
           "transfer": "APIC"}
SAMPLES = 100
MATH = {name: getattr(math, name) for name in ("sin", "cos", "pi", "sqrt", "exp", "cosh", "sinh")}


class Cannot(Exception):
    """Why Kratos cannot run a scene."""


def apply(project, changes):
    """The project with values replaced or added at JSON pointers, given as pairs."""
    for pointer, value in changes:
        *parents, last = pointer.split("/")[1:]
        place = project
        for key in parents:
            place = place[int(key) if isinstance(place, list) else key]
        if last == "-":
            place.append(value)
        else:
            place[int(last) if isinstance(place, list) else last] = value
    return project


def lattice(low, high, divisions):
    """Nodes and quadrilaterals of a box, x fastest."""
    (nx, ny) = divisions
    nodes = [(low[0] + (high[0] - low[0]) * i / nx, low[1] + (high[1] - low[1]) * j / ny)
             for j in range(ny + 1) for i in range(nx + 1)]
    at = lambda i, j: j * (nx + 1) + i
    return nodes, [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for j in range(ny) for i in range(nx)]


def mapped(nodes, corners):
    """The unit square mapped to four corners."""
    shape = lambda x, y: ((1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y)
    return [tuple(sum(n * c[a] for n, c in zip(shape(x, y), corners)) for a in (0, 1)) for x, y in nodes]


def chosen(part, low, high):
    """Whether a node belongs to a named part of a grid."""
    tolerance = 1e-9 * max(high[0] - low[0], high[1] - low[1])
    sides = part.get("side", [])
    sides = [sides] if isinstance(sides, str) else sides
    planes = {"min_x": (0, low[0]), "max_x": (0, high[0]), "min_y": (1, low[1]), "max_y": (1, high[1])}
    sides = list(planes) if "boundary" in sides else sides
    if sides:
        return lambda x: any(abs(x[planes[s][0]] - planes[s][1]) <= tolerance for s in sides)
    box = part["box"]
    return lambda x: all(box["min"][a] - tolerance <= x[a] <= box["max"][a] + tolerance for a in (0, 1))


def mdpa(nodes, cells, element, first, parts=(), conditions=()):
    """Text of a mesh; parts are (name, nodes, elements, conditions)."""
    lines = ["Begin Properties 0", "End Properties", "Begin Nodes"]
    lines += [f"{first + i + 1} {x:.17g} {y:.17g} 0" for i, (x, y) in enumerate(nodes)]
    lines += ["End Nodes", f"Begin Elements {element}"]
    lines += [f"{first + i + 1} 0 " + " ".join(str(first + n + 1) for n in cell) for i, cell in enumerate(cells)]
    lines += ["End Elements"]
    if conditions:
        lines.append("Begin Conditions MPMGridLineLoadCondition2D2N")
        lines += [f"{i + 1} 0 {a + 1} {b + 1}" for i, (a, b) in enumerate(conditions)]
        lines.append("End Conditions")
    for name, in_nodes, in_cells, in_conditions in parts:
        lines.append(f"Begin SubModelPart {name}")
        for kind, ids in (("Nodes", in_nodes), ("Elements", in_cells), ("Conditions", in_conditions)):
            lines += [f"Begin SubModelPart{kind}", *(str(first + i + 1 if kind != "Conditions" else i + 1) for i in ids),
                      f"End SubModelPart{kind}"]
        lines.append("End SubModelPart")
    return "\n".join(lines) + "\n"


def split(cells):
    """Two triangles of each quadrilateral: Kratos's mixed elements are triangles."""
    return [triangle for a, b, c, d in cells for triangle in ((a, b, c), (a, c, d))]


def grid_mesh(settings, triangles):
    """The background grid, and how many nodes and cells it has."""
    low, high, divisions = settings["min"], settings["max"], settings["divisions"]
    if len(divisions) != 2:
        raise Cannot("Kratos has no material points on lines")
    nodes, cells = lattice(low, high, divisions)
    parts, conditions = [("Parts_grid", range(len(nodes)), range(len(cells)), [])], []
    for part in settings.get("parts", []):
        holds = chosen(part, low, high)
        inside = [i for i, x in enumerate(nodes) if holds(x)]
        own = []
        if part.get("conditions"):
            edges = [(c[k], c[(k + 1) % 4]) for c in cells for k in range(4)]
            counts = {}
            for a, b in edges:
                counts[frozenset((a, b))] = counts.get(frozenset((a, b)), 0) + 1
            for a, b in edges:
                if counts[frozenset((a, b))] == 1 and holds(nodes[a]) and holds(nodes[b]):
                    own.append(len(conditions))
                    conditions.append((a, b))
        parts.append((part["name"], inside, [], own))
    if settings.get("map"):
        nodes = mapped(nodes, settings["map"])
    cells = split(cells) if triangles else cells
    parts[0] = ("Parts_grid", range(len(nodes)), range(len(cells)), [])
    element = "Element2D3N" if triangles else "Element2D4N"
    return mdpa(nodes, cells, element, 0, parts, conditions), max(len(nodes), len(cells))


def body_mesh(bodies, first, even, triangles):
    """All bodies; with `even` points each cell is cut in four, which hold one point each."""
    nodes, cells, parts = [], [], []
    for body in bodies:
        if body["primitive"]["type"] != "box":
            raise Cannot("this script makes boxes only")
        divisions = [n * (2 if even else 1) for n in body["divisions"]]
        low, high = body["primitive"]["min"], body["primitive"]["max"]
        own, own_cells = lattice(low, high, divisions)
        own_cells = split(own_cells) if triangles else own_cells
        if body.get("map"):
            own = mapped(own, body["map"])
        middle = [(low[a] + high[a]) / 2 for a in (0, 1)]
        angle = math.radians(body.get("rotation", 0.0))
        shift = body.get("translation", [0.0, 0.0])
        turn = lambda x, y: (math.cos(angle) * x - math.sin(angle) * y, math.sin(angle) * x + math.cos(angle) * y)
        if angle:
            own = [tuple(m + d for m, d in zip(middle, turn(x - middle[0], y - middle[1]))) for x, y in own]
        own = [(x + shift[0], y + shift[1]) for x, y in own]
        start = (len(nodes), len(cells))
        nodes += own
        cells += [tuple(n + start[0] for n in cell) for cell in own_cells]
        parts.append((body["name"], range(start[0], len(nodes)), range(start[1], len(cells)), []))
    return mdpa(nodes, cells, f"MPMUpdatedLagrangian2D{3 if triangles else 4}N", first, parts)


def for_kratos(project, folder):
    """Writes meshes, materials and project for Kratos; gives what the script does itself."""
    project = copy.deepcopy(project)
    solver = project["solver_settings"]
    for key in FOREIGN:
        value = solver.pop(key, None)
        if key in WITHOUT and value not in (None, "flip", 1.0):
            raise Cannot(f"Kratos has not {WITHOUT[key]}")
        if key == "point_placement" and value == "even":
            counts = [m["Material"]["Variables"]["MATERIAL_POINTS_PER_ELEMENT"]
                      for m in solver["material_import_settings"]["materials"]]
            solver["even"] = counts[0] > 1
    even = solver.pop("even", False)
    held = [p["Parameters"]["model_part_name"] for p in project["processes"].get("constraints", [])]
    if "Background_Grid.All" in held:
        raise Cannot("Kratos moves no grid of which all nodes are imposed: explicit it takes them as at rest, "
                     "implicit it has no dofs")
    modelers = {m["name"].rsplit(".", 1)[1]: m["parameters"] for m in project.pop("modelers")}
    triangles = solver.get("pressure_dofs", False)
    text, first = grid_mesh(modelers["RegularGridModeler"], triangles)
    (folder / "grid.mdpa").write_text(text)
    (folder / "body.mdpa").write_text(body_mesh(modelers["BodyModeler"]["bodies"], first, even, triangles))
    materials = solver["material_import_settings"].pop("materials")
    for entry in materials:
        variables = entry["Material"]["Variables"]
        entry["Material"]["Tables"] = {}
        if even:
            variables["MATERIAL_POINTS_PER_ELEMENT"] = variables["MATERIAL_POINTS_PER_ELEMENT"] // 4 or 1
        if triangles:
            variables["MATERIAL_POINTS_PER_ELEMENT"] = 1 if variables["MATERIAL_POINTS_PER_ELEMENT"] == 1 else 3
    (folder / "materials.json").write_text(json.dumps({"properties": materials}))
    solver["material_import_settings"] = {"materials_filename": "materials.json"}
    solver["model_import_settings"] = {"input_type": "mdpa", "input_filename": "body"}
    solver["grid_model_import_settings"] = {"input_type": "mdpa", "input_filename": "grid"}
    solver["echo_level"] = 0
    solver.setdefault("convergence_criterion", "residual_criterion")
    if solver.get("time_integration_method") == "explicit":
        solver["analysis_type"] = "linear"
    if solver.get("pressure_dofs"):
        solver["stabilization"] = "ppp"  # the only one that 10.4.4 has
    project["problem_data"]["echo_level"] = 0
    measurements = project.pop("output_processes", {}).get("measurements", [])
    start = []
    for group in list(project["processes"].values()):
        for process in list(group):
            name, own = process["python_module"], process["Parameters"]
            process["kratos_module"] = "KratosMultiphysics"
            if name == "assign_initial_field_to_material_point_process":
                start.append(own)
                group.remove(process)
            elif name == "assign_gravity_to_material_point_process":
                process["kratos_module"] += ".MPMApplication"
            elif name == "assign_body_acceleration_to_material_point_process":
                if not all(isinstance(x, (int, float)) for x in own["value"]):
                    raise Cannot("Kratos has no body forces that depend on the place")
                process["python_module"] = "assign_gravity_to_material_point_process"
                process["kratos_module"] += ".MPMApplication"
                size = math.hypot(*own["value"])
                own.update(modulus=size, direction=[x / size for x in own.pop("value")])
            elif name == "assign_vector_variable_to_conditions_process":
                size = math.hypot(*own["value"])
                direction = [x / size for x in own.pop("value")]
                process["python_module"] = "assign_vector_by_direction_to_condition_process"
                own.update(modulus=size, direction=direction)
    (folder / "ProjectParameters.json").write_text(json.dumps(project, indent=1))
    return {"start": start, "measurements": measurements}


def value_of(expression, x, initial, t):
    """A number or a formula in Python's syntax."""
    if isinstance(expression, (int, float)):
        return float(expression)
    names = dict(zip("xyz", x), **dict(zip("XYZ", initial)), t=t, min=min, max=max, **MATH)
    return float(eval(expression, {"__builtins__": {}}, names))  # formulas of the survey itself


COMPONENTS = {"X": 0, "Y": 1, "Z": 2, "XX": 0, "YY": 1, "XY": 2}


class Points:
    """Kratos's points as numbers."""

    def __init__(self, part, mpm):
        self.part, self.mpm, self.initial, self.volume = part, mpm, {}, {}
        for element, x, volume in zip(part.Elements, self.read("MP_COORD"), self.read("MP_VOLUME")):
            self.initial[element.Id] = x
            self.volume[element.Id] = volume[0]

    def read(self, name):
        """A list of numbers for each point."""
        rows = []
        for element in self.part.Elements:
            value = element.CalculateOnIntegrationPoints(getattr(self.mpm, name), self.part.ProcessInfo)[0]
            rows.append([value] if isinstance(value, float) else list(value))
        return rows

    def column(self, name):
        """A variable, or a component of one."""
        if name.startswith("MP_PK1_STRESS_TENSOR_YY"):
            name = "MP_CAUCHY_STRESS_VECTOR_YY"  # the same where F is 1 across
        stem, _, component = name.rpartition("_")
        if component in COMPONENTS and not hasattr(self.mpm, name) or component in ("X", "Y", "Z"):
            return [[row[COMPONENTS[component]]] for row in self.read(stem)]
        if not hasattr(self.mpm, name):
            raise KeyError(name)
        return self.read(name)


class Measures:
    """What the criteria of the survey ask for."""

    def __init__(self, list_of, points, grid):
        self.list, self.points, self.grid = list_of, points, grid
        self.summary = {"errors": {}, "values": {}}

    def table(self, process):
        """Name of a measurement's table."""
        own = process["Parameters"]
        default = {"range_output_process": "ranges", "mpm_totals_output_process": "totals",
                   "mpm_write_energy_output_process": "energy", "point_output_process": "point",
                   "resultant_output_process": "resultant"}[process["python_module"]]
        return own.get("output_file_settings", {}).get("file_name", default).split(".")[0]

    def note(self, table, column, value):
        """Takes a number into account."""
        found = self.summary["values"].setdefault(table, {}).setdefault(
            column, {"first": value, "smallest": value, "largest": value})
        found.update(last=value, smallest=min(found["smallest"], value), largest=max(found["largest"], value))

    def sample(self, t, is_end):
        """Measures at a time."""
        for process in self.list:
            own, module = process["Parameters"], process["python_module"]
            begin = own.get("interval", [0.0])[0]
            if t < begin or (own.get("output_times") and not is_end):
                continue
            try:
                self.measure(process, own, module, t)
            except (KeyError, AttributeError, IndexError):
                pass  # what Kratos does not show has no number, and its criterion says so

    def measure(self, process, own, module, t):
        """One measurement."""
        if module == "error_process":
            self.error(own, t)
        elif module == "range_output_process":
            for name in own["output_variables"]:
                values = [row[0] for row in self.points.column(name)]
                self.note(self.table(process), name + "_SMALLEST", min(values))
                self.note(self.table(process), name + "_LARGEST", max(values))
        elif module == "mpm_totals_output_process":
            mass = [row[0] for row in self.points.read("MP_MASS")]
            self.note(self.table(process), "MASS", sum(mass))
            x, v = self.points.read("MP_COORD"), self.points.read("MP_VELOCITY")
            self.note(self.table(process), "LINEAR_MOMENTUM_X", sum(m * a[0] for m, a in zip(mass, v)))
            turn = sum(m * (p[0] * a[1] - p[1] * a[0]) for m, p, a in zip(mass, x, v))
            self.note(self.table(process), "ANGULAR_MOMENTUM_Z", turn)
        elif module == "mpm_write_energy_output_process":
            kinetic = sum(row[0] for row in self.points.read("MP_KINETIC_ENERGY"))
            total = kinetic + sum(row[0] for row in self.points.read("MP_STRAIN_ENERGY"))
            self.note(self.table(process), "KINETIC", kinetic)
            self.note(self.table(process), "TOTAL", total)
        else:
            self.nodes(process, own, module)

    def nodes(self, process, own, module):
        """Values of nodes."""
        import KratosMultiphysics as kratos

        for name in own["output_variables"]:
            names = [name + "_X", name + "_Y"] if name == "DISPLACEMENT" else [name]
            for one in names:
                variable = kratos.KratosGlobals.GetVariable(one)
                if module == "point_output_process":
                    place = own["position"]
                    near = min(self.grid.Nodes, key=lambda n: math.hypot(n.X0 - place[0], n.Y0 - place[1]))
                    value = near.GetSolutionStepValue(variable)
                else:
                    part = self.grid.GetSubModelPart(own["model_part_name"].split(".", 1)[1])
                    value = sum(node.GetSolutionStepValue(variable) for node in part.Nodes)
                self.note(self.table(process), one, value)

    def error(self, own, t):
        """An error against a formula."""
        rows, places = self.points.column(own["variable"]), self.points.read("MP_COORD")
        ids = [element.Id for element in self.points.part.Elements]
        picked = list(range(len(ids)))
        if isinstance(own["on"], dict):
            picked = [min(picked, key=lambda i: math.dist(self.points.initial[ids[i]], x)) for x in own["on"]["positions"]]
        formulas = own["reference"]["value"]
        formulas = formulas if isinstance(formulas, list) else [formulas]
        sizes = [[], []]
        for i in picked:
            exact = [value_of(f, places[i], self.points.initial[ids[i]], t) for f in formulas]
            sizes[0].append(math.dist(rows[i][:len(exact)], exact))
            sizes[1].append(math.hypot(*exact))
        weights = [self.points.volume[ids[i]] for i in picked]
        norm = {"max": max, "rms": lambda s: math.sqrt(sum(w * x * x for w, x in zip(weights, s)) / sum(weights)),
                "L2": lambda s: math.sqrt(sum(w * x * x for w, x in zip(weights, s))),
                "L1": lambda s: sum(w * x for w, x in zip(weights, s))}[own["norm"]]
        error, size = norm(sizes[0]), norm(sizes[1])
        found = self.summary["errors"].setdefault(own["label"], {"largest": error})
        found["largest"] = max(found["largest"], error)
        found["at_end"] = error
        if size > 0:
            found["relative_at_end"] = error / size
            found["relative_largest"] = max(found.get("relative_largest", 0.0), error / size)


def worker(folder):
    """Runs the project in a folder; writes summary.json."""
    import KratosMultiphysics as kratos
    import KratosMultiphysics.MPMApplication as mpm
    from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis

    own = json.loads((folder / "own.json").read_text())
    parameters = kratos.Parameters((folder / "ProjectParameters.json").read_text())
    model = kratos.Model()
    analysis = MpmAnalysis(model, parameters)
    analysis.Initialize()
    part, grid = model["MPM_Material"], model["Background_Grid"]
    points = Points(part, mpm)
    for start in own["start"]:
        name = start["model_part_name"].split(".")[-1]
        elements = part.Elements if name == "MPM_Material" else part.GetSubModelPart(name).Elements
        for element in elements:
            x = points.initial[element.Id]
            v = kratos.Array3([value_of(f, x, x, 0.0) for f in start["value"]])
            element.SetValuesOnIntegrationPoints(mpm.MP_VELOCITY, [v], part.ProcessInfo)
    measures = Measures(own["measurements"], points, grid)
    solver, begin, steps, missed, most = analysis._GetSolver(), time.process_time(), 0, 0, 0
    solve = solver.SolveSolutionStep
    state = {"converged": True}

    def solve_step():
        state["converged"] = solve()
        return state["converged"]

    solver.SolveSolutionStep = solve_step
    end = parameters["problem_data"]["end_time"].GetDouble()
    measures.sample(0.0, False)
    due, reason, status = end / SAMPLES, "", "done"
    try:
        while analysis.KeepAdvancingSolutionLoop():
            analysis.time = solver.AdvanceInTime(analysis.time)
            analysis.InitializeSolutionStep()
            solver.Predict()
            solver.SolveSolutionStep()
            analysis.FinalizeSolutionStep()
            steps += 1
            missed += 0 if state["converged"] or state["converged"] is None else 1
            most = max(most, part.ProcessInfo[kratos.NL_ITERATION_NUMBER])
            if part.NumberOfElements() == 0:
                status, reason = "done", "ran on without any material point"
                break
            is_end = not analysis.KeepAdvancingSolutionLoop()
            if is_end or analysis.time >= due:
                measures.sample(analysis.time, is_end)
                due = analysis.time + end / SAMPLES
    except Exception as error:  # whatever ends Kratos is its outcome
        lines = [line for line in str(error).splitlines() if line.strip()]
        told = [line.split("caught exception:")[1] for line in lines if "caught exception:" in line]
        status, reason = "failed", (told or lines or ["nothing said"])[0].strip()[:200]
    coordinates = [x for row in points.read("MP_COORD") for x in row]
    if status == "done" and not all(math.isfinite(x) for x in coordinates):
        reason = "silently not finite"
    summary = {**measures.summary, "status": status, "reason": reason, "steps": steps,
               "cpu_s": time.process_time() - begin, "steps_not_converged": missed, "iterations": {"largest": most},
               "time_step": {"smallest": part.ProcessInfo[kratos.DELTA_TIME]},
               "version": kratos.KratosGlobals.Kernel.Version().replace('"', "").split("-")[0]}
    (folder / "summary.json").write_text(json.dumps(summary))


def pointed(summary, pointer):
    """The value at a JSON pointer, or the number itself."""
    if isinstance(pointer, (int, float)):
        return pointer
    value = summary
    for key in pointer.split("/")[1:]:
        value = value.get(key) if isinstance(value, dict) else None
    return value


def reduced(criterion, summary):
    """(quantity - minus)/over of a criterion, in a list; null where it is not finite, nothing where it was not measured."""
    value = pointed(summary, criterion["quantity"])
    for key, combine in (("minus", lambda a, b: a - b), ("over", lambda a, b: a / b)):
        if key in criterion and value is not None:
            other = pointed(summary, criterion[key])
            value = None if other is None else combine(value, other)
    if value is None:
        return []
    return [value if math.isfinite(value) else None]


def cell(project, criteria, arguments):
    """One scene with one method."""
    with tempfile.TemporaryDirectory(prefix="survey_kratos_") as scratch:
        folder = Path(scratch)
        stepping = project["solver_settings"]["time_stepping"]
        if stepping["time_step"] == "auto":
            (folder / "bia.json").write_text(json.dumps(project))
            command = [arguments.bia, "run", "bia.json", "--quiet", "--summary", "of_bia.json"]
            subprocess.run(command, cwd=folder, capture_output=True, timeout=arguments.limit, check=False)
            of_bia = json.loads((folder / "of_bia.json").read_text())
            if "time_step" not in of_bia:
                raise Cannot("the time step is automatic, and Bia gave none")
            stepping.clear()
            stepping["time_step"] = of_bia["time_step"]["smallest"]
        stepping.pop("courant_number", None)
        stepping.pop("time_step_policy", None)
        (folder / "own.json").write_text(json.dumps(for_kratos(project, folder)))
        command = [sys.executable, str(Path(__file__).resolve()), "--worker", str(folder)]
        try:
            environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
            seconds = int(arguments.limit)
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=20 * seconds,
                                  check=False, env=environment,
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds)))
        except subprocess.TimeoutExpired:
            return {"end": "timed_out", "reason": f"not done after {20 * seconds} s"}
        if -done.returncode in (signal.SIGXCPU, signal.SIGKILL):
            return {"end": "timed_out", "reason": f"not done after {seconds} s of CPU time"}
        if not (folder / "summary.json").exists():
            lines = [line for line in (done.stderr + done.stdout).splitlines() if line.strip()]
            lines = [line for line in lines if "Deregistering" not in line and not line.startswith("  ")]
            errors = [line for line in lines if "Error" in line or "Exception" in line] or lines[-1:] or ["nothing said"]
            refused = any(word in errors[-1] for word in ("invalid value", "components missing"))
            told = errors[-1].split("Error: ")[-1].strip()[:200]
            return {"end": "input" if refused else "failed", "reason": f"exit code {done.returncode}: {told}"}
        summary = json.loads((folder / "summary.json").read_text())
    end = "failed" if summary["reason"] == "silently not finite" else summary["status"]
    told = {"end": end, **({"reason": summary["reason"]} if summary["reason"] else {}),
            "steps": summary["steps"], "cpu_s": round(summary["cpu_s"], 3), "version": summary["version"]}
    bounds = [criterion for criterion in criteria if "quantity" in criterion] if end == "done" else []
    found = {criterion.get("text") or criterion["quantity"]: value for criterion in bounds for value in reduced(criterion, summary)}
    return {**told, "found": found} if found else told


def main():
    """Command line."""
    if sys.argv[1:2] == ["--worker"]:
        worker(Path(sys.argv[2]))
        return 0
    own = Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help="beginnings of ids of scenes; all without any")
    parser.add_argument("--survey", type=Path, default=own / "tests" / "survey" / "SURVEY.json")
    parser.add_argument("--bia", default=str(own / "target" / "release" / "bia"), help="for automatic time steps")
    parser.add_argument("--limit", type=float, default=60.0, help="CPU seconds a run may take")
    arguments = parser.parse_args()
    command = [arguments.bia, "survey", str(arguments.survey), "--dry-run", "--json"]
    plan = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    out = arguments.survey.with_name("KRATOS.json")
    results = json.loads(out.read_text()) if out.exists() else {}
    results.update(program="Kratos", version=results.get("version", ""), date=datetime.date.today().isoformat(),
                   text="by python_scripts/survey_kratos.py, on one thread; errors over the whole time were sampled a "
                        "hundred times. Its mixed element has pressure projections and triangles only.",
                   methods=METHODS)
    cells = results.setdefault("scenes", {})
    for run in plan:
        scene, method = run["scene"], run["method"]
        if method not in METHODS or arguments.scenes and not scene.startswith(tuple(arguments.scenes)):
            continue
        project = apply(json.loads(Path(run["project"]).read_text()), run["set"])
        try:
            found = cell(project, run["criteria"], arguments)
        except Cannot as reason:
            found = {"end": "cannot", "reason": str(reason)}
        if "version" in found:
            results["version"] = found.pop("version")
        cells.setdefault(scene, {})[method] = found
        print(f"{scene:34}{method:16}{found['end']:14}{found.get('reason', '')}", flush=True)
        out.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
