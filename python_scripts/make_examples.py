#!/usr/bin/env python3
"""Writes the projects of examples/cantilever, examples/falling_block and examples/cook.

They are plain Kratos projects, so that Bia and Kratos run the same files. Run it again after a
change of a number here; the files that it writes are kept in the repository. Standard library only.
"""

import argparse
import json
from dataclasses import dataclass, field
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


@dataclass
class Mesh:
    """Quadrilaterals, with lines as conditions and named sets of nodes; indices count from 0."""

    nodes: list
    cells: list
    lines: list = field(default_factory=list)
    parts: dict = field(default_factory=dict)


def lattice(columns, rows, place):
    """columns x rows cells; node (i, j) stands at place(i / columns, j / rows)."""
    nodes = [place(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
    corner = [j * (columns + 1) + i for j in range(rows) for i in range(columns)]
    return Mesh(nodes, [(k, k + 1, k + columns + 2, k + columns + 1) for k in corner])


def box(low, high, size):
    """A rectangle in squares of the given edge."""
    columns, rows = (round((b - a) / size) for a, b in zip(low, high))
    return lattice(columns, rows, lambda s, t: (low[0] + s * (high[0] - low[0]), low[1] + t * (high[1] - low[1])))


def nodes_where(mesh, holds):
    """Indices of the nodes whose coordinates satisfy a condition."""
    return [n for n, (x, y) in enumerate(mesh.nodes) if holds(x, y)]


def block(lines, name, rows):
    """One mdpa block."""
    lines += [f"Begin {name}", *rows, f"End {name.split()[0]}", ""]


def mdpa(mesh, element, first_node=1, first_element=1, condition=None):
    """The text of an mdpa file."""
    lines = []
    block(lines, "ModelPartData", [])
    block(lines, "Properties 0", [])
    block(lines, "Nodes", [f"{first_node + n} {x:.12g} {y:.12g} 0" for n, (x, y) in enumerate(mesh.nodes)])
    numbered = [" ".join(str(first_node + n) for n in cell) for cell in mesh.cells]
    block(lines, f"Elements {element}", [f"{first_element + e} 0 {cell}" for e, cell in enumerate(numbered)])
    if mesh.lines:
        numbered = [" ".join(str(first_node + n) for n in line) for line in mesh.lines]
        block(lines, f"Conditions {condition}", [f"{c + 1} 0 {line}" for c, line in enumerate(numbered)])
    for name, members in mesh.parts.items():
        lines.append(f"Begin SubModelPart {name}")
        for kind, first in (("nodes", first_node), ("elements", first_element), ("conditions", 1)):
            title = f"SubModelPart{kind.capitalize()}"
            lines += [f"Begin {title}", *(str(first + k) for k in members.get(kind, [])), f"End {title}"]
        lines += ["End SubModelPart", ""]
    return "\n".join(lines)


def material(law, **constants):
    """The materials file of one body."""
    return {
        "properties": [
            {
                "model_part_name": "Initial_MPM_Material.Body",
                "properties_id": 1,
                "Material": {
                    "constitutive_law": {"name": law},
                    "Variables": {"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": 4, **constants},
                    "Tables": {},
                },
            }
        ]
    }


def process(module, parameters, application="MPMApplication"):
    """One process of a project."""
    kratos_module = "KratosMultiphysics" + ("." + application if application else "")
    return {"python_module": module, "kratos_module": kratos_module, "Parameters": parameters}


def support(part, constrained=(True, True, True)):
    """Holds nodes of the grid."""
    parameters = {
        "model_part_name": f"Background_Grid.{part}",
        "variable_name": "DISPLACEMENT",
        "constrained": list(constrained),
        "value": [0.0 if held else None for held in constrained],
        "interval": [0.0, "End"],
    }
    return process("assign_vector_variable_process", parameters, "")


def gravity():
    """9.81 m/s² downwards."""
    parameters = {"model_part_name": "MPM_Material", "modulus": 9.81, "direction": [0.0, -1.0, 0.0]}
    return process("assign_gravity_to_material_point_process", parameters)


def outputs(interval, variables):
    """VTK files of the points and the grid, and a table of energies."""
    common = {"output_control_type": "step", "output_interval": interval, "file_format": "binary"}
    points = {"model_part_name": "MPM_Material", **common, "output_path": "vtk_points"}
    points["gauss_point_variables_in_elements"] = variables
    grid = {"model_part_name": "Background_Grid", **common, "output_path": "vtk_grid"}
    grid["nodal_solution_step_data_variables"] = ["DISPLACEMENT"]
    energy = {"model_part_name": "MPM_Material", "output_control_type": "step", "output_interval": 1}
    energy["print_format"] = ".12e"
    energy["output_file_settings"] = {"file_name": "energy.dat"}
    return {
        "energy": [process("mpm_write_energy_output_process", energy)],
        "vtk": [process("mpm_vtk_output_process", points), process("vtk_output_process", grid, "")],
    }


def project(name, end_time, time_step, solver, processes, output):
    """ProjectParameters.json."""
    return {
        "problem_data": {
            "problem_name": name,
            "parallel_type": "OpenMP",
            "echo_level": 0,
            "start_time": 0.0,
            "end_time": end_time,
        },
        "solver_settings": {
            **solver,
            "model_part_name": "MPM_Material",
            "domain_size": 2,
            "echo_level": 0,
            "analysis_type": "non_linear",
            "time_stepping": {"time_step": time_step},
            "convergence_criterion": "residual_criterion",
            "residual_relative_tolerance": 1e-8,
            "residual_absolute_tolerance": 1e-10,
            "max_iteration": 20,
            "pressure_dofs": False,
            "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
            "model_import_settings": {"input_type": "mdpa", "input_filename": "Body"},
            "grid_model_import_settings": {"input_type": "mdpa", "input_filename": "Grid"},
            "material_import_settings": {"materials_filename": "Materials.json"},
        },
        "processes": processes,
        "output_processes": output,
    }


def write(name, grid, body, parameters, materials, condition=None):
    """The four files of a project."""
    folder = EXAMPLES / name
    folder.mkdir(parents=True, exist_ok=True)
    body.parts["Body"] = {"nodes": range(len(body.nodes)), "elements": range(len(body.cells))}
    for file, content in (("ProjectParameters.json", parameters), ("Materials.json", materials)):
        (folder / file).write_text(json.dumps(content, indent=4) + "\n")
    (folder / "Grid.mdpa").write_text(mdpa(grid, "Element2D4N", condition=condition))
    first = (len(grid.nodes) + 1, len(grid.cells) + 1)
    (folder / "Body.mdpa").write_text(mdpa(body, "MPMUpdatedLagrangian2D4N", *first))


def cantilever():
    """A beam of 8 m by 1 m, clamped on the left, in one static step."""
    size = 0.125
    body = box((0.0, 0.0), (8.0, 1.0), size)
    grid = box((0.0, -0.25), (8.25, 1.0), size)
    grid.parts["Clamp"] = {"nodes": nodes_where(grid, lambda x, y: x == 0.0)}
    parameters = project(
        "cantilever",
        end_time=1.0,
        time_step=1.0,
        solver={"solver_type": "Static"},
        processes={"constraints": [support("Clamp")], "gravity": [gravity()]},
        output=outputs(1, ["MP_DISPLACEMENT", "MP_CAUCHY_STRESS_VECTOR"]),
    )
    law = material("LinearElasticIsotropicPlaneStress2DLaw", DENSITY=1000.0, YOUNG_MODULUS=1e9, POISSON_RATIO=0.3)
    write("cantilever", grid, body, parameters, law)


def falling_block():
    """A block of 0.2 m by 0.2 m falls 0.3 m."""
    size = 0.025
    body = box((0.2, 0.3), (0.4, 0.5), size)
    grid = box((0.0, 0.0), (0.6, 0.6), size)
    grid.parts["Floor"] = {"nodes": nodes_where(grid, lambda x, y: y == 0.0)}
    parameters = project(
        "falling_block",
        end_time=0.4995,
        time_step=0.001,
        solver={"solver_type": "Dynamic", "time_integration_method": "implicit", "scheme_type": "newmark"},
        processes={"constraints": [support("Floor", (False, True, False))], "gravity": [gravity()]},
        output=outputs(10, ["MP_DISPLACEMENT", "MP_VELOCITY", "MP_CAUCHY_STRESS_VECTOR"]),
    )
    constants = {"DENSITY": 1000.0, "YOUNG_MODULUS": 1e6, "POISSON_RATIO": 0.3}
    write("falling_block", grid, body, parameters, material("HyperElasticNeoHookeanPlaneStrain2DLaw", **constants))


def cook():
    """Cook's membrane, 48 m wide, clamped on the left, sheared by 0.0625 Pa on the right, in one static step."""
    cells = 32

    def place(s, t):
        low, high = 44.0 * s, 44.0 + 16.0 * s
        return (48.0 * s, low + t * (high - low))

    body, grid = lattice(cells, cells, place), lattice(cells, cells, place)
    right = nodes_where(grid, lambda x, y: x == 48.0)
    grid.lines = list(zip(right, right[1:]))
    grid.parts["Clamp"] = {"nodes": nodes_where(grid, lambda x, y: x == 0.0)}
    grid.parts["Load"] = {"nodes": right, "conditions": range(len(grid.lines))}
    load = {
        "model_part_name": "Background_Grid.Load",
        "variable_name": "LINE_LOAD",
        "modulus": 0.0625,
        "direction": [0.0, 1.0, 0.0],
        "interval": [0.0, "End"],
    }
    loads = [process("assign_vector_by_direction_to_condition_process", load, "")]
    parameters = project(
        "cook",
        end_time=1.0,
        time_step=1.0,
        solver={"solver_type": "Static"},
        processes={"constraints": [support("Clamp")], "loads": loads},
        output=outputs(1, ["MP_DISPLACEMENT", "MP_CAUCHY_STRESS_VECTOR"]),
    )
    law = material("HyperElasticNeoHookeanPlaneStrain2DLaw", DENSITY=1000.0, YOUNG_MODULUS=70.0, POISSON_RATIO=0.33)
    write("cook", grid, body, parameters, law, condition="MPMGridLineLoadCondition2D2N")


def main():
    """Command line."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    for make in (cantilever, falling_block, cook):
        make()


if __name__ == "__main__":
    main()
