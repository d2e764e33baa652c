"""Comparison of two runs column by column, and the sensitivity that says what difference rounding alone makes."""
import numpy

# Columns that are components of one world vector: suffixes of x, y and z.
VECTORS = [(".x", ".y", ".z"), (".vx", ".vy", None), (".ax", ".ay", None), (".fx", ".fy", None), (".Fx", ".Fy", ".Fz")]
AXIAL = [(".Mx", ".My", ".Mz")]


def bits(first, second, skip=()):
    """Columns of two tables that differ in a bit; both must have the same rows."""
    differing = []
    for name in first:
        if name in skip or name not in second:
            continue
        a, b = first[name], second[name]
        if a.shape != b.shape:
            return [f"{name}: {len(a)} rows against {len(b)}"]
        same = (a == b) | (numpy.isnan(a) & numpy.isnan(b))
        if not same.all():
            k = int(numpy.argmin(same))
            differing.append(f"{name}: row {k}: {a[k]!r} against {b[k]!r}")
    return differing


def common_rows(first, second):
    """Both tables cut to the times that they share."""
    times, i, j = numpy.intersect1d(first["time"], second["time"], return_indices=True)
    return {k: v[i] for k, v in first.items()}, {k: v[j] for k, v in second.items()}


def size_of(values):
    finite = values[numpy.isfinite(values)]
    return float(numpy.abs(finite).max()) if finite.size else 0.0


def back(table, view):
    """A table of the run in `view`, in the world of the run without it."""
    reverse = {new: old for old, new in view.names.items()}
    answer = {wall_back(renamed(name, reverse), view): values for name, values in table.items()}
    if any(view.shift):
        for base in {name[:-3] for name in answer if name.endswith(".Mx")}:
            if base == "floor" or base.startswith("wall "):  # their moments are about the world's origin
                f = [answer[f"{base}.F{axis}"] for axis in "xyz"]
                for k, axis in enumerate("xyz"):
                    i, j = (k + 1) % 3, (k + 2) % 3
                    answer[f"{base}.M{axis}"] = answer[f"{base}.M{axis}"] - (view.shift[i] * f[j] - view.shift[j] * f[i])
        for axis, shift in zip("xyz", view.shift):
            for name in list(answer):
                if name.endswith("." + axis) and is_place(name, answer):
                    answer[name] = answer[name] - shift
    if view.angle or view.mirror_x or view.mirror_z:
        answer = turned_back(answer, view)
    return answer


def wall_back(column, view):
    """`wall +x` of a mirrored world is `wall -x` of the other one; the floor is the wall at -y."""
    base, dot, suffix = column.rpartition(".")
    faces = {"floor": "-y", **{f"wall {s}{a}": f"{s}{a}" for s in "+-" for a in "xyz"}}
    if base not in faces:
        return column
    sign, axis = faces[base]
    v = [0.0, 0.0, 0.0]
    v["xyz".index(axis)] = -1.0 if sign == "-" else 1.0
    c, s = numpy.cos(view.angle), numpy.sin(view.angle)
    x, y = c * v[0] + s * v[1], c * v[1] - s * v[0]
    v = [-x if view.mirror_x else x, y, -v[2] if view.mirror_z else v[2]]
    k = int(numpy.argmax(numpy.abs(v)))
    face = ("-" if v[k] < 0 else "+") + "xyz"[k]
    return ("floor" if face == "-y" else f"wall {face}") + dot + suffix


def is_place(name, table):
    """Bodies (they have an angle) and boundaries on a path (they have z) have places."""
    base = name.rsplit(".", 1)[0]
    return f"{base}.angle" in table or f"{base}.z" in table


def renamed(column, reverse):
    """Names of the scenario are words of the column's name, before its last dot or inside a measure's own name."""
    for new in sorted(reverse, key=len, reverse=True):
        if column == new or column.startswith((new + ".", new + " ")):
            return reverse[new] + column[len(new):]
    return column


def turned_back(table, view):
    answer = dict(table)
    c, s = numpy.cos(view.angle), numpy.sin(view.angle)
    flip = -1.0 if view.mirror_x else 1.0
    mirror = -1.0 if view.mirror_z else 1.0
    for family, axial in [(v, False) for v in VECTORS] + [(v, True) for v in AXIAL]:
        for name in table:
            if not name.endswith(family[0]):
                continue
            base = name[:-len(family[0])]
            other = base + family[1]
            if other not in table:
                continue
            x, y = table[name], table[other]
            x, y = c * x + s * y, c * y - s * x
            x = flip * x
            sign = flip * mirror if axial else 1.0
            answer[name], answer[other] = sign * x, sign * y
            if family[2] and base + family[2] in table:
                z = mirror * table[base + family[2]]
                answer[base + family[2]] = sign * z
    return answer


def in_vector(name, table):
    for family in VECTORS + AXIAL:
        for k, suffix in enumerate(family):
            if suffix and name.endswith(suffix):
                base = name[:-len(suffix)]
                if base + family[0] in table and base + family[1] in table:
                    return True
    return False


# Least size of a unit: of bodies that do not turn, angles and moments are rounding, some 1e-15, and so are speeds of one
# at rest. Its acceleration is what forces of some N leave unbalanced: coordinates of 1 km are rounded to 1e-13 m. The
# power is that of a damper of 1 N m s at a speed that the integrator's tolerance leaves of 10 rad/s.
LEAST = {"rad": 1e-8, "rad/s": 1e-8, "rad/s^2": 1e-3, "N": 1e-6, "N m": 1e-6, "m/s": 1e-8, "m/s^2": 1e-3, "W": 1e-10}


# Of a mirrored run these keep their sign.
EVEN_UNITS = {"J", "W", "kg"}
EVEN = {"soil.draft", "soil.lift"}


def scales(table, units):
    """Size against which a difference in a column counts: the largest value of its unit among columns of the same owner's
    kind (all columns of one unit), since a component that is 0 by symmetry has no size of its own."""
    by_unit = {}
    for name, values in table.items():
        by_unit[units.get(name)] = max(by_unit.get(units.get(name), 0.0), size_of(values))
    return {name: max(by_unit[units.get(name)], LEAST.get(units.get(name), 0.0)) for name in table}


def differences(first, second, units, view=None, shape_only=(), whole=None):
    """Largest difference of every column as a share of the size of its unit: {name: share}.

    Under rotation a column that is no component of a world vector keeps its value; under a mirror it keeps it or changes
    its sign, the same in all rows, unless it is known to keep it. Energies that count from a height are compared as changes.
    Where `first` is a part of the rows of a run, `whole` has all of them, and sizes are theirs.
    """
    sizes = scales(whole or first, units)
    answer = {}
    mirrored = view is not None and (view.mirror_x or view.mirror_z)
    for name, a in first.items():
        if name not in second or name in shape_only or name.endswith(".stress at"):  # of two like stresses rounding chooses
            continue
        b = second[name]
        if a.shape != b.shape:
            answer[name] = float("inf")
            continue
        if name in ("energy.potential", "soil.gravity", "energy.force work") or name.endswith(".potential"):
            a, b = a - a[:1], b - b[:1]
        elif name.endswith((".angle", ".turn")) and view is not None and (view.angle or view.mirror_x):
            a, b = a - a[:1], b - b[:1]
        size = sizes[name] or 1.0
        apart = spread(apart_of(a, b))
        if mirrored and not in_vector(name, first) and name not in EVEN and units.get(name) not in EVEN_UNITS:
            apart = min(apart, spread(apart_of(a, -b)))
        answer[name] = apart / size
    return answer


def spread(values):
    """Largest absolute value; infinite where one is no number."""
    if values.size == 0:
        return 0.0
    return float(numpy.abs(values).max()) if numpy.isfinite(values).all() else float("inf")


def apart_of(a, b):
    """Difference of two columns; values that are no numbers must be so in both."""
    none = numpy.isnan(a) & numpy.isnan(b)
    return numpy.where(none, 0.0, a - b)
