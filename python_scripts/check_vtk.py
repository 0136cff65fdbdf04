#!/usr/bin/env python3
"""Reads .vtk, .vtu, .pvd and .series files with VTK's own readers and prints what they hold as JSON.

Exits with 1 when a file cannot be read, or when VTK says anything about it.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy
from vtk_files import Unreadable, fields_of, is_series, points_of, read_grid, read_series, time_of


def range_of(values):
    """Smallest and largest finite number, or None."""
    finite = values[numpy.isfinite(values)]
    return [finite.min().item(), finite.max().item()] if finite.size else None


def describe_field(name, values, entities):
    """One field: a range for each component, and how many values are nan or infinite."""
    if len(values) != entities:
        raise Unreadable(f"field {name} has {len(values)} entries for {entities} points or cells")
    columns = values if values.ndim > 1 else values.reshape(-1, 1)
    return {
        "name": name,
        "components": columns.shape[1],
        "type": str(values.dtype),
        "ranges": [range_of(column) for column in columns.T],
        "not_finite": int(columns.size - numpy.isfinite(columns).sum()),
    }


def describe(path):
    """Everything about one data file."""
    grid = read_grid(path)
    points, cells = grid.GetNumberOfPoints(), grid.GetNumberOfCells()
    types, counts = numpy.unique([grid.GetCellType(i) for i in range(cells)], return_counts=True)
    sections = {"point_fields": (grid.GetPointData(), points), "cell_fields": (grid.GetCellData(), cells)}
    described = {
        name: [describe_field(field, values, entities) for field, values in fields_of(data).items()]
        for name, (data, entities) in sections.items()
    }
    return {
        "file": str(path),
        "time": time_of(grid),
        "points": points,
        "cells": cells,
        "cell_types": {str(int(t)): int(c) for t, c in zip(types, counts)},
        "bounds": [range_of(column) for column in points_of(grid).T],
        **described,
    }


def check(path, files, faults):
    """Describes a file, or all the files of a series."""
    try:
        if is_series(path):
            entries = read_series(path)
            files.append({"file": str(path), "entries": len(entries), "times": sorted({e.time for e in entries})})
            for entry in entries:
                check(entry.file, files, faults)
        else:
            files.append(describe(path))
    except Unreadable as fault:
        faults.append(str(fault))


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", type=Path)
    files, faults = [], []
    for path in parser.parse_args().files:
        check(path, files, faults)
    json.dump({"files": files, "unreadable": faults}, sys.stdout, indent=1, allow_nan=False)
    print()
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
