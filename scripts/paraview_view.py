#!/usr/bin/env pvbatch
"""Opens a run of subsoil in ParaView: spheres with their true radius coloured by speed, the tool's surfaces as solids,
bodies without surfaces as outlines, joints as dots.

    pvbatch scripts/paraview_view.py DIR --out view.png     # a picture, without a screen (software rendering will do)
    pvpython -i scripts/paraview_view.py DIR                # the same view to look around in

    --frame last | K | TIME   K counts from 0 (-1 is the last); a number with a point or an s is a time: 1.5, 2s
    --cut                     leaves away the soil on the near side (z > 0), so that the tool in the soil is seen
    --by NAME                 colours by a number of the spheres other than speed, from none to the most: bonds, ...;
                              by material: a colour for each
    --speed MAX               upper end of the colours, m/s (default: what 99.5 % of the spheres stay below)
    --focus NAME              surface to look at (default: the deepest, container, floor and walls aside)
    --hide NAME               surface not to draw, may be given several times
    --walls                   draw the container's floor and walls too
    --from X Y Z              direction from which to look (default: 0.75 0.55 1.2, from ahead, above and aside; without
                              soil 0.3 0.25 1, of outlines alone 0 0 1)
    --movie FILE              all frames: film.mp4 or film.webm (by ffmpeg), or film.png, which becomes film.0000.png ...
                              (modes go once around, one after another)
    --rate N                  frames of the film per second (default: 25)
    --zoom FACTOR             nearer (default: 1)
    --size WIDTHxHEIGHT       pixels (default: 1600x900)
"""
import argparse
import math
import os
import shutil
import subprocess
import sys
import tempfile

from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy

# A programmable filter puts numpy-like functions over the built-in ones of this file while it runs.
lowest, highest, rising = min, max, sorted
SURROUNDINGS = ("container", "floor", "wall", "bin", "box")
LEGEND = 0.13  # of the picture's width, at the right, that the scene is kept out of

# Blocks are told by their name; the reader appends the frame's number to it ("soil[12]"). The soil of many processes is a
# block of blocks, to which the reader gives no name. As a filter of the pipeline it follows the time slider.
SELECT = """
import numpy
import vtkmodules.vtkCommonDataModel as model
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.util.numpy_support import vtk_to_numpy, numpy_to_vtk

blocks, output = self.GetInputDataObject(0, 0), self.GetOutputDataObject(0)
parts = vtkAppendPolyData()
named = []
for i in range(blocks.GetNumberOfBlocks()):
    block, name = blocks.GetBlock(i), blocks.GetMetaData(i).Get(model.vtkCompositeDataSet.NAME())
    name = (name or 'soil').split('[')[0]
    if isinstance(block, model.vtkMultiBlockDataSet):
        for k in range(block.GetNumberOfBlocks()):
            named.append((block.GetBlock(k), name))
    else:
        named.append((block, name))
for block, name in named:
    if block is None or not ({test}):
        continue
    geometry = vtkGeometryFilter()
    geometry.SetInputData(block)
    geometry.Update()
    data = geometry.GetOutput()
    if name == 'soil' and data.GetNumberOfPoints():
        x = vtk_to_numpy(data.GetPoints().GetData())
        velocity = data.GetPointData().GetArray('velocity')
        keep = numpy.flatnonzero({keep})
        cut = model.vtkPolyData()
        points = data.GetPoints().NewInstance()
        points.SetData(numpy_to_vtk(numpy.ascontiguousarray(x[keep]), deep=1))
        cut.SetPoints(points)
        cells = model.vtkCellArray()
        for k in range(len(keep)):
            cells.InsertNextCell(1, [k])
        cut.SetVerts(cells)
        def add(values, called):
            array = numpy_to_vtk(numpy.ascontiguousarray(values), deep=1)
            array.SetName(called)
            cut.GetPointData().AddArray(array)
        add(vtk_to_numpy(data.GetPointData().GetArray('radius'))[keep].astype('f8'), 'radius')
        speed = numpy.zeros(len(x)) if velocity is None else numpy.linalg.norm(vtk_to_numpy(velocity), axis=1)
        add(speed[keep], 'speed')
        other = data.GetPointData().GetArray('{by}')
        if other is not None:
            add(vtk_to_numpy(other)[keep].astype('f8'), '{by}')
        data = cut
    else:
        data.GetPointData().Initialize()
    parts.AddInputData(data)
parts.Update()
output.ShallowCopy(parts.GetOutput())
"""


def read_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run")
    parser.add_argument("--frame", default="last")
    parser.add_argument("--cut", action="store_true")
    parser.add_argument("--by", default="speed")
    parser.add_argument("--speed", type=float)
    parser.add_argument("--focus")
    parser.add_argument("--hide", action="append")
    parser.add_argument("--walls", action="store_true")
    parser.add_argument("--from", dest="direction", type=float, nargs=3)
    parser.add_argument("--movie")
    parser.add_argument("--rate", type=float, default=25)
    parser.add_argument("--zoom", type=float, default=1.0)
    parser.add_argument("--size", default="1600x900")
    parser.add_argument("--out")
    arguments = parser.parse_args()
    arguments.size = [int(n) for n in arguments.size.split("x")]
    arguments.hide = arguments.hide if arguments.hide is not None else ["container"]
    if is_film(arguments.movie) and not shutil.which("ffmpeg"):
        sys.exit(f"--movie {arguments.movie}: ffmpeg makes it, and is not installed: scripts/setup --pictures; "
                 "--movie film.png leaves a picture of every frame")
    return arguments


def is_film(path):
    return path is not None and path.lower().endswith((".mp4", ".webm"))


def need_a_screen():
    """Debian's ParaView draws through X only; without a screen it dies inside X. Xvfb is a screen in memory."""
    if os.environ.get("DISPLAY") or sys.platform != "linux":
        return
    if not shutil.which("xvfb-run"):
        sys.exit("there is no screen (DISPLAY is not set); install a virtual one: apt-get install xvfb xauth")
    os.execvp("xvfb-run", ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24", "pvbatch", *sys.argv])


def open_run(directory):
    path = os.path.join(directory, "run.xdmf")
    if not os.path.exists(path):
        sys.exit(f"{directory} holds no run.xdmf: is it the result directory of a run with frames?")
    reader = simple.Xdmf3ReaderT(FileName=[path])
    reader.UpdatePipeline()
    return reader


def times_of(reader):
    """A run of one frame has a number here, not a list of one."""
    times = reader.TimestepValues
    return [times] if isinstance(times, float) else list(times)


def time_of(frame, times):
    """Last, by number or by time: the nearest frame there is."""
    if frame == "last":
        return times[-1]
    if "." in frame or frame.endswith("s"):
        wanted = float(frame.rstrip("s"))
        return lowest(times, key=lambda t: math.fabs(t - wanted))
    if not -len(times) <= int(frame) < len(times):
        sys.exit(f"--frame {frame}: the run has {len(times)} frames, 0 to {len(times) - 1}")
    return times[int(frame)]


def block_names(reader):
    blocks = servermanager.Fetch(reader)
    name = blocks.NAME()
    return [(blocks.GetMetaData(i).Get(name) or "soil").split("[")[0] for i in range(blocks.GetNumberOfBlocks())]


def pick_blocks(reader, names, cut=False, by="speed"):
    """The blocks of these names as one data set; of the soil, radius, speed and what to colour by."""
    keep = "x[:, 2] <= 0" if cut else "x[:, 0] == x[:, 0]"
    part = simple.ProgrammableFilter(Input=reader, OutputDataSetType="vtkPolyData")
    part.Script = SELECT.replace("{test}", f"name in {names!r}").replace("{keep}", keep).replace("{by}", by)
    return part


def colour_by_material(display, view):
    """One colour per number, of soils: light, dark, red, green, blue, sand; then from the start."""
    simple.ColorBy(display, ("POINTS", "material"))
    colours = simple.GetColorTransferFunction("material")
    kinds = [(0.80, 0.64, 0.42), (0.36, 0.26, 0.20), (0.68, 0.30, 0.20), (0.45, 0.52, 0.30), (0.36, 0.47, 0.58),
             (0.93, 0.86, 0.66)]
    colours.ColorSpace = "Step"
    colours.RGBPoints = [value for i in range(24) for value in (i + 0.5, *kinds[i % len(kinds)])]  # up to there
    display.SetScalarBarVisibility(view, False)


def show_soil(soil, view, by, top):
    display = simple.Show(soil, view)
    display.SetRepresentationType("3D Glyphs")
    display.GlyphType = "Sphere"
    display.GlyphType.Radius = 1.0
    display.GlyphType.ThetaResolution = 12
    display.GlyphType.PhiResolution = 8
    display.Scaling = 1
    display.ScaleMode = "Magnitude"
    display.SelectScaleArray = "radius"
    display.ScaleFactor = 1.0
    display.Orient = 0
    if by == "material":
        colour_by_material(display, view)
        return
    simple.ColorBy(display, ("POINTS", by))
    colours = simple.GetColorTransferFunction(by)
    # Resting soil looks like soil; what moves stands out.
    colours.ColorSpace = "Lab"
    stops = [(0.00, 0.55, 0.45, 0.36), (0.25, 0.76, 0.58, 0.36), (0.50, 0.95, 0.72, 0.28), (0.75, 0.96, 0.45, 0.16),
             (1.00, 0.80, 0.09, 0.11)]
    colours.RGBPoints = [value for x, *rgb in stops for value in (x * top, *rgb)]
    bar = simple.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = "speed [m/s]" if by == "speed" else by, ""
    bar.TitleColor = bar.LabelColor = [0.1, 0.1, 0.1]
    bar.TitleFontSize, bar.LabelFontSize = 18, 16
    bar.ScalarBarLength, bar.ScalarBarThickness = 0.35, 16
    bar.WindowLocation = "Any Location"
    bar.Position = [1 - LEGEND + 0.015, 0.325]
    bar.LabelFormat = bar.RangeLabelFormat = "%.2g"
    bar.AutomaticLabelFormat = 0
    display.SetScalarBarVisibility(view, True)


def show_solid(surfaces, view):
    display = simple.Show(surfaces, view)
    display.SetRepresentationType("Surface")
    simple.ColorBy(display, ("POINTS", ""))
    display.DiffuseColor = [0.55, 0.66, 0.76]
    display.Specular, display.SpecularPower = 0.5, 30
    display.Interpolation = "Flat"  # edges of steel are sharp


def show_plain(part, view, representation, colour):
    display = simple.Show(part, view)
    display.SetRepresentationType(representation)
    simple.ColorBy(display, ("POINTS", ""))
    display.AmbientColor = display.DiffuseColor = colour
    return display


def show_lines(lines, view):
    """Outlines of bodies, springs and links."""
    display = show_plain(lines, view, "Surface", [0.05, 0.36, 0.60])
    display.LineWidth, display.RenderLinesAsTubes = 4, 1


def show_dots(dots, view):
    """Joints and markers."""
    display = show_plain(dots, view, "Points", [0.15, 0.15, 0.15])
    display.PointSize, display.RenderPointsAsSpheres = 11, 1


def upper_end(soil, by):
    data = servermanager.Fetch(soil)
    if data.GetNumberOfPoints() == 0:
        return 1.0
    array = data.GetPointData().GetArray(by)
    if array is None:
        sys.exit(f"--by {by}: the spheres have no such number in this frame")
    values = rising(vtk_to_numpy(array))
    return highest(float(values[int(0.995 * (len(values) - 1))]), 1e-6)


def deepest(reader, names, time):
    """The surface that reaches lowest: of a machine, what works in the soil."""
    parts = [pick_blocks(reader, [name]) for name in names]
    for part in parts:
        part.UpdatePipeline(time)
    return lowest(parts, key=lambda part: part.GetDataInformation().GetBounds()[2])


def place_flat_camera(view, bounds, direction, zoom):
    """Looks at the whole machine without perspective, so that lengths compare."""
    at = [(bounds[2 * i] + bounds[2 * i + 1]) / 2 for i in range(3)]
    width, height = bounds[1] - bounds[0], bounds[3] - bounds[2]
    length, distance = math.hypot(*direction), 10 * highest(width, height, 1e-6)
    view.CameraParallelProjection = 1
    view.CameraParallelScale = 0.58 * highest(height, width * view.ViewSize[1] / view.ViewSize[0], 1e-6) / zoom
    view.CameraFocalPoint = at
    view.CameraPosition = [a + distance * d / length for a, d in zip(at, direction)]
    view.CameraViewUp = [0, 1, 0]


def swept_bounds(part, times):
    """Bounds over all frames, so that nothing leaves a film."""
    swept = []
    for time in times:
        part.UpdatePipeline(time)
        swept.append(part.GetDataInformation().GetBounds())
    return [(lowest if i % 2 == 0 else highest)(b[i] for b in swept) for i in range(6)]


def box_of_most(soil):
    """The soil without what has flown off: per axis from where 1 % of the spheres lie below to where 1 % lie above."""
    data = servermanager.Fetch(soil)
    count = data.GetNumberOfPoints()
    if count == 0:
        return None
    x = vtk_to_numpy(data.GetPoints().GetData())
    bounds = []
    for axis in range(3):
        values = rising(x[:, axis])
        bounds += [float(values[int(0.01 * (count - 1))]), float(values[int(0.99 * (count - 1))])]
    return bounds


def scene_of(tool, soil):
    """Tool and the soil around it: as far as the tool is long, not the whole bin."""
    if soil is None or tool is None:
        return tool or soil
    reach = math.dist(tool[0::2], tool[1::2])
    near = [highest(soil[2 * i], tool[2 * i] - reach) if k == 0 else lowest(soil[2 * i + 1], tool[2 * i + 1] + reach)
            for i in range(3) for k in range(2)]
    near = [n if near[2 * (i // 2)] <= near[2 * (i // 2) + 1] else s for i, (n, s) in enumerate(zip(near, soil))]
    return [(lowest if i % 2 == 0 else highest)(n, t) for i, (n, t) in enumerate(zip(near, tool))]


def vector_product(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit_vector(a):
    length = math.hypot(*a)
    return [c / length for c in a]


def place_camera(view, box, direction, zoom):
    """Fits the box into the picture left of the legend, seen from `direction` with y up."""
    back = unit_vector(direction)
    right = unit_vector(vector_product([0, 1, 0], back))
    up = vector_product(back, right)
    corners = [[box[i], box[2 + j], box[4 + k]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    at = [math.fsum(c[i] for c in corners) / 8 for i in range(3)]

    def dot(a, b):
        return math.fsum(p * q for p, q in zip(a, b))

    tall = 0.92 * math.tan(math.radians(15))  # half the picture at distance 1, with a margin
    wide = tall * view.ViewSize[0] / view.ViewSize[1] * (1 - LEGEND)
    distance = 0
    for corner in corners:
        d = [p - q for p, q in zip(corner, at)]
        distance = highest(distance, math.fabs(dot(d, right)) / wide + dot(d, back), math.fabs(dot(d, up)) / tall + dot(d, back))
    distance /= zoom
    aside = LEGEND * distance * math.tan(math.radians(15)) * view.ViewSize[0] / view.ViewSize[1]
    view.CameraFocalPoint = [a + aside * r for a, r in zip(at, right)]
    view.CameraPosition = [f + distance * b for f, b in zip(view.CameraFocalPoint, back)]
    view.CameraViewUp = [0, 1, 0]
    view.CameraViewAngle = 30


class Kinds:
    """The blocks of a run by how they are drawn."""

    def __init__(self, names, hide, walls):
        kept = [n for n in names if n not in hide and (walls or not (n == "floor" or n.startswith("wall ")))]
        self.soil = "soil" in names
        self.lines = [n for n in kept if n.endswith(" outline") or n == "machine links"]
        self.dots = [n for n in kept if n in ("machine joints", "machine markers")]
        self.solids = [n for n in kept if n != "soil" and n not in self.lines and n not in self.dots]
        self.machine = [n for n in kept if n != "soil"]


def make_view(size, time):
    simple._DisableFirstRenderCameraReset()
    view = simple.CreateView("RenderView")
    view.ViewSize = size
    view.ViewTime = time
    view.UseColorPaletteForBackground = 0
    view.BackgroundColorMode = "Gradient"
    view.Background, view.Background2 = [0.93, 0.94, 0.95], [1, 1, 1]
    view.OrientationAxesVisibility = 1
    view.OrientationAxesLabelColor = [0.1, 0.1, 0.1]
    simple.SetActiveView(view)
    return view


def show_all(reader, kinds, view, time, arguments):
    """Returns the soil's part, or None."""
    soil = None
    if kinds.soil:
        soil = pick_blocks(reader, ["soil"], arguments.cut, arguments.by)
        soil.UpdatePipeline(time)
        show_soil(soil, view, arguments.by, arguments.speed or upper_end(soil, arguments.by))
    for names, show in ((kinds.solids, show_solid), (kinds.lines, show_lines), (kinds.dots, show_dots)):
        if names:
            show(pick_blocks(reader, names), view)
    label = simple.AnnotateTimeFilter(Input=reader, Format="t = {time:.3f} s")
    shown = simple.Show(label, view)
    shown.Color, shown.FontSize, shown.WindowLocation = [0.1, 0.1, 0.1], 20, "Upper Left Corner"
    return soil


def aim(view, reader, kinds, soil, times, arguments):
    if soil is None:
        machine = pick_blocks(reader, kinds.machine)
        bounds = swept_bounds(machine, times if arguments.movie else [view.ViewTime])
        # Solids that are looked at straight on run together; outlines are best seen so.
        straight = (0.3, 0.25, 1) if kinds.solids else (0, 0, 1)
        place_flat_camera(view, bounds, arguments.direction or straight, arguments.zoom)
        return
    tools = [arguments.focus] if arguments.focus else [
        n for n in kinds.solids if not any(word in n.lower() for word in SURROUNDINGS)]
    focus = None
    if tools:
        tool = deepest(reader, tools, view.ViewTime)
        focus = swept_bounds(tool, times) if arguments.movie else tool.GetDataInformation().GetBounds()
    box = scene_of(focus, box_of_most(soil))
    place_camera(view, box, arguments.direction or (0.75, 0.55, 1.2), arguments.zoom)


def save_film(path, view, size, rate):
    """ffmpeg joins a picture of every frame; libx264 and libvpx want even sizes, players the pixel format."""
    codec = ["-c:v", "libx264", "-crf", "20"] if path.lower().endswith(".mp4") else ["-c:v", "libvpx-vp9", "-crf", "32", "-b:v", "0"]
    with tempfile.TemporaryDirectory() as folder:
        simple.SaveAnimation(os.path.join(folder, "f.png"), view, ImageResolution=[n - n % 2 for n in size])
        subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-framerate", str(rate), "-i", os.path.join(folder, "f.%04d.png"),
                        *codec, "-pix_fmt", "yuv420p", path], check=True)


def main():
    arguments = read_arguments()
    need_a_screen()
    reader = open_run(arguments.run)
    times = times_of(reader)
    time = time_of(arguments.frame, times)
    reader.UpdatePipeline(time)
    names = block_names(reader)
    if arguments.focus and arguments.focus not in names:
        sys.exit(f"--focus {arguments.focus}: the run has {', '.join(names)}")
    kinds = Kinds(names, arguments.hide, arguments.walls)
    view = make_view(arguments.size, time)
    soil = show_all(reader, kinds, view, time, arguments)
    aim(view, reader, kinds, soil, times, arguments)
    simple.Render(view)
    if arguments.out:
        simple.SaveScreenshot(arguments.out, view, ImageResolution=arguments.size)
        print(f"{arguments.out}: t = {time:.6g} s, {len(times)} frames in the run")
    if arguments.movie:
        simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
        if is_film(arguments.movie):
            save_film(arguments.movie, view, arguments.size, arguments.rate)
        else:
            simple.SaveAnimation(arguments.movie, view, ImageResolution=arguments.size)
        print(f"{arguments.movie}: {len(times)} frames")


main()
