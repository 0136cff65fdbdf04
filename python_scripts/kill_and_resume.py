"""Kills runs at random moments, resumes them, and compares what they leave with an undisturbed run.

    kill_and_resume.py [--bia PROGRAM] [--kills 50] [--seed 1] [PROJECT ...]

Without projects: examples of every formulation. Each project runs once undisturbed; then it is started,
killed (SIGKILL) after a random time and resumed, with one and two threads in turn, until that many
runs were killed; a sequence that reaches its end counts and begins anew. Every file of every finished
sequence must have the bytes of the undisturbed run. Only Python's standard library is needed.
"""

import argparse
import json
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FORMULATIONS = {
    "implicit, displacements": "falling_block/ProjectParameters.json",
    "implicit, u-p, OSGS": "cook_incompressible/ProjectParameters_dynamic.json",
    "implicit, u-p, fluid": "sloshing_tank/ProjectParameters.json",
    "explicit": "colliding_discs/ProjectParameters.json",
    "explicit, total Lagrangian, Verlet": "rotating_body/ProjectParameters.json",
    "explicit, total Lagrangian, MUSL": "tlmpm_step_bar/ProjectParameters.json",
    "DGMPM": "dgmpm_notched_plate/ProjectParameters.json",
}


def files(folder):
    """Contents by name; checkpoints and what a kill leaves unfinished belong to no result."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def command(bia, project, output, threads):
    return [bia, "run", str(project), "--quiet", "--output", str(output), "--threads", str(threads)]


def trial(bia, source, kills, draw):
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "project"
        shutil.copytree(source.parent, folder)
        project = folder / source.name
        whole = Path(scratch) / "whole"
        begin = time.monotonic()
        subprocess.run(command(bia, project, whole, 1), check=True)
        duration = time.monotonic() - begin
        expected = files(whole)
        settings = json.loads(re.sub(r"^\s*//.*$", "", project.read_text(), flags=re.M))
        settings["restart"] = {"every_seconds": max(duration / 40, 0.002)}
        project.write_text(json.dumps(settings))
        done = killed = starts = 0
        while killed < kills:
            output = Path(scratch) / f"pieces_{done}"
            resume = False
            while True:
                starts += 1
                line = command(bia, project, output, 1 + starts % 2) + (["--resume"] if resume else [])
                child = subprocess.Popen(line, stderr=subprocess.PIPE)
                try:
                    _, said = child.communicate(timeout=draw.uniform(0.0, 0.4 * duration) + 0.01)
                except subprocess.TimeoutExpired:
                    child.kill()
                    child.communicate()
                    killed += 1
                    resume = any((output / "restart").glob("*.checkpoint"))
                    continue
                if child.returncode != 0:
                    return f"exit code {child.returncode} after {killed} kills: {said.decode()[:300]}"
                break
            found = files(output)
            if found.keys() != expected.keys():
                return f"other files after {killed} kills: {sorted(found.keys() ^ expected.keys())}"
            differing = [name for name in expected if found[name] != expected[name]]
            if differing:
                return f"different bytes after {killed} kills: {differing}"
            shutil.rmtree(output)
            done += 1
        return f"{killed} kills in {done} sequences, {len(expected)} files, all bytes the same"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("projects", nargs="*", type=Path)
    parser.add_argument("--bia", default=str(ROOT / "target/release/bia"))
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    projects = {str(path): path for path in arguments.projects}
    projects = projects or {name: ROOT / "examples" / path for name, path in FORMULATIONS.items()}
    draw = random.Random(arguments.seed)
    failed = False
    for name, project in projects.items():
        result = trial(arguments.bia, project.resolve(), arguments.kills, draw)
        failed |= "all bytes the same" not in result
        print(f"{name}: {result}", flush=True)
    sys.exit(failed)


main()
