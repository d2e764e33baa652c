"""Agreement of integrators and of steps."""
import numpy

from case import last_line, relation
from geometry import Quantity

@relation("machine")
def integrators(case):
    if not case.base.ended or case.scenario.analysis != "dynamics":
        return []
    answer = []
    for name in ("cvode", "ida", "adams-moulton"):
        time = {**case.tree["time"], "machine": {"integrator": name, **({"rtol": 1e-9, "atol": 1e-10} if name == "ida" else {})}}
        other = case.program.run({**case.tree, "time": time})
        if other.code in (2, 3):
            continue  # this method does not take this machine, or stops, and says so
        if not other.ended:
            answer.append(f"{name}: exit code {other.code}: {last_line(other.text)}")
            continue
        # An integrator that warns of its error is not wrong silently.
        warned = "warning" in other.text.lower() or "warning" in case.base.text.lower()
        # Nor one that states an estimate of it, which columns such as accelerations multiply.
        stated = other.summary()["run"].get("machine step error", {}).get("sum", 0.0)
        answer += [] if warned else [f"{name}: {one}" for one in case.same(other, floor=max(1e-3, 3 * stated))]
    return answer[:4]


@relation("soil")
def half_step(case):
    """Up to three spheres: what half the step changes falls with the step."""
    if not case.base.ended or not case.listed or len(case.tree["soil"]["bed"].get("particles", [])) > 3:
        return []
    step = case.base.summary()["run"].get("soil step [s]")
    ends = [end_places(case.base)]
    for k in (2, 4):
        other = case.program.run({**case.tree, "time": {**case.tree["time"], "soil step": Quantity((step / k,), "s")}})
        if not other.ended:
            return [f"step {k} times shorter than the automatic one: exit code {other.code}: {last_line(other.text)}"]
        ends.append(end_places(other))
    first, second = (float(numpy.abs(a - b).max()) for a, b in zip(ends, ends[1:]))
    scale = float(numpy.abs(ends[0] - case.base.frames()[1][0][1]["position"]).max())
    free = [one for one in case.tree["soil"]["bed"]["particles"] if "fixed" not in one]
    if len(free) == 1 and "placed" not in case.tree["soil"]["bed"] and first > 0.1 * scale:  # one sphere: nothing multiplies its error
        return [f"half the step moves the only free sphere by {first:.3g} m of a way of {scale:.3g} m"]
    if second > max(1.5 * first, 0.02 * scale):
        return [f"half the step moves a sphere by {first:.3g} m, a quarter against half by {second:.3g} m, of a way of {scale:.3g} m"]
    return []


def end_places(run):
    return run.frames()[1][-1][1]["position"]
