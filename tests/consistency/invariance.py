"""Invariance: another frame, other names, another order, other units, another way to the same file, other observers."""
import math
import random
import shutil

import compare
from case import last_line, relation
from geometry import Name, NotTransformable, Quantity, View, render
from program import Result, dump

def in_other_frame(case, view, beside=None):
    """`beside`: a view with the same rounding, whose run says how much of a difference is that."""
    try:
        other = case.program.run(case.tree, view)
    except NotTransformable:
        return []
    violations = case.same(other, view)
    if not violations or beside is None or not other.ended:
        return violations
    return case.same(other, view, response=case.apart(other, view, case.program.run(case.tree, beside), beside))


@relation("machine")
def start_in_another_frame(case):
    """The assembly of a pose that is only `about` right does not depend on the axes of the world."""
    if not case.base.ended:
        return []
    view = View(angle=1.0)
    try:
        other = case.program.run(case.tree, view)
    except NotTransformable:
        return []
    return case.start_differs(case.base.table(), compare.back(other.table(), view), view)[:2] if other.ended else []


@relation("machine", "soil", "coupled")
def translation(case):
    if not case.listed:
        return []
    far = 1024.0 if "soil" not in case.tree else 16.0
    # A machine's plane is z = 0. Places far away are rounded to another grid; 2.3 times as far it is another again, within the same power of two
    # it is the same one, and so is what rounding adds up to.
    def there(share):
        return View(shift=(share * far, 0.25 * share * far, 0.0 if "machine" in case.tree else 4.0 * share))
    return in_other_frame(case, there(1.0), there(2.3))


@relation("machine")
def rotation(case):
    return in_other_frame(case, View(angle=case.rng.uniform(0.3, 6)))


@relation("soil", "coupled")
def quarter_turn(case):
    if not case.listed or "soil" in case.tree and ("clumps" in case.tree["soil"] or "boundaries" in case.tree or "machine" in case.tree):
        return []
    return in_other_frame(case, View(angle=0.5 * math.pi))


@relation("machine", "soil", "coupled")
def mirror_in_x(case):
    return in_other_frame(case, View(mirror_x=True)) if case.listed else []


@relation("soil", "coupled")
def mirror_in_z(case):
    return in_other_frame(case, View(mirror_z=True)) if case.listed else []


def own_names(node, found=None):
    found = set() if found is None else found
    if isinstance(node, dict):
        for key, value in node.items():
            if isinstance(key, Name):
                found.add(key.text)
            own_names(value, found)
    elif isinstance(node, list):
        for one in node:
            own_names(one, found)
    elif isinstance(node, Name):
        found.add(node.text)
    return found - {"ground"}


@relation("machine", "soil", "coupled")
def renaming(case):
    """Names in another order of the alphabet change no bit; measures are written as before."""
    names = sorted(own_names(case.tree))
    # Of measures, which formulas name, without a space.
    new = {name: f"m{len(names) - k}" if name.startswith("on ") or name in ("gap", "pace") else f"z{len(names) - k} {name}" for k, name in enumerate(names)}
    view = View(names=new)
    other = case.program.run(case.tree, view)
    if other.code != case.base.code or not case.base.ended:
        return case.same(other, view)
    return compare.bits(case.base.table(), compare.back(other.table(), view))[:3]


@relation("machine", "soil", "coupled")
def reordering(case):
    return in_other_frame(case, View(shuffle=random.Random(case.scenario.seed)))


@relation("machine", "soil", "coupled")
def other_units(case):
    return in_other_frame(case, View(units=random.Random(case.scenario.seed)))


@relation("machine", "soil", "coupled")
def include(case):
    """Half of the sections in another file: the same bits."""
    document = render(case.tree)
    moved = [key for k, key in enumerate(sorted(document)) if k % 2 and key != "subsoil"]
    path = case.program.write({"include": ["part.yaml"], **{k: v for k, v in document.items() if k not in moved}})
    (path.parent / "part.yaml").write_text(dump({k: document[k] for k in moved}))
    out = path.parent / "out"
    other = Result(out, *case.program.command("run", path, "--out", out), document)
    return exact(case, other)


@relation("machine", "soil", "coupled")
def set_against_file(case):
    other = case.program.run({**case.tree, "time": {**case.tree["time"], "end": Quantity((9.0,), "s")}},
                             options=["--set", f"time.end={render(case.tree['time']['end'])}"])
    return exact(case, other)


def exact(case, other, skip=()):
    """The same bits in every column that both have, in the rows that both have."""
    if other.code != case.base.code:
        return [f"exit code {other.code} against {case.base.code}: {last_line(other.text)}"]
    if not case.base.ended:
        return []
    mine, theirs = case.base.table(), other.table()
    if mine["time"][-1] != theirs["time"][-1]:
        return [f"ends at {theirs['time'][-1]!r} s against {mine['time'][-1]!r} s"]
    answer = compare.bits(*compare.common_rows(mine, theirs), skip=skip)
    if "soil" in case.tree:
        answer += compare.bits(case.base.spheres(), other.spheres())
    return answer[:3]


@relation("machine", "soil", "coupled")
def own_scenario(case):
    """scenario.yaml of a run, every default made explicit, runs and gives the same bits."""
    if not case.base.ended:
        return []
    path = case.program.write((case.base.folder / "scenario.yaml").read_text())
    out = path.parent / "out"
    other = Result(out, *case.program.command("run", path, "--out", out), None)
    return exact(case, other)


@relation("soil", "coupled")
def threads(case):
    return exact(case, case.program.run(case.tree, options=["--threads", "3"]))


@relation("machine", "soil", "coupled")
def observation(case):
    """Rows, frames, states, contact forces and losses asked for otherwise: the motion keeps its bits."""
    if not case.base.ended or case.scenario.analysis not in ("dynamics", "kinematics"):
        return []
    end = case.tree["time"]["end"].values[0]
    output = dict(case.tree["output"])
    output["every"] = Quantity((end / 7,), "s")
    output["series every"] = Quantity((end / 60,), "s")
    output["state every"] = Quantity((end / 3,), "s")
    if "soil" in case.tree:
        output["contact forces"] = "yes"
        output["sample losses every"] = 7
    tree = {**case.tree, "output": output}
    if "soil" in tree:  # what few samples of few impacts miss in the balance ends no run
        tree["limits"] = {**tree.get("limits", {}), "soil energy": 1e6}
    other = case.program.run(tree)
    if "soil" in case.tree:  # means over another interval, and estimates of the losses
        case.base.table()
        return exact(case, other, skip={n for n, u in case.base.units.items() if u in ("N", "N m", "J")})
    if not other.ended:
        return exact(case, other)
    # The time of a row is a product of another interval: it may differ by rounding, and the dense output with it.
    apart = compare.differences(*compare.common_rows(case.base.table(), other.table()), case.base.units)
    return [f"{name} differs by {share:.3g} of its size with other rows" for name, share in apart.items() if share > 1e-9][:3]


def with_states(case, output=None):
    """The scenario with states at a random interval, its run and the run's states; none where the run ends early or nothing moves in it."""
    if not case.base.ended or case.scenario.analysis != "dynamics":
        return case.tree, None, []
    interval = case.tree["time"]["end"].values[0] * case.rng.uniform(0.2, 0.8)
    tree = {**case.tree, "output": {**case.tree["output"], "state every": Quantity((interval,), "s"), **(output or {})}}
    run = case.program.run(tree)
    return tree, run, run.states() if run.ended else []


@relation("soil", "coupled", "machine")
def continuation(case):
    """A run from a state continues with the same bits as the run that wrote it."""
    tree, first, states = with_states(case)
    if len(states) < 2:
        return []
    other = case.program.run(tree, options=["--from", str(states[0][1])])
    if not other.ended:
        return [f"from a state: exit code {other.code}: {last_line(other.text)}"]
    if "soil step of the state" in other.text:
        return []  # which is too long for the speeds there: the run takes another
    a, b = compare.common_rows(first.table(), other.table())
    if len(b["time"]) < 2:
        return []
    a, b = ({k: v[1:] for k, v in t.items()} for t in (a, b))  # the first row of means begins at the state
    skip = set()
    if "soil" not in case.tree:  # the integrator starts again, so the motion agrees to its tolerance
        sizes = compare.differences(a, b, first.units, whole=first.table())  # as those of the response are
        response = case.response()
        return [f"{n} from a state differs by {s:.3g} of its size" for n, s in sizes.items()
                if s > max(case.floor, 10 * response.get(n, 0))][:3]
    return compare.bits(a, b, skip)[:3]


OF_THE_MACHINE = ("wall time [s]", "peak memory [bytes]", "particle-steps per second", "settling wall time [s]", "cost")


@relation("soil", "coupled", "machine")
def resume(case):
    """A run cut after its first state and resumed leaves the same rows and the same summary."""
    monitors = {}
    if "machine" in case.tree:
        v = f"{next(iter(case.tree['machine']['bodies'])).text}.vx"
        monitors = {"monitor": {"way": {"integral": v}, "top": {"maximum": v}, "average": {"mean": v}}}
    _, first, states = with_states(case, monitors)
    if len(states) < 2:
        return []
    cut = Result(first.folder.with_name("cut"), 0, "", "", first.scenario)
    shutil.copytree(first.folder, cut.folder)
    (cut.folder / "summary.json").unlink()
    for _, path in states[1:]:
        (cut.folder / path.name).unlink()
    code, stdout, stderr = case.program.command("resume", cut.folder)
    if code:
        return [f"resume: exit code {code}: {last_line(stdout + stderr)}"]
    if "soil" in case.tree:
        answer = compare.bits(first.table(), cut.table())[:2]
        a, b = (dict(leaves(run.summary())) for run in (first, cut))
        answer += [f"summary {name}: {a.get(name)!r} whole, {b.get(name)!r} resumed" for name in sorted({*a, *b}) if a.get(name) != b.get(name)]
        return answer[:4]
    # The integrator of a machine alone starts again, so the motion agrees to its tolerance.
    if len(first.table()["time"]) != len(cut.table()["time"]):
        return [f"{len(cut.table()['time'])} rows resumed, {len(first.table()['time'])} whole"]
    sizes, response = compare.differences(first.table(), cut.table(), first.units), case.response()
    return [f"{n} resumed differs by {s:.3g} of its size" for n, s in sizes.items() if s > max(case.floor, 10 * response.get(n, 0))][:3]


def leaves(node, path=""):
    if isinstance(node, dict):
        for key, value in node.items():
            if key not in OF_THE_MACHINE:
                yield from leaves(value, f"{path}/{key}")
    else:
        yield path, node
