#!/usr/bin/env python3
"""Checks `bia schema` (pip install jsonschema): projects that run satisfy it, and slips in them do not.
`python python_scripts/check_schema.py BIA PROJECT...`"""

import copy
import json
import subprocess
import sys

import jsonschema


def slips(project):
    """The project with one thing wrong each."""
    changes = [
        ("an unknown key", lambda p: p["solver_settings"].update(max_iterations=3)),
        ("a text for a number", lambda p: p["problem_data"].update(end_time="1.0")),
        ("an unknown solver", lambda p: p["solver_settings"].update(solver_type="dynamical")),
        ("no settings", lambda p: p.pop("solver_settings")),
        ("an unknown process", lambda p: p.update(processes={"a": [{"python_module": "assing", "Parameters": {}}]})),
        ("a step below 0", lambda p: p["solver_settings"].update(time_stepping={"time_step": -1.0})),
    ]
    for name, change in changes:
        changed = copy.deepcopy(project)
        change(changed)
        yield name, changed


def main(bia, files):
    schema = json.loads(subprocess.run([bia, "schema"], check=True, capture_output=True).stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    faults = 0
    for file in files:
        project = json.load(open(file))
        for error in validator.iter_errors(project):
            faults += 1
            print(f"{file}: {error.json_path}: {error.message[:200]}")
        for name, changed in slips(project):
            if validator.is_valid(changed):
                faults += 1
                print(f"{file}: {name} passes")
    print(f"schema: {len(files)} projects, {faults} faults")
    return faults > 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
