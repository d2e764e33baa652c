#!/usr/bin/env pvpython
"""Opens the results in a folder with ParaView's own reader and says what it finds, a line each:
BLOCK|points|cells|arrays of points|arrays of cells; last, how many readers would take the file.

    pvpython paraview_read.py FILE.xdmf
"""
import sys

from paraview import simple

reader = simple.XDMFReader(FileNames=[sys.argv[1]])
reader.UpdatePipelineInformation()
times = list(reader.TimestepValues) if reader.TimestepValues else [0.0]
print("times", len(times), times[-1])
reader.UpdatePipeline(times[-1])


def leaves(data, name):
    if data is None:
        return
    if hasattr(data, "GetNumberOfBlocks"):
        for i in range(data.GetNumberOfBlocks()):
            called = data.GetMetaData(i).Get(data.NAME()) if data.HasMetaData(i) else ""
            yield from leaves(data.GetBlock(i), called or name)
        return
    yield name, data


def arrays(of):
    return [f"{of.GetArrayName(i)}:{of.GetArray(i).GetNumberOfComponents()}" for i in range(of.GetNumberOfArrays())]


for name, data in leaves(simple.servermanager.Fetch(reader), "whole"):
    print("|".join([name.split("[")[0], str(data.GetNumberOfPoints()), str(data.GetNumberOfCells()),
                    ",".join(sorted(arrays(data.GetPointData()))), ",".join(sorted(arrays(data.GetCellData())))]))

# Where several readers know a file's name, ParaView asks which.
manager = simple.servermanager.vtkSMProxyManager.GetProxyManager()
factory = manager.GetReaderFactory()
factory.UpdateAvailableReaders()
known = factory.GetReaders(sys.argv[1], manager.GetActiveSession())
print("readers", known.GetNumberOfStrings() // 3)
