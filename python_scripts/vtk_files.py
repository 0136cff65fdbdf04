"""Reading Bia's result files with VTK's own readers: shared by the scripts of this folder."""

import json
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path

import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy

# What VTK has to say goes into `Unreadable`.
vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_OFF)


class Unreadable(Exception):
    """A file that VTK cannot read, with its reason."""


@dataclass
class Entry:
    """One file of a series; time and part are None where the series does not tell."""

    file: Path
    time: float | None = None
    part: str | None = None


def is_series(path: Path) -> bool:
    """Whether the file is a list of other files."""
    return path.suffix in (".pvd", ".series")


def read_series(path: Path) -> list[Entry]:
    """Entries of a .pvd or .series file, in their order; paths are relative to the series."""
    try:
        if path.suffix == ".pvd":
            sets = xml.parse(path).getroot().findall("./Collection/DataSet")
            found = [(s.attrib["file"], s.attrib["timestep"], s.get("name") or s.get("part")) for s in sets]
        else:
            found = [(f["name"], f["time"], None) for f in json.loads(path.read_text(encoding="utf-8"))["files"]]
        return [Entry(path.parent / file, float(time), part) for file, time, part in found]
    except (OSError, KeyError, TypeError, ValueError, xml.ParseError) as error:
        raise Unreadable(f"{path}: {error!r}") from error


def read_grid(path: Path) -> vtk.vtkUnstructuredGrid:
    """The grid of a .vtk or .vtu file. Whatever VTK complains about makes it unreadable."""
    readers = {".vtk": vtk.vtkUnstructuredGridReader, ".vtu": vtk.vtkXMLUnstructuredGridReader}
    if path.suffix not in readers:
        raise Unreadable(f"{path}: only {', '.join(readers)}, .pvd and .series are known")
    if not path.is_file():
        raise Unreadable(f"{path}: no such file")
    window, usual = vtk.vtkStringOutputWindow(), vtk.vtkOutputWindow.GetInstance()
    vtk.vtkOutputWindow.SetInstance(window)
    try:
        reader = readers[path.suffix]()
        reader.SetFileName(str(path))
        reader.Update()
        grid = reader.GetOutput()
    finally:
        vtk.vtkOutputWindow.SetInstance(usual)
    complaint = " ".join((window.GetOutput() or "").split())
    if complaint or reader.GetErrorCode() or grid is None:
        raise Unreadable(f"{path}: {complaint or 'VTK error ' + str(reader.GetErrorCode())}")
    return grid


def points_of(grid):
    """Coordinates as an array (points, 3)."""
    return vtk_to_numpy(grid.GetPoints().GetData()) if grid.GetNumberOfPoints() else numpy.zeros((0, 3))


def fields_of(attributes) -> dict:
    """Arrays by name of point, cell or field data."""
    arrays = (attributes.GetArray(i) for i in range(attributes.GetNumberOfArrays()))
    return {array.GetName(): vtk_to_numpy(array) for array in arrays if array is not None}


def time_of(grid) -> float | None:
    """The time stored in the file itself, if any."""
    array = grid.GetFieldData().GetArray("TimeValue")
    return array.GetValue(0) if array is not None and array.GetNumberOfValues() else None
