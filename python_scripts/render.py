#!/usr/bin/env python3
"""Draws the points of a .vtk, .vtu or .pvd file, coloured by a field, into a PNG picture.

Plane results are drawn to scale with squares of the points' spacing, others in perspective.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy
import vtk
from matplotlib.collections import LineCollection
from mpl_toolkits.axes_grid1 import make_axes_locatable
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtk_files import Unreadable, fields_of, is_series, points_of, read_grid, read_series, time_of

DPI = 160
COLOURS = "viridis"
GRID_COLOUR = "0.55"


@dataclass
class Cloud:
    """Points to draw, the value of each, and what the values are called."""

    points: numpy.ndarray
    values: numpy.ndarray | None
    label: str


@dataclass
class Style:
    """How the points are drawn; their width is in the data's unit of length."""

    title: str
    marker: str
    width: float


def choose_files(path, step):
    """Files of one time of a series (the last without `step`), and that time; or the file itself."""
    if not is_series(path):
        return [path], None
    entries = read_series(path)
    times = sorted({entry.time for entry in entries})
    try:
        time = times[-1 if step is None else step]
    except IndexError:
        raise Unreadable(f"{path}: step {step} of {len(times)} (counted from 0)") from None
    return [entry.file for entry in entries if entry.time == time], time


def cell_centres(grid):
    """Mean of each cell's nodes; a vertex cell's centre is its point."""
    filter_ = vtk.vtkCellCenters()
    filter_.SetInputData(grid)
    filter_.Update()
    return points_of(filter_.GetOutput())


def is_cloud_of_vertices(grid):
    """Whether each point is its own cell, so that fields of cells belong to the points."""
    return grid.GetNumberOfCells() == grid.GetNumberOfPoints() and grid.GetMaxCellSize() == 1


def located_fields(grid):
    """Fields by name: (points, values). Fields of mesh cells stand at the cells' centres."""
    points = points_of(grid)
    centres = points if is_cloud_of_vertices(grid) else cell_centres(grid)
    fields = {name: (centres, values) for name, values in fields_of(grid.GetCellData()).items()}
    fields.update({name: (points, values) for name, values in fields_of(grid.GetPointData()).items()})
    return fields


def default_field(fields):
    """The first field that varies and is no list of integers, such as ids; else the first one."""
    real = [n for n, (_, v) in fields.items() if v.dtype.kind == "f" and v.size and numpy.nanmin(v) < numpy.nanmax(v)]
    return next(iter(real or fields), None)


def component_names(name, count):
    """Names of a field's components: x, y, z, or Voigt's order for stresses and strains."""
    if any(word in name.upper() for word in ("STRESS", "STRAIN")):
        voigt = {3: ["xx", "yy", "xy"], 4: ["xx", "yy", "zz", "xy"], 6: ["xx", "yy", "zz", "xy", "yz", "xz"]}
        return voigt.get(count, [])
    return list("xyz") if count == 3 else []


def take_component(name, values, component):
    """One number for each point and its label: the component asked for, or the magnitude of vectors."""
    if values.ndim == 1:
        if component is not None:
            raise Unreadable(f"field {name} is a scalar: {component!r} cannot be taken")
        return values, name
    if component in (None, "magnitude"):
        return numpy.linalg.norm(values, axis=1), f"{name} magnitude"
    names = component_names(name, values.shape[1])
    numbers = [str(i) for i in range(values.shape[1])]
    for known in (names, numbers):
        if component in known:
            return values[:, known.index(component)], f"{name} {component}"
    allowed = ", ".join(["magnitude", *names, *numbers])
    raise Unreadable(f"field {name} has no component {component!r}, allowed: {allowed}")


def load_cloud(grids, field):
    """Points and values of all files of one time."""
    name, _, component = (field or "").partition(":")
    parts = []
    for grid in grids:
        fields = located_fields(grid)
        chosen = name or default_field(fields)
        if chosen is None:
            parts.append(Cloud(points_of(grid), None, ""))
        elif chosen not in fields:
            raise Unreadable(f"no field {chosen!r}, there are: {', '.join(fields) or 'none'}")
        else:
            name = chosen
            points, values = fields[chosen]
            parts.append(Cloud(points, *take_component(chosen, values, component or None)))
    coloured = all(part.values is not None for part in parts)
    values = numpy.concatenate([part.values for part in parts]) if coloured else None
    return Cloud(numpy.concatenate([part.points for part in parts]), values, parts[0].label)


def edges_of(grid, only_surface):
    """End points of the mesh's edges, as an array (edges, 2, 3)."""
    edges = vtk.vtkExtractEdges()
    if only_surface:
        surface = vtk.vtkGeometryFilter()
        surface.SetInputData(grid)
        edges.SetInputConnection(surface.GetOutputPort())
    else:
        edges.SetInputData(grid)
    edges.Update()
    lines = edges.GetOutput()
    if not lines.GetNumberOfLines():
        return numpy.zeros((0, 2, 3))
    return points_of(lines)[vtk_to_numpy(lines.GetLines().GetConnectivityArray())].reshape(-1, 2, 3)


def spacing_of(points):
    """Median distance to the nearest neighbour, over a sample of the points."""
    cloud = vtk.vtkPolyData()
    cloud.SetPoints(vtk.vtkPoints())
    cloud.GetPoints().SetData(numpy_to_vtk(numpy.ascontiguousarray(points), deep=True))
    locator = vtk.vtkStaticPointLocator()
    locator.SetDataSet(cloud)
    locator.BuildLocator()
    near, distances = vtk.vtkIdList(), []
    for point in points[:: max(1, len(points) // 400)]:
        locator.FindClosestNPoints(2, point, near)
        ends = [points[near.GetId(i)] for i in range(near.GetNumberOfIds())]
        distances.append(max(numpy.linalg.norm(end - point) for end in ends))
    return float(numpy.median(distances)) or 1.0


def bounds_of(points, edges):
    """Lower and upper corner of everything drawn, with a margin of 3 % of the largest extent."""
    everything = numpy.concatenate([points, edges.reshape(-1, 3)])
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.03 * max((high - low).max(), 1e-30)
    return low - margin, high + margin


def colour_options(cloud):
    """How scatter colours the points; one constant value still gets a bar that shows it."""
    if cloud.values is None:
        return {"c": "tab:blue"}
    finite = cloud.values[numpy.isfinite(cloud.values)]
    low, high = (finite.min(), finite.max()) if finite.size else (0.0, 1.0)
    if low == high:
        low, high = low - max(abs(low), 1.0) * 1e-3, high + max(abs(high), 1.0) * 1e-3
    return {"c": cloud.values, "cmap": COLOURS, "vmin": low, "vmax": high, "plotnonfinite": False}


def label_bar(bar, label):
    """Name of the field along the colour bar, and short numbers."""
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)
    bar.formatter.set_powerlimits((-3, 4))
    bar.update_ticks()


def draw_plane(cloud, edges, style, size):
    """A picture in the plane, to scale."""
    low, high = bounds_of(cloud.points, edges)
    extent = (high - low)[:2]
    wide = extent[0] > 2.2 * extent[1]
    if size is None:
        height = 1150 * extent[1] / extent[0] + (320 if wide else 130)
        size = (1400, int(numpy.clip(height, 480, 1500)))
    figure, axes = plt.subplots(figsize=(size[0] / DPI, size[1] / DPI), dpi=DPI)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x", ylabel="y")
    axes.set_title(style.title, loc="left")
    axes.add_collection(LineCollection(edges[:, :, :2], colors=GRID_COLOUR, linewidths=0.4, zorder=1))
    dots = axes.scatter(*cloud.points[:, :2].T, marker=style.marker, linewidths=0, zorder=2, **colour_options(cloud))
    if cloud.values is not None:
        place = ("bottom", 0.16, 0.6) if wide else ("right", 0.2, 0.12)
        bar_axes = make_axes_locatable(axes).append_axes(place[0], size=place[1], pad=place[2])
        label_bar(figure.colorbar(dots, cax=bar_axes, orientation="horizontal" if wide else "vertical"), cloud.label)
    figure.tight_layout(pad=0.6)
    figure.canvas.draw()  # only now is the scale known
    points_per_unit = axes.get_window_extent().width / extent[0] * 72 / DPI
    width = style.width * points_per_unit
    overlap = 1.15 if width < 6 else 0.96  # small squares are rounded to pixels, which would leave gaps
    dots.set_sizes([max(overlap * width, 0.7) ** 2])
    return figure


def draw_space(cloud, edges, style, size):
    """A picture in perspective, z upwards."""
    low, high = bounds_of(cloud.points, edges)
    size = size or (1400, 1100)
    figure = plt.figure(figsize=(size[0] / DPI, size[1] / DPI), dpi=DPI)
    axes = figure.add_axes((0.0, 0.0, 0.86, 0.94), projection="3d", proj_type="persp", computed_zorder=False)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]), xlabel="x", ylabel="y", zlabel="z")
    axes.set_box_aspect(high - low, zoom=1.08)
    axes.view_init(elev=22, azim=-58)
    if len(edges):
        axes.grid(False)  # the mesh gives depth enough
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1, 1, 1, 0))
    axes.text2D(0.03, 1.0, style.title, transform=axes.transAxes, fontsize=plt.rcParams["axes.titlesize"])
    if len(edges):
        axes.add_collection3d(Line3DCollection(edges, colors=GRID_COLOUR, linewidths=0.3, alpha=0.6, zorder=1))
    pixels = 0.55 * min(size) / (high - low).max()
    width = max(1.25 * style.width * pixels * 72 / DPI, 0.7)
    rim = {"edgecolors": (0, 0, 0, 0.35), "linewidths": min(0.06 * width, 0.4)}
    dots = axes.scatter(*cloud.points.T, s=width**2, depthshade=False, zorder=2, **rim, **colour_options(cloud))
    if cloud.values is not None:
        label_bar(figure.colorbar(dots, cax=figure.add_axes((0.875, 0.2, 0.022, 0.6))), cloud.label)
    return figure


def render(arguments):
    """Reads, draws and saves; returns the name of the picture."""
    files, time = choose_files(arguments.file, arguments.step)
    grids = [read_grid(file) for file in files]
    cloud = load_cloud(grids, arguments.field)
    if not len(cloud.points):
        raise Unreadable(f"{arguments.file}: there are no points to draw")
    own_meshes = [grid for grid in grids if not is_cloud_of_vertices(grid)]
    meshes = own_meshes + ([read_grid(arguments.grid)] if arguments.grid else [])
    heights = numpy.concatenate([points_of(grid)[:, 2] for grid in [*grids, *meshes]])
    plane = heights.min() == heights.max()
    edges = numpy.concatenate([numpy.zeros((0, 2, 3)), *(edges_of(mesh, not plane) for mesh in meshes)])
    time = time if time is not None else time_of(grids[0])
    spacing = spacing_of(cloud.points)
    style = Style(
        title=arguments.file.stem + (f",  t = {time:.6g}" if time is not None else ""),
        marker="o" if own_meshes else "s",
        width=0.45 * spacing if own_meshes else spacing,
    )
    figure = (draw_plane if plane else draw_space)(cloud, edges, style, arguments.size)
    output = arguments.output or arguments.file.with_suffix(".png")
    # A size that was asked for is kept; else what stays white at the border is cut off.
    border = {} if arguments.size else {"bbox_inches": "tight", "pad_inches": 0.12}
    figure.savefig(output, dpi=DPI, **border)
    return output


def size_of(text):
    """Width and height of WxH in pixels."""
    width, height = (int(number) for number in text.lower().split("x"))
    return width, height


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, help=".vtk, .vtu, .pvd or .series")
    parser.add_argument("--field", metavar="NAME[:COMPONENT]", help="component: x, y, z, xx, xy, ..., a number from 0, or magnitude")
    parser.add_argument("--grid", type=Path, help="mesh to draw as lines behind the points")
    parser.add_argument("--output", type=Path, help="picture to write (default: FILE.png)")
    parser.add_argument("--step", type=int, help="time of a series, counted from 0 (default: the last)")
    parser.add_argument("--size", type=size_of, metavar="WxH", help="pixels (default: by the data's proportions)")
    try:
        print(render(parser.parse_args()))
    except Unreadable as fault:
        print(f"render.py: {fault}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
