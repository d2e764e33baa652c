"""A scenario as a tree whose leaves know how they transform: translation, rotation in the plane, mirror in x and in z.

Leaves stay in SI units. `render(tree, View(...))` makes plain values for YAML of them, in the view's frame, names and units.
"""
import dataclasses
import math

# Kinds of a quantity under a transformation of the world:
#   scalar     unchanged                         point      x -> R x + shift
#   direction  x -> R x (also velocities, g)     own        a point in a body's own axes: mirrored with the body
#   axial      angular velocity vector           turn       component about z: changes sign in a mirror
#   attitude   angle of a body in the world      height     y of a point: no rotation
#   side       direction whose left is free      own x      component along a body's own x axis
#   bound      an end of a range of angles against the ground, `bound inside` between bodies: no mirror
#   extent     edge lengths of a box (with `corner` of Box), unchanged by mirrors
#   axes       between coordinates of the world: no rotation; `axes turn` changes sign in a mirror


class NotTransformable(Exception):
    """The scenario names an axis of the world (a driven coordinate, a height), which no rotation keeps."""


@dataclasses.dataclass(frozen=True)
class Quantity:
    values: tuple
    unit: str = ""
    kind: str = "scalar"


@dataclasses.dataclass(frozen=True)
class Name:
    """A name that the scenario gives itself, with a suffix such as `.x`."""
    text: str
    suffix: str = ""


@dataclasses.dataclass(frozen=True)
class Text:
    """A text with names in it, such as a formula of measures."""
    parts: tuple


@dataclasses.dataclass(frozen=True)
class Box:
    """Region with edges along the axes: renders as the mapping {size, at}."""
    size: tuple
    at: tuple


@dataclasses.dataclass(frozen=True)
class Faces:
    faces: tuple


@dataclasses.dataclass(frozen=True)
class Profile:
    """Polar outline in a body's own axes, those of the ground being the world's: rows of (angle in deg, radius in m), once around."""
    rows: tuple
    of_ground: bool = False


@dataclasses.dataclass(frozen=True)
class Function:
    """A function of time (`function` of the declarations) or a characteristic: type -> keys.

    Under a mirror the value changes sign where `sign` is `turn` or `x`, the argument of a characteristic likewise where
    `odd` is set. `powers` says of each key by which powers of value and argument it scales.
    """
    type: str
    keys: tuple          # of (key, value): Quantity, rows of numbers, or text
    powers: tuple        # of (key, power of the value, power of the argument)
    unit: str = ""
    kind: str = "scalar"  # scalar, turn, x, y, height, attitude
    odd: bool = False    # characteristic of an angle: argument changes sign too


@dataclasses.dataclass(frozen=True)
class Pair:
    """Two functions of time that are the components of a world vector: renders as two keys."""
    x: tuple             # (key, Function)
    y: tuple


@dataclasses.dataclass
class View:
    """Frame in which a scenario is written: rotation angle, mirrors, shift, names, units, order of named mappings."""
    angle: float = 0.0
    mirror_x: bool = False
    mirror_z: bool = False
    shift: tuple = (0.0, 0.0, 0.0)
    names: dict = dataclasses.field(default_factory=dict)
    shuffle: object = None   # random.Random: order of named mappings
    units: object = None     # random.Random: units rewritten

    @property
    def determinant(self):
        return -1.0 if self.mirror_x else 1.0

    def turned(self, v):
        x, y = v[0], v[1]
        if self.mirror_x:
            x = -x
        if self.angle:
            c, s = math.cos(self.angle), math.sin(self.angle)
            if abs(c) < 1e-15:
                c = 0.0
            x, y = c * x - s * y, s * x + c * y
        rest = tuple(-z for z in v[2:]) if self.mirror_z else tuple(v[2:])
        return (x, y, *rest)

    def name(self, text):
        return self.names.get(text, text)


UNITS = {  # exact decimal factors only: the value is written so that it reads back to the same real number
    "m": [("mm", 3), ("cm", 2), ("m", 0)], "kg": [("g", 3), ("t", -3)], "N/m": [("kN/m", -3), ("N/mm", -3)], "s": [("ms", 3)],
    "N": [("kN", -3)], "Pa": [("kPa", -3), ("MPa", -6)], "m/s": [("mm/s", 3), ("cm/s", 2)], "kg/m^3": [("g/cm^3", -3)],
    "N m": [("kN m", -3)], "N s/m": [("kN s/m", -3)], "Hz": [("kHz", -3)], "m/s^2": [("mm/s^2", 3)],
}


def number(value):
    if isinstance(value, int):
        return str(value)
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text


def shifted(value, places):
    """The decimal number with its point moved: exact, no rounding of a product."""
    text = number(value)
    mantissa, _, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent or 0) + places}"


def text_of(values, unit, view):
    if view.units and unit in UNITS:
        other, places = view.units.choice(UNITS[unit])
        return " ".join(shifted(v, places) for v in values) + " " + other
    text = " ".join(number(v) for v in values)
    return f"{text} {unit}".strip()


def in_view(q, view):
    v = q.values
    if q.kind == "point":
        turned = view.turned(v)
        return tuple(a + b for a, b in zip(turned, view.shift)) if any(view.shift) else turned
    if q.kind == "direction":
        return view.turned(v)
    if q.kind == "own":
        return (-v[0] if view.mirror_x else v[0], v[1], *((-z for z in v[2:]) if view.mirror_z else v[2:]))
    if q.kind == "side":  # a mirror exchanges left and right
        return tuple(view.determinant * x for x in view.turned(v))
    if q.kind == "own x":
        return tuple(view.determinant * x for x in v)
    if q.kind in ("bound", "bound inside"):
        if view.mirror_x:
            raise NotTransformable("one end of a range of angles")
        return tuple(x + view.angle for x in v) if q.kind == "bound" else v
    if q.kind == "axial":
        sign = view.determinant * (-1.0 if view.mirror_z else 1.0)
        return tuple(sign * x for x in view.turned(v))
    if q.kind == "turn":
        return tuple(view.determinant * x for x in v)
    if q.kind == "attitude":
        return tuple(view.determinant * x + view.angle for x in v)
    if q.kind in ("axes", "axes turn"):
        if view.angle:
            raise NotTransformable("a coordinate that follows another")
        return tuple(view.determinant * x for x in v) if q.kind == "axes turn" else v
    if q.kind == "height":
        if view.angle:
            raise NotTransformable("a height")
        return tuple(x + view.shift[1] for x in v)
    return v


def box_in_view(box, view):
    low = view.turned(box.at)
    high = view.turned(tuple(a + s for a, s in zip(box.at, box.size)))
    if view.angle and min(abs(math.cos(view.angle)), abs(math.sin(view.angle))) > 1e-12:
        raise NotTransformable("a box along the axes")
    corner = tuple(min(a, b) + s for a, b, s in zip(low, high, view.shift))
    turned = view.turned(box.size)
    return {"size": text_of(tuple(abs(s) for s in turned), "m", view), "at": text_of(corner, "m", view)}


def profile_in_view(profile, view):
    rows = [(180.0 - a, r) for a, r in reversed(profile.rows)] if view.mirror_x else profile.rows
    turn = math.degrees(view.angle) if profile.of_ground else 0.0
    return [[f"{number(a + turn) if turn else f'{a:.6g}'} deg", f"{r:.9g} m"] for a, r in rows]


def faces_in_view(faces, view):
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    answer = []
    for face in faces.faces:
        sign = -1.0 if face[0] == "-" else 1.0
        v = view.turned(tuple(sign * c for c in axes[face[-1]]))
        k = max(range(3), key=lambda i: abs(v[i]))
        answer.append(("" if len(face) == 1 else "-" if v[k] < 0 else "+") + "xyz"[k])
    return answer


def scaled_function(f, view, factor):
    """The mapping {type: keys}; factor multiplies the value, for components of a rotated vector."""
    sign = view.determinant if f.kind in ("turn", "x", "own x", "place x", "attitude") else 1.0
    argument = view.determinant if f.odd else 1.0
    keys = {}
    powers = {key: (p, q) for key, p, q in f.powers}
    for key, value in f.keys:
        p, q = powers.get(key, (0, 0))
        scale = (sign * factor) ** p * argument ** q
        if isinstance(value, Quantity):
            keys[key] = text_of(tuple(scale * x for x in value.values), value.unit, view)
        elif isinstance(value, (list, tuple)):  # rows of (argument, value)
            rows = [(argument * a, sign * factor * b) for a, b in value]
            rows.sort()
            unit_a, unit_b = f.unit.split("|")
            keys[key] = [[text_of((a,), unit_a, view), text_of((b,), unit_b, view)] for a, b in rows]
        elif key == f.type:  # a formula
            keys[key] = value if sign * factor == 1.0 else f"({number(sign * factor)})*({value})"
        else:
            keys[key] = value
    if f.type in keys:
        return keys  # `expression: ..., unit: ...` stand beside each other
    return {f.type: keys}


def function_in_view(f, view):
    if f.kind in ("x", "y", "height", "place x", "place y") and view.angle:
        raise NotTransformable("a driven coordinate")
    rendered = scaled_function(f, view, 1.0)
    offset = {"place x": view.shift[0], "place y": view.shift[1], "height": view.shift[1], "attitude": view.angle}.get(f.kind, 0.0)
    if offset:
        unit = "rad" if f.kind == "attitude" else "m"
        return [rendered, {"constant": {"value": f"{number(offset)} {unit}"}}]
    return rendered


def pair_in_view(pair, view):
    (key_x, fx), (key_y, fy) = pair.x, pair.y
    ex, ey = view.turned((1.0, 0.0)), view.turned((0.0, 1.0))
    answer = {}
    for key, a, b in (key_x, ex[0], ey[0]), (key_y, ex[1], ey[1]):
        parts = [scaled_function(f, View(units=view.units), c) for f, c in ((fx, a), (fy, b)) if c]
        answer[key] = parts[0] if len(parts) == 1 else parts
    return answer


def render(node, view=None):
    """Plain values for YAML."""
    view = view or View()
    if isinstance(node, dict):
        items = list(node.items())
        if view.shuffle and items and all(isinstance(key, Name) for key, _ in items):
            view.shuffle.shuffle(items)
        answer = {}
        for key, value in items:
            if isinstance(value, Pair):
                answer.update(pair_in_view(value, view))
            elif isinstance(value, Box):
                answer.update(box_in_view(value, view))
            else:
                answer[view.name(key.text) if isinstance(key, Name) else key] = render(value, view)
        return answer
    if isinstance(node, list):
        return [render(one, view) for one in node]
    if isinstance(node, Quantity):
        values = in_view(node, view)
        if not node.unit and len(values) == 1:
            return values[0]
        return text_of(values, node.unit, view)
    if isinstance(node, Name):
        return view.name(node.text) + node.suffix
    if isinstance(node, Text):
        return "".join(render(part, view) if isinstance(part, Name) else part for part in node.parts)
    if isinstance(node, Faces):
        return faces_in_view(node, view)
    if isinstance(node, Function):
        return function_in_view(node, view)
    if isinstance(node, Profile):
        return profile_in_view(node, view)
    return node
