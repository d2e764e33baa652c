"""Reduces a scenario that violates a relation: takes entries away and makes numbers round while the violation stays."""
import copy

from geometry import Function, Quantity

KEPT = {"subsoil", "time", "end", "gravity", "output", "bodies", "mass", "inertia", "at", "container", "bed", "fill"}


def places(node, path=()):
    """Paths of all mapping entries and list items, the largest parts first."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield (*path, key)
            yield from places(value, (*path, key))
    elif isinstance(node, list):
        for k, value in enumerate(node):
            yield (*path, k)
            yield from places(value, (*path, k))


def at(node, path):
    for step in path:
        node = node[step]
    return node


def without(tree, path):
    answer = copy.deepcopy(tree)
    parent = at(answer, path[:-1])
    del parent[path[-1]]
    return answer


def replaced(tree, path, value):
    answer = copy.deepcopy(tree)
    at(answer, path[:-1])[path[-1]] = value
    return answer


def simpler(value):
    """Rounder or smaller values of a leaf."""
    if isinstance(value, Quantity):
        for digits in (1, 2):
            rounded = tuple(float(f"{x:.{digits}g}") for x in value.values)
            if rounded != value.values:
                yield Quantity(rounded, value.unit, value.kind)
    elif isinstance(value, Function) and value.type != "constant" and value.unit and "|" not in value.unit:
        yield Function("constant", (("value", Quantity((1.0,), value.unit)),), (("value", 1, 0),), value.unit, value.kind)


def shrink(tree, violates, tries=150):
    """The smallest tree found for which `violates(tree)` still holds, within so many runs of it."""
    left = [tries]

    def holds(candidate):
        if left[0] <= 0:
            return False
        left[0] -= 1
        try:
            return violates(candidate)
        except (KeyError, IndexError, ValueError, TypeError, AttributeError):
            return False  # what the relation needs is gone

    changed = True
    while changed and left[0] > 0:
        changed = False
        for path in sorted(places(tree), key=len):
            if path[-1] in KEPT:
                continue
            try:
                at(tree, path)
            except (KeyError, IndexError):
                continue  # went with a part above it
            candidate = without(tree, path)
            if holds(candidate):
                tree, changed = candidate, True
    for path in list(places(tree)):
        for value in simpler(at(tree, path)):
            candidate = replaced(tree, path, value)
            if holds(candidate):
                tree = candidate
                break
    return tree
