#!/usr/bin/env python3
"""Runs a project with Kratos and with Bia and compares the material points at the end of the run.

Both get a copy of the project's folder and one thread. Points are compared by their id. A difference
is max|a - b| over all points and components; the relative one is divided by Kratos's largest value.
CPU time of the loop: the time steps alone, results written in it included. CPU time and peak memory
of the process: all of it, with start, reading the input and writing the state that is compared.

Kratos must be importable by the Python that runs this script (or by --python):
    pip install KratosMultiphysics KratosMPMApplication KratosLinearSolversApplication
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PIP = "pip install KratosMultiphysics KratosMPMApplication KratosLinearSolversApplication"
FIELDS = ["MP_COORD", "MP_DISPLACEMENT", "MP_VELOCITY", "MP_CAUCHY_STRESS_VECTOR", "MP_MASS", "MP_VOLUME"]
PROJECT = "ProjectParameters.json"


class Stop(Exception):
    """Why there is nothing to compare."""


def peak_memory():
    """Largest resident memory of this process in MB (Linux)."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM:"))


def run_kratos(project, state_file):
    """Runs a project in this process, in the working folder, and writes the final state as JSON."""
    import KratosMultiphysics
    import KratosMultiphysics.MPMApplication as mpm
    from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis

    parameters = KratosMultiphysics.Parameters(Path(project).read_text(encoding="utf-8"))
    model = KratosMultiphysics.Model()
    analysis = MpmAnalysis(model, parameters)
    analysis.Initialize()
    begin = time.process_time()
    analysis.RunSolutionLoop()
    cpu_loop = time.process_time() - begin
    analysis.Finalize()
    settings = parameters["solver_settings"]
    name = settings["model_part_name"].GetString() if settings.Has("model_part_name") else "MPM_Material"
    part = model[name]
    points = {field: [] for field in FIELDS}
    for element in part.Elements:
        for field in FIELDS:
            value = element.CalculateOnIntegrationPoints(getattr(mpm, field), part.ProcessInfo)[0]
            points[field].append([value] if isinstance(value, float) else list(value))
    state = {
        "version": KratosMultiphysics.KratosGlobals.Kernel.Version().replace('"', "").split("-")[0],
        "steps": part.ProcessInfo[KratosMultiphysics.STEP],
        "time": part.ProcessInfo[KratosMultiphysics.TIME],
        "cpu_loop_s": cpu_loop,
        "memory_mb": peak_memory(),
        "mp": {"ids": [element.Id for element in part.Elements], **points},
    }
    Path(state_file).write_text(json.dumps(state), encoding="utf-8")


def measured(command, folder):
    """Runs a command; returns the CPU seconds of its process, or stops with its last lines."""
    log = folder / "log.txt"
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with log.open("wb") as out:
        process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=out, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
    code = process.returncode = os.waitstatus_to_exitcode(status)
    if code:
        last = "\n  ".join(log.read_text(errors="replace").splitlines()[-12:])
        raise Stop(f"{Path(command[0]).name} ended with exit code {code}; its last lines:\n  {last}")
    return usage.ru_utime + usage.ru_stime


def kratos(project, folder, python):
    """Kratos's final state and what it took."""
    probe = subprocess.run(
        [python, "-c", "import KratosMultiphysics.MPMApplication"], capture_output=True, text=True, check=False
    )
    if probe.returncode:
        last = (probe.stderr.strip().splitlines() or ["?"])[-1]
        raise Stop(f"{python} cannot import Kratos ({last}); install it:\n  {PIP}")
    own = str(Path(__file__).resolve())
    cpu = measured([python, own, "--kratos-worker", project, "kratos_state.json"], folder)
    state = json.loads((folder / "kratos_state.json").read_text())
    return {**state, "cpu_s": cpu}


def bia(project, folder, program, exact):
    """Bia's final state and what it took."""
    command = [program, "run", project, "--threads", "1", "--record", "record.json", "--record-states", "1"]
    cpu = measured(command + (["--kratos-exact"] if exact else []), folder)
    record = json.loads((folder / "record.json").read_text())
    last = record["snapshots"][-1]
    last["mp"] = {name: [v if isinstance(v, list) else [v] for v in values] if name != "ids" else values
                  for name, values in last["mp"].items()}
    return {
        "version": record["bia_version"],
        "steps": record["steps"],
        "time": record["end_time"],
        "cpu_loop_s": record["cpu_loop_s"],
        "mp": last["mp"],
        "cpu_s": cpu,
        "memory_mb": record["peak_rss_mb"],
    }


def largest(rows):
    """Largest magnitude; not a number wins."""
    numbers = [abs(x) if x is not None else float("nan") for row in rows for x in row]
    return next((x for x in numbers if x != x), max(numbers, default=0.0))


def difference(a, b):
    """max|a - b|; None, which stands for what is no finite number, counts as not a number."""
    width = max((len(row) for row in a + b), default=0)
    padded = [[(*row, *[0.0] * (width - len(row))) for row in rows] for rows in (a, b)]
    nan = float("nan")
    return largest([[(x if x is not None else nan) - (y if y is not None else nan) for x, y in zip(p, q)]
                    for p, q in zip(*padded)])


def compare(a, b):
    """Prints the table."""
    common = sorted(set(a["mp"]["ids"]) & set(b["mp"]["ids"]))
    print(f"Kratos {a['version']}: {len(a['mp']['ids'])} points, {a['steps']} steps, t = {a['time']:.9g} s")
    print(f"Bia {b['version']}: {len(b['mp']['ids'])} points, {b['steps']} steps, t = {b['time']:.9g} s")
    alone = [len(s["mp"]["ids"]) - len(common) for s in (a, b)]
    if any(alone):
        print(f"WARNING: {alone[0]} points are in Kratos alone, {alone[1]} in Bia alone; they are left out")
    if not common:
        raise Stop("no point has the same id in both")
    places = [{id_: i for i, id_ in enumerate(s["mp"]["ids"])} for s in (a, b)]
    print(f"\n{'at the end':26}{'Kratos, largest':>18}{'difference':>14}{'relative':>12}")
    for field in FIELDS:
        rows = [[s["mp"][field][place[id_]] for id_ in common] for s, place in zip((a, b), places)]
        scale, gap = largest(rows[0]), difference(*rows)
        relative = f"{gap / scale:12.1e}" if scale > 0 else f"{'-':>12}"
        print(f"{field:26}{scale:18.9g}{gap:14.1e}{relative}")
    print(f"\n{'one thread':26}{'Kratos':>18}{'Bia':>14}{'ratio':>12}")
    for key, label in (("cpu_loop_s", "CPU time of the loop [s]"), ("cpu_s", "CPU time, process [s]"),
                       ("memory_mb", "peak memory [MB]")):
        print(f"{label:26}{a[key]:18.3f}{b[key]:14.3f}{a[key] / max(b[key], 1e-9):12.1f}")


def find_project(given):
    """Folder and file name of a project."""
    path = given / PROJECT if given.is_dir() else given
    if not path.is_file():
        raise Stop(f"there is no {path}")
    text = path.read_text(encoding="utf-8")
    if "Modelers.Bia." in text:
        raise Stop(f"{path} makes its mesh with Bia's own modelers, which Kratos does not have")
    return path.parent, path.name


def find_bia(given):
    """The program, as an absolute path."""
    found = given if Path(given).is_file() else shutil.which(given)
    if not found:
        raise Stop(f"there is no program {given}: build it with `cargo build --release`, or name it with --bia")
    return str(Path(found).resolve())


def main():
    """Command line."""
    if sys.argv[1:2] == ["--kratos-worker"]:
        run_kratos(*sys.argv[2:4])
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("project", type=Path, help="folder with a ProjectParameters.json, or such a file")
    own = Path(__file__).resolve().parent.parent / "target" / "release" / "bia"
    parser.add_argument("--bia", default=str(own), help="the program (default: target/release/bia)")
    parser.add_argument("--exact", action="store_true", help="run Bia with --kratos-exact")
    parser.add_argument("--python", default=sys.executable, help="Python that has Kratos (default: this one)")
    arguments = parser.parse_args()
    try:
        source, name = find_project(arguments.project)
        program = find_bia(arguments.bia)
        with tempfile.TemporaryDirectory(prefix="compare_kratos_") as scratch:
            folders = [Path(scratch) / who for who in ("kratos", "bia")]
            for folder in folders:
                shutil.copytree(source, folder)
            compare(kratos(name, folders[0], arguments.python), bia(name, folders[1], program, arguments.exact))
    except Stop as reason:
        print(f"compare_kratos.py: {reason}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
