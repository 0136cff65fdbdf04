"""What applications cost the scenes that do not use them: builds the program with all applications and with
each alone, runs the same scenes with both, and prints binary sizes and CPU times as Markdown.

    measure_features.py [APPLICATION ...] [--repetitions 9] [--into docs/studies.md]

Builds go to `target/features/` and take some minutes; the programs stay there as `bia_APPLICATIONS`, without
symbols. Runs of the two programs alternate, so that a machine that slows down slows both. Python's standard
library only.
"""

import argparse
import json
import shutil
import statistics
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Scenes of each application, and what is set in them, so that they take long enough for a ratio of times.
APPLICATIONS = {
    "mpm": ["colliding_discs", "falling_block", "cook_incompressible"],
    "dgmpm": ["dgmpm_notched_plate"],
    "structural": ["studies/plate_impact/fem.json"],
}
SET = {
    "studies/plate_impact/fem.json": ["/modelers/0/parameters/divisions=[128, 96]",
                                      "/solver_settings/time_stepping/time_step=4.7e-6"],
}


def build(features):
    """The program with these applications. What they share is compiled once."""
    target = ROOT / "target/features"
    profile = ["--config", "profile.release.strip=true", "--config", "profile.release.debug=false"]
    features_only = ["--no-default-features", "--features", ",".join(features)]
    command = ["cargo", "build", "--release", "--bin", "bia", "--target-dir", target, *profile, *features_only]
    subprocess.run(command, cwd=ROOT, check=True)
    program = target / ("bia_" + "_".join(features))
    shutil.copy2(target / "release/bia", program)
    return program


def cpu_time(program, project, changes, folder):
    """CPU seconds of the loop over time steps."""
    summary = Path(folder) / "summary.json"
    line = [program, "run", project, "--quiet", "--threads", "1", "--output", folder, "--summary", summary]
    subprocess.run(line + [word for change in changes for word in ("--set", change)], check=True)
    return json.loads(summary.read_text())["loop_cpu_s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("applications", nargs="*", metavar="APPLICATION", choices=[[], *APPLICATIONS],
                        help=f"measured alone: {', '.join(APPLICATIONS)}; all without any")
    parser.add_argument("--repetitions", type=int, default=9)
    parser.add_argument("--into", type=Path, help="text with a place between <!-- features --> and <!-- end -->")
    arguments = parser.parse_args()
    whole = build(list(APPLICATIONS))
    size = lambda program: f"{program.stat().st_size / 1e6:.1f}"
    lines = ["| applications | binary MB | scene | CPU s, all built in | CPU s, this one alone | ratio | spread |"]
    lines += ["|---|---|---|---|---|---|---|", f"| all | {size(whole)} | | | | | |"]
    for application in arguments.applications or APPLICATIONS:
        scenes, alone = APPLICATIONS[application], build([application])
        for scene in scenes:
            path = ROOT / "examples" / scene
            project = path if path.suffix == ".json" else path / "ProjectParameters.json"
            with tempfile.TemporaryDirectory() as folder:
                pairs = [tuple(cpu_time(program, project, SET.get(scene, []), folder) for program in (whole, alone))
                         for _ in range(arguments.repetitions)]
            ratios = [a / b for a, b in pairs]
            medians = [statistics.median(times) for times in zip(*pairs)]
            quarters = statistics.quantiles(ratios, n=4)
            lines.append(f"| {application} | {size(alone)} | {scene} | {medians[0]:.4f} | {medians[1]:.4f} "
                         f"| {statistics.median(ratios):.3f} | {quarters[0]:.3f}–{quarters[2]:.3f} |")
    table = "\n".join(lines)
    print(table)
    if arguments.into:
        text = arguments.into.read_text()
        head, rest = text.split("<!-- features -->")
        tail = rest.split("<!-- end -->", 1)[1]
        arguments.into.write_text(f"{head}<!-- features -->\n\n{table}\n\n<!-- end -->{tail}")


if __name__ == "__main__":
    main()
