"""What `bia convert` writes is read by others: meshio, VTK, and Gmsh where it is installed.

Usage: check_convert.py BIA FOLDER MESH...: converts each mesh to msh 2.2 and 4.1, as text and binary, mdpa and vtu in FOLDER,
reads each with the programs that know the format, and compares points, cells by kind, groups and the total measure.
"""

import pathlib
import subprocess
import sys

import meshio
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

try:
    import gmsh
except (ImportError, OSError):  # Gmsh's library wants X11, which is not everywhere
    gmsh = None

VTK_NAMES = {1: "vertex", 3: "line", 5: "triangle", 9: "quad", 10: "tetra", 12: "hexahedron"}


def counts(pairs):
    """Numbers of cells by kind, without points: a part of lone nodes is one in some formats and none in others."""
    total = {}
    for kind, count in pairs:
        if kind != "vertex":
            total[kind] = total.get(kind, 0) + count
    return total


def by_meshio(path):
    mesh = meshio.read(path)
    groups = sorted(mesh.field_data) if path.suffix == ".msh" else None
    return len(mesh.points), counts((block.type, len(block.data)) for block in mesh.cells), groups


def by_vtk(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    types = [grid.GetCellType(cell) for cell in range(grid.GetNumberOfCells())]
    kinds, number = np.unique(types, return_counts=True)
    names = [grid.GetCellData().GetArrayName(i) for i in range(grid.GetCellData().GetNumberOfArrays())]
    ids = vtk_to_numpy(grid.GetPointData().GetArray("NODE_ID"))
    assert (np.diff(ids) > 0).all(), f"{path}: node ids"
    groups = sorted(name.removeprefix("Part ") for name in names if name.startswith("Part "))
    return grid.GetNumberOfPoints(), counts((VTK_NAMES[kind], int(n)) for kind, n in zip(kinds, number)), groups


def by_gmsh(path):
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    gmsh.open(str(path))
    kinds, tags, _ = gmsh.model.mesh.getElements()
    names = {15: "vertex", 1: "line", 2: "triangle", 3: "quad", 4: "tetra", 5: "hexahedron"}
    cells = counts((names[kind], len(t)) for kind, t in zip(kinds, tags))
    groups = sorted({gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()})
    nodes = len(gmsh.model.mesh.getNodes()[0])
    gmsh.finalize()
    return nodes, cells, groups


def main():
    bia, folder, meshes = sys.argv[1], pathlib.Path(sys.argv[2]), [pathlib.Path(name) for name in sys.argv[3:]]
    folder.mkdir(parents=True, exist_ok=True)
    faults, read = [], 0
    for mesh in meshes:
        files = [(f"{mesh.stem}_{v}.msh", ["--msh-version", v]) for v in ("2.2", "4.1")]
        files += [(f"{mesh.stem}_binary_{v}.msh", ["--msh-version", v, "--msh-binary"]) for v in ("2.2", "4.1")]
        files += [(f"{mesh.stem}.mdpa", []), (f"{mesh.stem}.vtu", [])]
        results = {}
        for name, options in files:
            path = folder / name
            subprocess.run([bia, "convert", mesh, path, "--force", *options], check=True, capture_output=True)
            programs = {"meshio": by_meshio}
            if path.suffix == ".vtu":
                programs["VTK"] = by_vtk
            if path.suffix == ".msh" and gmsh:
                programs["Gmsh"] = by_gmsh
            for program, reader in programs.items():
                results[f"{program} {name}"] = reader(path)
                read += 1
        reference = results[f"VTK {mesh.stem}.vtu"]
        for what, found in results.items():
            for name, value, expected in zip(("points", "cells", "groups"), found, reference):
                # In msh 2.2 a cell stands once for each of its groups; in mdpa meshio guesses kinds from digits in
                # the names of elements and passes geometries over.
                skipped = name == "cells" and (what.endswith("_2.2.msh") or what.endswith(".mdpa"))
                if value is not None and not skipped and value != expected:
                    faults.append(f"{what}: {name} are {value}, by VTK {expected}")
    print("\n".join(faults) or f"{read} files of bia convert are read by meshio, VTK{', Gmsh' if gmsh else ''} and agree")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
