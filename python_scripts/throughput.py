#!/usr/bin/env python3
"""Material-point steps per CPU second of explicit runs: an elastic cube, 8 points a cell, one thread.

    python throughput.py --bia ../target/release/bia 14 20 40
    python throughput.py --bia ../target/release/bia 40 --set '{"basis": "b_spline"}' --yardstick ./ref_simd

The numbers are cells along an edge: 14 fits the second-level cache, 40 (512,000 points) the memory alone.
`--set` adds to solver_settings. `--yardstick` runs a bare kernel loop beside it (program with the
arguments N STEPS MODE THREADS that prints "MPS_cpu 12.3M") and prints the ratio.
"""
import argparse
import json
import re
import subprocess
import tempfile
from pathlib import Path


def project(cells, steps, members):
    h, margin = 1.0 / cells, cells // 5
    material = {
        "model_part_name": "Initial_MPM_Material.Cube",
        "properties_id": 1,
        "Material": {
            "constitutive_law": {"name": "HyperElasticNeoHookean3DLaw"},
            "Variables": {"DENSITY": 1000.0, "YOUNG_MODULUS": 1e6, "POISSON_RATIO": 0.3, "MATERIAL_POINTS_PER_ELEMENT": 8},
        },
    }
    modeler = {"input_type": "use_input_model_part"}
    solver = {
        "solver_type": "dynamic",
        "time_integration_method": "explicit",
        "scheme_type": "forward_euler",
        "stress_update": "usl",
        "domain_size": 3,
        "time_stepping": {"time_step": 4e-3 * h},
        "material_import_settings": {"materials": [material]},
        "model_import_settings": modeler,
        "grid_model_import_settings": modeler,
    }
    low, high = -margin * h, 1.0 + margin * h
    return {
        "problem_data": {"problem_name": "cube", "start_time": 0.0, "end_time": (steps - 0.5) * 4e-3 * h},
        "solver_settings": solver | members,
        "modelers": [
            {
                "name": "RegularGridModeler",
                "Parameters": {
                    "min": [low, low, 0.0],
                    "max": [high, high, high],
                    "divisions": [cells + 2 * margin, cells + 2 * margin, cells + margin],
                    "parts": [{"name": "Floor", "side": "min_z"}],
                },
            },
            {
                "name": "BodyModeler",
                "Parameters": {
                    "bodies": [{"name": "Cube", "primitive": {"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]}, "cell_size": h}]
                },
            },
        ],
        "processes": {
            "all": [
                {
                    "python_module": "assign_vector_variable_process",
                    "kratos_module": "KratosMultiphysics",
                    "Parameters": {
                        "model_part_name": "Background_Grid.Floor",
                        "variable_name": "DISPLACEMENT",
                        "constrained": [True, True, True],
                        "value": [0.0, 0.0, 0.0],
                        "interval": [0.0, "End"],
                    },
                },
                {
                    "python_module": "assign_gravity_to_material_point_process",
                    "kratos_module": "KratosMultiphysics.MPMApplication",
                    "Parameters": {"model_part_name": "MPM_Material", "modulus": 9.81, "direction": [0.0, 0.0, -1.0]},
                },
            ]
        },
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cells", type=int, nargs="+")
    parser.add_argument("--bia", default="target/release/bia")
    parser.add_argument("--set", default="{}", help="JSON object added to solver_settings")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--yardstick")
    options = parser.parse_args()
    for cells in options.cells:
        points = 8 * cells**3
        steps = max(10, 20_000_000 // points)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "ProjectParameters.json")
            file.write_text(json.dumps(project(cells, steps, json.loads(options.set))))
            command = [options.bia, "run", str(file), "--threads", str(options.threads)]
            text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        wall, cpu = map(float, re.search(r"time of the loop\s+([\d.]+) s, CPU ([\d.]+) s", text).groups())
        line = f"{points} points, {steps} steps: {points * steps / cpu / 1e6:.1f} million a CPU second"
        line += f", {points * steps / wall / 1e6:.1f} a second of wall time"
        if options.yardstick:
            bare = subprocess.run([options.yardstick, str(cells), "10", "4", str(options.threads)], capture_output=True, text=True, check=True)
            rate = float(re.search(r"MPS_cpu ([\d.]+)M", bare.stdout)[1])
            line += f"; bare loop {rate:.1f}, ratio {points * steps / cpu / 1e6 / rate:.2f}"
        print(line, flush=True)


if __name__ == "__main__":
    main()
