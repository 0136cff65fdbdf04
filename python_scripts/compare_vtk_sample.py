#!/usr/bin/env python3
"""Run a project with Bia and compare its VTK, JSON and energy files with those that Kratos wrote for it.

  compare_vtk_sample.py SAMPLE [--bia CMD]

SAMPLE is a folder with ProjectParameters.json, its meshes and materials, and the files that Kratos's output
processes wrote. The project is copied to an empty folder and run there with --kratos-exact on one thread.
VTK files must be equal byte by byte; tables and JSON files up to 1e-9 of the largest number of the file.
Exit status 0 when everything is equal. Standard library only."""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile


def numbers(path):
    """All numbers of a JSON file or a table, and what stands between them."""
    with open(path) as file:
        text = file.read()
    found, rest = [], []

    def walk(value):
        if isinstance(value, dict):
            for key, entry in value.items():
                rest.append(key)
                walk(entry)
        elif isinstance(value, list):
            rest.append(len(value))
            for entry in value:
                walk(entry)
        else:
            found.append(float(value))

    if path.endswith(".json"):
        walk(json.loads(text))
        return found, rest
    for word in text.split():
        try:
            found.append(float(word))
        except ValueError:
            rest.append(word)
    return found, rest


def difference(expected, path):
    """None when equal, else why not."""
    if path.endswith(".vtk"):
        with open(expected, "rb") as a, open(path, "rb") as b:
            return None if a.read() == b.read() else "the bytes differ"
    (a, words), (b, other_words) = numbers(expected), numbers(path)
    if words != other_words or len(a) != len(b):
        return "the layouts differ"
    scale = max((abs(x) for x in a), default=1.0)
    worst = max((abs(x - y) for x, y in zip(a, b)), default=0.0)
    return None if worst <= 1e-9 * scale else f"the largest difference is {worst:.2e} of {scale:.2e}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sample")
    parser.add_argument("--bia", default="target/release/bia")
    arguments = parser.parse_args()
    sample = os.path.abspath(arguments.sample)
    inputs = [f for f in os.listdir(sample) if f.endswith(".mdpa") or f in ("ProjectParameters.json", "ParticleMaterials.json")]
    outputs = []
    for folder, _, files in os.walk(sample):
        paths = [os.path.relpath(os.path.join(folder, file), sample) for file in files]
        outputs += [p for p in paths if p not in inputs and p.endswith((".vtk", ".json", ".dat"))]
    with tempfile.TemporaryDirectory() as work:
        for file in inputs:
            shutil.copy(os.path.join(sample, file), work)
        command = [os.path.abspath(arguments.bia), "run", "ProjectParameters.json", "--kratos-exact", "--threads", "1", "--quiet"]
        subprocess.run(command, cwd=work, check=True)
        written = {os.path.relpath(os.path.join(d, f), work) for d, _, files in os.walk(work) for f in files}
        faults = [f"{path}: Kratos did not write it" for path in sorted(written - set(outputs) - set(inputs))]
        for path in sorted(outputs):
            own = os.path.join(work, path)
            fault = difference(os.path.join(sample, path), own) if os.path.exists(own) else "was not written"
            if fault:
                faults.append(f"{path}: {fault}")
    for fault in faults:
        print(fault)
    print(f"{len(outputs)} files compared, {len(faults)} faults")
    return 1 if faults or not outputs else 0


if __name__ == "__main__":
    sys.exit(main())
