#!/usr/bin/env python3
"""Compares a run's VTKHDF files with its run.h5, array by array and step by step: first by the specification of the
format alone, then, where VTK 9.3 or later can be imported, by VTK's own reader. Prints how many arrays are equal by each.

    python3 vtkhdf_read.py DIR
"""
import pathlib
import re
import sys

import h5py
import numpy as np

TOPOLOGIES = ["Vertices", "Lines", "Polygons", "Strips"]


def frames_of(run):
    """Per frame, per block: points, cells (rows of points), arrays on points and on cells, from run.h5."""
    table = run.get("particles")
    for name in sorted(run["frames"]):
        frame, blocks = run["frames"][name], {}
        if "position" in frame:
            n = len(frame["position"])
            points = {k: frame[k][:] for k in ("velocity", "spin", "force", "torque", "contacts", "bonds") if k in frame}
            kept = frame if "id" in frame else table
            points |= {k: kept[k][:] for k in ("id", "radius", "density", "material", "clump") if k in kept}
            blocks["soil"] = (frame["position"][:], np.arange(n).reshape(-1, 1), points, {})
        if "contact forces" in frame:
            lines = frame["contact forces"]
            blocks["contact_forces"] = (lines["ends"][:], lines["lines"][:], {},
                                        {k: lines[k][:] for k in lines if k not in ("ends", "lines")})
        for surface, shape in run["surfaces"].items():
            moved = frame.get(f"surfaces/{surface}")
            cells = next((shape[k][:] for k in ("triangles", "segments") if k in shape), None)
            where = (moved if moved is not None else shape["vertices"])[:]
            loads = frame.get(f"loads/{surface}", {})
            blocks[re.sub(r"[^A-Za-z0-9.+-]", "_", surface)] = (where, cells if cells is not None else np.arange(len(where)).reshape(-1, 1),
                                                 {}, {k: loads[k][:] for k in loads})
        yield frame.attrs["time"], blocks


def by_the_specification(block, step):
    """The same of a step, read by offsets and numbers as the specification says."""
    steps = block["Steps"]
    part, at = int(steps["PartOffsets"][step]), int(steps["PointOffsets"][step])
    assert steps["NumberOfParts"][step] == 1
    n = int(block["NumberOfPoints"][part])
    cells, total = [], 0
    for k, topology in enumerate(TOPOLOGIES):
        group = block[topology]
        count, ids = int(group["NumberOfCells"][part]), int(group["NumberOfConnectivityIds"][part])
        first, start = int(steps["CellOffsets"][step, k]), int(steps["ConnectivityIdOffsets"][step, k])
        offsets = group["Offsets"][first:first + count + 1]
        connectivity = group["Connectivity"][start:start + ids]
        cells += [connectivity[a:b] for a, b in zip(offsets[:-1], offsets[1:])]
        total += count
    arrays = [{k: group[k][int(steps[f"{kind}Offsets/{k}"][step]):][:rows] for k in group}
              for kind, rows, group in (("PointData", n, block["PointData"]), ("CellData", total, block["CellData"]))]
    return block["Points"][at:at + n], np.array(cells), *arrays


def of_vtk(data):
    from vtk.util.numpy_support import vtk_to_numpy
    cells = []
    for k in range(data.GetNumberOfCells()):
        ids = data.GetCell(k).GetPointIds()
        cells.append([ids.GetId(i) for i in range(ids.GetNumberOfIds())])
    arrays = [{a.GetArrayName(k): vtk_to_numpy(a.GetArray(k)) for k in range(a.GetNumberOfArrays())}
              for a in (data.GetPointData(), data.GetCellData())]
    points = vtk_to_numpy(data.GetPoints().GetData()).copy() if data.GetNumberOfPoints() else np.empty((0, 3), "f4")
    return points, np.array(cells), *arrays


def compare(expected, found, what):
    """Arrays that are equal in type and bits; anything else ends the program."""
    def equal(name, a, b):
        if a.size == 0 and b.size == 0:
            return
        if a.dtype.kind != b.dtype.kind or a.dtype.itemsize != b.dtype.itemsize or not np.array_equal(a, b.reshape(a.shape)):
            sys.exit(f"{what}: {name} differs")

    equal("points", expected[0], found[0])
    if expected[1].size and not np.array_equal(expected[1], found[1]):
        sys.exit(f"{what}: cells differ")
    count = 2
    for kind, a, b in zip(("points", "cells"), expected[2:], found[2:]):
        if a.keys() != b.keys():
            sys.exit(f"{what}: arrays on {kind}: {sorted(a)} and {sorted(b)}")
        for name in a:
            equal(name, a[name], b[name])
            count += 1
    return count


def vtk_steps(path):
    """Per step: time, polygonal data."""
    from vtk import vtkHDFReader, vtkStreamingDemandDrivenPipeline as pipeline
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    for time in reader.GetOutputInformation(0).Get(pipeline.TIME_STEPS()) or [None]:
        if time is None:
            reader.Update()
        else:
            reader.UpdateTimeStep(time)
        data = reader.GetOutputDataObject(0)
        yield time, data if data.IsA("vtkPolyData") else data.GetPartition(0)


folder = pathlib.Path(sys.argv[1])
run = h5py.File(folder / "run.h5")
frames = list(frames_of(run))
files = {path.stem: path for path in (folder / "vtkhdf").glob("*.vtkhdf")}
assert set(files) == set(frames[0][1]), (set(files), set(frames[0][1]))
count = 0
for name, path in files.items():
    root = h5py.File(path)["VTKHDF"]
    assert root.attrs["Type"] == b"PolyData" and list(root.attrs["Version"]) == [2, 0]
    for step, (time, blocks) in enumerate(frames):
        assert root["Steps/Values"][step] == time
        count += compare(blocks[name], by_the_specification(root, step), f"specification, step {step}, {name}")
print("specification", count)
try:
    from vtk import vtkVersion
    if (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) < (9, 3):
        sys.exit(0)
except ImportError:
    sys.exit(0)
count = 0
for name, path in files.items():
    for (time, blocks), (read, found) in zip(frames, vtk_steps(path), strict=True):
        assert read is None or read == time
        count += compare(blocks[name], of_vtk(found), f"VTK, {time} s, {name}")
print("VTK", count)
