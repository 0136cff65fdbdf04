#!/usr/bin/env python3
"""Writes the meshes of tests/gmsh with Gmsh itself (pip install gmsh): each in formats 2.2 and 4.1, as text and
binary. `python python_scripts/make_gmsh_fixtures.py FOLDER`; prints the numbers that the tests expect."""

import math
import pathlib
import sys

import gmsh


def plate():
    """A plate of two materials with a hole; one half of triangles, one of quadrilaterals."""
    occ = gmsh.model.occ
    left = occ.addRectangle(0, 0, 0, 1, 1)
    right = occ.addRectangle(1, 0, 0, 1, 1)
    hole = occ.addDisk(0.5, 0.5, 0, 0.2, 0.2)
    occ.cut([(2, left)], [(2, hole)])
    occ.fragment(gmsh.model.occ.getEntities(2), [])
    occ.synchronize()
    by_x = sorted(gmsh.model.getEntities(2), key=lambda e: occ.getCenterOfMass(*e)[0])
    floor = [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(-1e-6, -1e-6, -1, 2 + 1e-6, 1e-6, 1, dim=1)]
    corner = [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(-1e-6, -1e-6, -1, 1e-6, 1e-6, 1, dim=0)]
    gmsh.model.addPhysicalGroup(2, [by_x[0][1]], name="Holed")
    gmsh.model.addPhysicalGroup(2, [by_x[1][1]], name="Whole")
    gmsh.model.addPhysicalGroup(2, [by_x[0][1], by_x[1][1]], name="Both")
    gmsh.model.addPhysicalGroup(1, floor, name="Floor of plate")
    gmsh.model.addPhysicalGroup(0, corner, name="Corner")
    gmsh.model.mesh.setTransfiniteSurface(by_x[1][1])
    gmsh.model.mesh.setRecombine(2, by_x[1][1])
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)


def block():
    """A block of tetrahedra that stands on its lowest face."""
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 2)
    gmsh.model.occ.synchronize()
    lowest = [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(-1e-6, -1e-6, -1e-6, 1.1, 1.1, 1e-6, dim=2)]
    gmsh.model.addPhysicalGroup(3, [1], name="Block")
    gmsh.model.addPhysicalGroup(2, lowest, name="Base")
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.9)


def bricks():
    """A block of hexahedra without names."""
    gmsh.model.occ.addBox(0, 0, 0, 1, 2, 1)
    gmsh.model.occ.synchronize()
    for _, curve in gmsh.model.getEntities(1):
        gmsh.model.mesh.setTransfiniteCurve(curve, 3)
    for _, surface in gmsh.model.getEntities(2):
        gmsh.model.mesh.setTransfiniteSurface(surface)
        gmsh.model.mesh.setRecombine(2, surface)
    gmsh.model.mesh.setTransfiniteVolume(1)
    gmsh.model.addPhysicalGroup(3, [1], tag=7)


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    for make, dimension in [(plate, 2), (block, 3), (bricks, 3)]:
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        make()
        gmsh.model.mesh.generate(dimension)
        for version in (2.2, 4.1):
            for binary in (0, 1):
                gmsh.option.setNumber("Mesh.MshFileVersion", version)
                gmsh.option.setNumber("Mesh.Binary", binary)
                gmsh.write(str(folder / f"{make.__name__}_{version}_{'binary' if binary else 'text'}.msh"))
        for group_dimension, tag in gmsh.model.getPhysicalGroups():
            name = gmsh.model.getPhysicalName(group_dimension, tag) or f"{group_dimension}, {tag}"
            nodes, _ = gmsh.model.mesh.getNodesForPhysicalGroup(group_dimension, tag)
            cells = 0
            for entity in gmsh.model.getEntitiesForPhysicalGroup(group_dimension, tag):
                cells += sum(len(ids) for ids in gmsh.model.mesh.getElements(group_dimension, entity)[1])
            print(make.__name__, name, len(nodes), "nodes", cells, "cells")
        gmsh.finalize()
    print("area of the plate as meshed: 2 -", math.pi * 0.04, "+ what the polygon lacks")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
