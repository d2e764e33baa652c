"""Balances recomputed from the output: momentum, torque, energy, mass, work at the interface."""
import math

import numpy

import compare
from case import last_line, relation
from geometry import Function, Name, Pair, Quantity

@relation("machine")
def newton_and_euler(case):
    """m a and I alpha of every body are what joints, forces and gravity put on it, by the columns of the measures."""
    if not case.base.ended or case.scenario.analysis not in ("dynamics", "kinematics"):
        return []
    table, machine, answer = case.base.table(), case.tree["machine"], []
    g = case.tree["gravity"].values
    driven = driven_bodies(machine)
    for key, body in machine["bodies"].items():
        name = key.text
        if name in driven or f"{name}.ax" not in table:
            continue
        m, inertia = body["mass"].values[0], body["inertia"].values[0]
        for column, factor, suffix, weight in (("ax", m, "x", m * g[0]), ("ay", m, "y", m * g[1]), ("alpha", inertia, "moment", 0.0)):
            terms = [v for n, v in table.items() if n.startswith(f"on {name} by ") and n.endswith("." + suffix)]
            total = sum(terms) + weight - factor * table[f"{name}.{column}"]
            size = max([compare.size_of(t) for t in terms] + [abs(weight), factor * compare.size_of(table[f"{name}.{column}"]), 1e-6])
            off = compare.spread(total) / size
            if off > max(1e-6, case.floor):
                answer.append(f"{name}: {factor:.4g} {column} differs from the sum of what acts on it by {off:.3g} of its largest part")
    return answer[:4]


def driven_bodies(machine):
    answer = set()
    for element in machine.get("drivers", {}).values():
        head = next(iter(element.values()))
        answer |= {n.text for n in (head if isinstance(head, list) else [head])}
    return answer


@relation("machine")
def energy_of_machine(case):
    """Kinetic energy by masses and velocities; what the balance column says; and that it closes."""
    if not case.base.ended or case.scenario.analysis != "dynamics":
        return []
    table = case.base.table()
    if "energy.kinetic" not in table or "beams" in case.tree["machine"]:
        return []
    kinetic = sum(0.5 * b["mass"].values[0] * (table[f"{k.text}.vx"]**2 + table[f"{k.text}.vy"]**2)
                  + 0.5 * b["inertia"].values[0] * table[f"{k.text}.spin"]**2 for k, b in case.tree["machine"]["bodies"].items())
    answer = []
    size = max(compare.size_of(table["energy.kinetic"]), 1e-9)
    off = compare.spread(kinetic - table["energy.kinetic"]) / size
    if off > 1e-9:
        answer.append(f"energy.kinetic differs from the bodies' by {off:.3g}")
    moved = sum(compare.size_of(table[f"energy.{part}"] - table[f"energy.{part}"][0])
                for part in ("kinetic", "potential", "stored", "lost", "driver work", "force work") if f"energy.{part}" in table)
    # Where energy only stays, the integrator's error is a share of what is there.
    off = compare.size_of(table["energy.balance"]) / max(moved, 1e-3 * size, 1e-6)
    if off > max(1e-5, case.floor) and "energy" not in case.base.text.lower():
        answer.append(f"energy.balance is {off:.3g} of the energy moved, and no warning says so")
    return answer


@relation("soil", "coupled")
def momentum_of_soil(case):
    """Change of the spheres' momentum is the weight's and the surfaces' impulse, from frames and rows."""
    if not case.base.ended or not case.listed:
        return []
    particles, frames = case.base.frames()
    if len(frames) < 2 or "velocity" not in frames[0][1]:
        return []
    table = case.base.table()
    if case.base.summary().get("soil", {}).get("spheres lost"):
        return []
    mass = particles["density"] * 4.0 / 3.0 * math.pi * particles["radius"]**3  # of a clump together: what its spheres share counts once
    listed = case.tree["soil"]["bed"].get("particles", [])
    free = numpy.array(["fixed" not in p for p in listed] + [True] * (len(mass) - len(listed)))
    owners = sorted({n[:-3] for n in table if n.endswith(".Fx") and not n.startswith(("soil on", "on ")) and not n.endswith(".soil.Fx")})
    steps = numpy.diff(table["time"])
    g = numpy.array(case.tree["gravity"].values)
    answer = []
    (t0, first), (t1, last) = frames[0], frames[-1]
    inside = (table["time"][1:] > t0 - 1e-12) & (table["time"][1:] <= t1 + 1e-12)
    change = (mass[free, None] * (last["velocity"] - first["velocity"])[free]).sum(axis=0)
    scale = mass.sum() * 9.81 * (t1 - t0) + numpy.abs(mass[:, None] * first["velocity"]).sum()
    for k, axis in enumerate("xyz"):
        impulse = mass[free].sum() * g[k] * (t1 - t0)
        for owner in owners:  # the columns are forces of the soil on the owner
            impulse -= (table[f"{owner}.F{axis}"][1:][inside] * steps[inside]).sum()
        # Velocities of a frame stand half a step before its time, and a force may peak at twice the mean of its row.
        # What has just met shows in the frame alone.
        most = sum(compare.size_of(table[f"{owner}.F{axis}"]) for owner in owners) + sum(numpy.abs(f["force"][:, k]).sum() for f in (first, last) if "force" in f)
        half_step = case.base.summary().get("run", {}).get("soil step [s]", 0.0) * most
        off = abs(change[k] - impulse) / scale
        if off > 1e-3 + half_step / scale:
            answer.append(f"momentum along {axis}: {change[k]:.6g} N s in frames, {impulse:.6g} N s by forces and weight ({off:.2g} of the scale)")
    moving = centre_velocities(particles, mass, last["velocity"])
    kinetic = 0.5 * (mass[free, None] * moving[free]**2).sum()
    column = table["soil.kinetic"][-1]
    power = numpy.abs(numpy.diff(table["soil.kinetic"]) / steps)[-3:].max()
    if not case.says_unstable and abs(kinetic - column) > 0.02 * max(column, kinetic) + case.base.summary().get("run", {}).get("soil step [s]", 0.0) * power + 1e-9:
        answer.append(f"soil.kinetic ends at {column:.6g} J, the frame's spheres have {kinetic:.6g} J")
    return answer


def centre_velocities(particles, mass, velocity):
    """Velocity of each sphere, in a clump of its centre: what a clump's spheres move about it belongs to soil.spin."""
    clump = particles.get("clump", numpy.full(len(mass), -1))
    answer = velocity.astype(float)
    for one in numpy.unique(clump[clump >= 0]):
        of = clump == one
        answer[of] = (mass[of, None] * velocity[of]).sum(axis=0) / mass[of].sum()
    return answer


@relation("soil")
def torque_of_soil(case):
    """Change of the spheres' angular momentum about the origin is the moment of walls, resting surfaces and weight."""
    soil = case.tree["soil"]
    resting = all("moves" not in b and "servo" not in b for b in case.tree.get("boundaries", []))
    if not case.base.ended or not case.listed or not resting or "clumps" in soil or "periodic" in soil["container"]:
        return []
    if any("fixed" in p for p in soil["bed"]["particles"]) or case.base.summary()["soil"].get("fallen out and removed"):
        return []
    particles, frames = case.base.frames()
    if len(frames) < 2 or any(word not in frames[0][1] for word in ("position", "velocity", "spin")):
        return []
    table = case.base.table()
    mass = particles["density"] * 4.0 / 3.0 * math.pi * particles["radius"]**3
    inertia = 0.4 * mass * particles["radius"]**2
    g = numpy.array(case.tree["gravity"].values)

    def momentum(frame):
        return (mass[:, None] * numpy.cross(frame["position"], frame["velocity"]) + inertia[:, None] * frame["spin"]).sum(axis=0)

    change = momentum(frames[-1][1]) - momentum(frames[0][1])
    places = numpy.zeros(3)  # integral of the sum of m x over time
    for (ta, a), (tb, b) in zip(frames, frames[1:]):
        h = tb - ta
        places += (mass[:, None] * (0.5 * h * (a["position"] + b["position"]) + h * h / 12 * (a["velocity"] - b["velocity"]))).sum(axis=0)
    impulse = numpy.cross(places, g)
    steps = numpy.diff(table["time"])
    inside = table["time"][1:] <= frames[-1][0] + 1e-12
    for owner in sorted({n[:-3] for n in table if n.endswith(".Mx")}):
        moment, force = ((numpy.array([table[f"{owner}.{word}{axis}"][1:] for axis in "xyz"]) * steps)[:, inside].sum(axis=1) for word in "MF")
        about = numpy.zeros(3)
        for b in case.tree.get("boundaries", []):
            if b["name"].text == owner:
                about = numpy.array(b["at"].values)
        impulse = impulse - moment - numpy.cross(about, force)
    scale = (mass[:, None] * numpy.abs(numpy.cross(frames[0][1]["position"], frames[0][1]["velocity"]))).sum() + numpy.abs(impulse).sum() + numpy.abs(change).sum()
    # Velocities of a frame stand half a step before its time, and a moment may peak at twice the mean of its row.
    half_step = case.base.summary().get("run", {}).get("soil step [s]", 0.0) * sum(compare.size_of(values) for n, values in table.items() if n[-3:-1] == ".M")
    off = numpy.abs(change - impulse).max() / max(scale, 1e-12)
    if off > 2e-3 + half_step / max(scale, 1e-12):
        return [f"angular momentum changes by {change}, moments and weight give {impulse} N m s ({off:.2g} of the scale)"]
    return []


@relation("soil", "coupled")
def mass_and_energy_of_soil(case):
    """Mass and count of the summary are those of the spheres; the energy balance closes or the run says that it does not."""
    if not case.base.ended or case.scenario.tree["soil"]["bed"].get("placed"):
        return []
    particles, frames = case.base.frames()
    table, summary, answer = case.base.table(), case.base.summary(), []
    if "inlets" in summary and "radius" in frames[-1][1]:
        particles = frames[-1][1]  # the table of the run lists those too that found no room
    mass = float((particles["density"].astype(float) * 4.0 / 3.0 * math.pi * particles["radius"].astype(float)**3).sum())
    rounding = 1e-9 if particles["radius"].dtype == numpy.float64 else 1e-6  # of frames in single precision
    begun = [summary["soil"], *summary.get("inlets", {}).values()]  # at the start, and what inlets have poured since
    fibres = [(one["fibres"], one["spheres of a fibre"], one["mass of a fibre [kg]"]) for one in summary.get("fibres", {}).values()]
    spheres = sum(part["spheres"] for part in begun) + sum(count * each for count, each, _ in fibres)
    stated = sum(part["mass [kg]"] for part in begun) + sum(count * mass for count, _, mass in fibres)
    window = "moving" in case.tree["soil"]  # frames list one of its periods
    if not window and (spheres != len(particles["radius"]) or abs(stated - mass) > rounding * mass):
        answer.append(f"summary: {spheres} spheres of {stated:.9g} kg, frames: {len(particles['radius'])} of {mass:.9g} kg")
    kept = [n for n in ("soil.kinetic", "soil.spin", "soil.gravity", "soil.stored", "soil.damped", "soil.slid", "soil.rolled", "soil.removed", "soil.broken", "soil.yielded")
            if n in table]
    total = sum(table[n] for n in kept) - table["soil.boundary work"]
    moved = sum(compare.size_of(table[n] - table[n][0]) for n in (*kept, "soil.boundary work")) + compare.size_of(table["soil.kinetic"])
    off = compare.spread(total - total[0]) / max(moved, 1e-12)
    if off > 0.03 and "energy" not in case.base.text:
        answer.append(f"the soil's energy balance is off by {off:.3g} of what moved, and no warning says so")
    return answer


@relation("coupled")
def work_at_the_interface(case):
    """The machine's external work is what the interface gave it; both sides of the exchange nearly agree, or the run warns."""
    if not case.base.ended:
        return []
    table = case.base.table()
    on_machine, on_soil, external = (table[n] for n in ("interface.on machine", "interface.on soil", "energy.external work"))
    size = max(compare.size_of(on_machine), compare.size_of(on_soil), 1e-9)
    answer = []
    if compare.spread(on_machine - external) > 1e-6 * size:
        answer.append(f"energy.external work ends at {external[-1]:.9g} J, interface.on machine at {on_machine[-1]:.9g} J")
    off = compare.spread(on_machine + on_soil) / size
    there = case.base.summary().get("energy", {}).get("machine energy there or moved [J]", 0)
    if off > 0.05 and off * size > 1e-3 * there and "exchange" not in case.base.text:
        answer.append(f"the exchange between soil and machine makes {off:.3g} of its work, and no warning says so")
    return answer


def machine_step(case):
    """The machine's step where it has several soil steps (s), else 0."""
    steps = case.tree["time"].get("machine", {}).get("soil steps per machine step", 1)
    return case.base.summary()["run"]["soil step [s]"] * steps if steps > 1 else 0.0


@relation("coupled")
def impulse_of_machine(case):
    """m times the change of velocity is the impulse of all that acts on the body, by the means of the rows."""
    if not case.base.ended:
        return []
    table, machine, answer = case.base.table(), case.tree["machine"], []
    g = case.tree["gravity"].values
    steps = numpy.diff(table["time"])
    for key, body in machine["bodies"].items():
        name, m = key.text, body["mass"].values[0]
        for k, axis in enumerate("xy"):
            terms = [v[1:] for n, v in table.items() if n.startswith(f"on {name} by ") and n.endswith("." + axis)]
            if f"{name}.soil.F{axis}" in table:
                terms.append(table[f"{name}.soil.F{axis}"][1:])
            terms += [table[f"{driver.text}.force"][1:] for driver, d in machine.get("drivers", {}).items() if d["coordinate"] == Name(name, "." + axis)]
            impulse = sum((v * steps).sum() for v in terms) + m * g[k] * steps.sum()
            change = m * (table[f"{name}.v{axis}"][-1] - table[f"{name}.v{axis}"][0])
            size = sum((numpy.abs(v) * steps).sum() for v in terms) + m * abs(g[k]) * steps.sum() + m * compare.size_of(table[f"{name}.v{axis}"])
            # Inside a machine step its velocity is on a line, as if the mean force of the step had acted. The means of
            # rows have the forces of the begin of each soil step.
            window = machine_step(case) * sum(compare.size_of(v) for v in terms)
            window += case.base.summary()["run"].get("soil step [s]", 0.0) * m * compare.size_of(table[f"{name}.a{axis}"])
            if abs(change - impulse) > 5e-3 * max(size, 1e-9) + window:
                answer.append(f"{name}: momentum along {axis} changes by {change:.6g}, impulses give {impulse:.6g} N s of {size:.3g}")
    return answer


@relation("soil", "coupled")
def fixed_spheres(case):
    """A fixed sphere keeps its velocity, whatever acts on it and whatever its mass."""
    if not case.base.ended or not case.listed:
        return []
    particles = case.tree["soil"]["bed"].get("particles", [])
    _, frames = case.base.frames()
    if len(frames) < 2 or "position" not in frames[0][1]:
        return []
    answer = []
    for k, one in enumerate(particles):
        if "fixed" in one:
            moved = frames[-1][1]["position"][k] - numpy.array(one["position"].values)
            off = numpy.abs(moved - (frames[-1][0] * numpy.array(one["velocity"].values) if "velocity" in one else 0.0)).max()
            if off > 1e-6 * one["radius"].values[0]:
                answer.append(f"fixed sphere {k} is {off:.3g} m off its place")
    return answer[:3]


@relation("soil", "coupled")
def overlaps_are_felt(case):
    """A sphere has a contact for every sphere, wall, box and tool that it overlaps. Fixed ones have none with each other and with what rests."""
    if not case.base.ended or not case.listed or "periodic" in case.tree["soil"]["container"] or case.tree["soil"]["bed"].get("placed"):
        return []
    particles, frames = case.base.frames()
    listed = case.tree["soil"]["bed"]["particles"]
    if len(particles.get("radius", [])) != len(listed) or "contacts" not in frames[-1][1]:
        return []
    fixed = numpy.array(["fixed" in one for one in listed])
    time, frame = frames[-1]
    x, r = frame["position"], particles["radius"]
    depth = r[:, None] + r[None, :] - numpy.linalg.norm(x[:, None] - x[None, :], axis=2)
    numpy.fill_diagonal(depth, -1.0)
    depth[numpy.ix_(fixed, fixed)] = -1.0
    deep = 1e-2 * r.min()
    due = (depth > deep).sum(axis=1)
    for surface, moves in surfaces(case, time):
        depth = surface(x)
        due += (depth + r > deep) & (numpy.abs(depth) < 3 * r) & (moves | ~fixed)
    lost = numpy.flatnonzero(frame["contacts"] < due)
    return [f"sphere {k} overlaps {due[k]} others by more than {deep:.2g} m and has {frame['contacts'][k]:.0f} contacts" for k in lost[:2]]


def surfaces(case, time):
    """Closed container walls, boxes on straight paths and tools: depth of points behind the surface, and whether it moves."""
    box = case.tree["soil"]["container"]["@box"]
    shut = {"-x", "+x", "-y", "+y", "-z", "+z"} - set(case.tree["soil"]["container"]["open"].faces)
    for face in sorted(shut):
        k = "xyz".index(face[1])
        low, high = box.at[k], box.at[k] + box.size[k]
        yield (lambda x, k=k, low=low: low - x[:, k]) if face[0] == "-" else (lambda x, k=k, high=high: x[:, k] - high), False
    for b in case.tree.get("boundaries", []):
        moves = b.get("moves", [])
        if "box" not in b["shape"] or "rotation" in b or any(set(m) - {"velocity"} for m in moves):
            continue
        at, v = numpy.array(b["at"].values), sum((numpy.array(m["velocity"].values) for m in moves), numpy.zeros(3))
        yield (lambda x, at=at + v * time, b=b: depth_in(b["shape"], x - at)), bool(moves)
    machine, table = case.tree.get("machine", {}), case.base.table()
    for tool in machine.get("surfaces", {}).values():
        if not {"box", "cylinder"} & set(tool) or abs(table["time"][-1] - time) > 1e-9:
            continue
        px, py, angle = (table[f"{tool['body'].text}.{c}"][-1] for c in ("x", "y", "angle"))

        def depth(x, px=px, py=py, c=math.cos(angle), s=math.sin(angle), tool=tool):
            dx, dy = x[:, 0] - px, x[:, 1] - py
            return depth_in(tool, numpy.stack([c * dx + s * dy, c * dy - s * dx, x[:, 2]], axis=1))
        yield depth, True


def depth_in(shape, d):
    """Depth of points behind the surface of a box or cylinder about the origin; of points outside minus their distance."""
    if "box" in shape:
        outside = numpy.abs(d) - 0.5 * numpy.array(shape["box"].values)
    else:
        axis = "xyz"[int(numpy.argmax(numpy.abs(shape["cylinder"]["axis"].values)))]
        k = "xyz".index(axis)
        across = numpy.delete(d, k, axis=1)
        outside = numpy.stack([numpy.linalg.norm(across, axis=1) - shape["cylinder"]["radius"].values[0],
                               numpy.abs(d[:, k]) - 0.5 * shape["cylinder"]["length"].values[0]], axis=1)
    return numpy.where((outside <= 0).all(axis=1), -outside.max(axis=1), -numpy.linalg.norm(numpy.maximum(outside, 0), axis=1))


def varies(node):
    """Whether anything in it is a function of time."""
    if isinstance(node, dict):
        return any(varies(value) for value in node.values())
    if isinstance(node, (list, tuple)):
        return any(varies(one) for one in node)
    if isinstance(node, Pair):
        return varies(node.x) or varies(node.y)
    return isinstance(node, Function) and node.type != "constant" and ("|" not in node.unit or node.unit.startswith("s|"))


@relation("machine")
def equilibrium_is_at_rest(case):
    """A machine released in the pose that `analysis: equilibrium` found does not leave it."""
    if not case.base.ended or case.scenario.analysis != "equilibrium":
        return []
    found = case.base.summary().get("equilibrium", {})
    if not found.get("pose") or found["coordinates that nothing holds"] or found["unstable eigenvalues"] or varies(case.tree["machine"]) or case.tree["machine"].get("events"):
        return []
    bodies = {key: {k: v for k, v in body.items() if k not in ("velocity", "angular velocity", "velocity is")} for key, body in case.tree["machine"]["bodies"].items()}
    start = {"towing equilibrium": Quantity((0.0,), "m/s")}
    other = case.program.run({**case.tree, "machine": {**case.tree["machine"], "bodies": bodies, "start": start}, "analysis": "dynamics",
                              "time": {"end": Quantity((0.5,), "s")}})
    if not other.ended:
        return [] if other.code == 2 else [f"from the equilibrium: exit code {other.code}: {last_line(other.text)}"]
    table, names = other.table(), {key.text for key in bodies}
    off = max(compare.spread(v - v[0]) for n, v in table.items() if n.endswith((".x", ".y", ".angle")) and n.split(".")[0] in names)
    return [f"the machine leaves its equilibrium by {off:.3g} m or rad in 0.5 s"] if off > 1e-4 else []
