"""Checks the vtu files of examples/falling_disc against free fall, read with VTK's own reader.

    check_falling_disc.py results/vtk_output/MPM_Material.pvd

Until it meets the floor every point falls by g t² / 2 with velocity g t; Newmark's rule is exact for
that, so only round-off may remain. The grid file beside it must hold the nodes and cells of the project.
"""

import sys
from pathlib import Path

import numpy
from vtk.util.numpy_support import vtk_to_numpy
from vtk_files import read_grid, read_series

GRAVITY, FALLING = 9.81, 0.2
TOLERANCE = 1e-12

series = [entry for entry in read_series(Path(sys.argv[1])) if "Grid" not in entry.file.name]
start = vtk_to_numpy(read_grid(series[0].file).GetPoints().GetData())
worst, seen = 0.0, 0
for entry in series:
    if entry.time > FALLING:
        break
    grid = read_grid(entry.file)
    place = vtk_to_numpy(grid.GetPoints().GetData())
    data = grid.GetPointData() if grid.GetPointData().GetArray("MP_VELOCITY") else grid.GetCellData()
    velocity = vtk_to_numpy(data.GetArray("MP_VELOCITY"))
    fall = numpy.array([0.0, -0.5 * GRAVITY * entry.time**2, 0.0])
    speed = numpy.array([0.0, -GRAVITY * entry.time, 0.0])
    worst = max(worst, abs(place - start - fall).max(), abs(velocity - speed).max())
    seen += 1
print(f"free fall: {seen} vtu files, largest error {worst:.1e}, tolerance {TOLERANCE:.0e}")
grids = list(Path(sys.argv[1]).parent.glob("Background_Grid*.vtu"))
shape = [(read_grid(g).GetNumberOfPoints(), read_grid(g).GetNumberOfCells()) for g in grids]
print(f"grid: {shape}")
sys.exit(not (worst <= TOLERANCE and seen > 5 and shape and all(points > cells > 0 for points, cells in shape)))
