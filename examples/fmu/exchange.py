"""A plate on soil by two FMUs, its machine and its soil: explicit exchange, and iteration with rollback.

    python3 exchange.py convergence WHOLE.csv soil.fmu machine.fmu
    python3 exchange.py stability four-spheres.fmu light-plate.fmu
    python3 exchange.py cost soil.fmu
"""
import csv
import math
import sys
import time

from importer import Fmu

HEIGHT, SPEED = "bodies.plate.y", "bodies.plate.vy"
LOAD = "inputs.plate.fy"
POSITION, VELOCITY, FORCE = "tools.plate.position.y", "tools.plate.velocity.y", "tools.plate.force.y"


def soil_step(soil, y, velocity, length):
    """The mean force of the soil over a step in which the plate moves evenly from y on."""
    soil.set({POSITION: y, VELOCITY: velocity})
    soil.step(length)
    return soil[FORCE]


def machine_step(machine, force, length):
    machine.set({LOAD: force})
    machine.step(length)
    return machine[HEIGHT]


def explicit(soil, machine, length):
    """The soil takes the plate's motion as extrapolated from the start of the step, then the plate takes the force."""
    y, v = machine.get(HEIGHT, SPEED)
    machine_step(machine, soil_step(soil, y, v, length), length)
    return 1


def iterated(soil, machine, length, tolerance=1e-10, most=20):
    """Both repeat the step until the plate ends where the soil took it to end. Returns the number of soil steps taken.

    With the end z that the soil is given and the end g(z) at which the machine arrives, z = g(z) is solved by the
    secant method: one unknown needs no more. Many unknowns take a quasi-Newton method.
    """
    y, v = machine.get(HEIGHT, SPEED)
    starts = soil.save(), machine.save()
    z, before = y + v * length, None
    for count in range(1, most + 1):
        if count > 1:
            soil.restore(starts[0])
            machine.restore(starts[1])
        gap = machine_step(machine, soil_step(soil, y, (z - y) / length, length), length) - z
        if abs(gap) < tolerance:
            break
        slope = (gap - before[1]) / (z - before[0]) if before and z != before[0] else -1.0
        before, z = (z, gap), z - gap / slope
    else:
        raise RuntimeError(f"no agreement within {tolerance} m after {most} iterations")
    soil.free(starts[0])
    machine.free(starts[1])
    return count


def run(soil, machine, method, length, end):
    """Heights of the plate at every communication point, and the number of soil steps per point."""
    heights, count = [machine[HEIGHT]], 0
    steps = round(end / length)
    for _ in range(steps):
        count += method(soil, machine, length)
        heights.append(machine[HEIGHT])
    return heights, count / steps


def rows_of(file):
    with open(file) as text:
        rows = list(csv.reader(line for line in text if not line.startswith("#")))
    head = [name.split(" [")[0].strip() for name in rows[0]]
    return [dict(zip(head, map(float, row))) for row in rows[1:]]


def convergence(whole, soil_file, machine_file):
    """Error of the height against the coupling in process, over the communication step."""
    rows = rows_of(whole)
    exact = rows[-1]["height"]
    print(f"in process: the plate ends at {exact * 1e3:.6f} mm after {rows[-1]['time'] * 1e3:g} ms")
    print("method     step, ms   error, um   ratio   soil steps per step")
    with Fmu(soil_file) as soils, Fmu(machine_file) as machines:
        for method in explicit, iterated:
            last = None
            for length in 2e-3, 1e-3, 0.5e-3, 0.25e-3:
                soil, machine = soils.instance(), machines.instance()
                heights, count = run(soil, machine, method, length, rows[-1]["time"])
                error = heights[-1] - exact
                ratio = f"{last / error:7.2f}" if last else "      -"
                print(f"{method.__name__:10} {length * 1e3:8g} {error * 1e6:11.3f} {ratio} {count:10.2f}")
                last = error
                soil.close()
                machine.close()


class Bound:
    """Stability of the explicit exchange of a mass m on a spring K and a dashpot C over a communication step H.

    Over a step of n soil steps the soil moves the plate evenly from p to p' = x + H v and returns the mean of the forces
    at the starts of its steps,
        F = -K ((p + p')/2 - (p' - p)/(2 n)) - C (p' - p)/H,
    and the mass takes it as a constant, v' = v + H F/m, x' = x + H v + H^2 F/(2 m). With a = K H^2/m and
    c = C H/m - a/(2 n) the three numbers (x, v H, p) have the characteristic polynomial
        l^3 + (3 g/2 - 2) l^2 + (3 h/2 + 1 - g/2) l - h/2,   g = a/2 + c, h = a/2 - c,
    whose roots lie in the unit circle (Jury) if  0 < c < 1  and  a^2 < 4 c + 2 c^2 + a c.
    For a soft spring, a << 1, that is  H^3 < 4 C m/K^2.
    """

    def __init__(self, mass, stiffness, damping, soil_step):
        self.mass, self.stiffness, self.damping, self.soil_step = mass, stiffness, damping, soil_step

    def numbers(self, length):
        a = self.stiffness * length**2 / self.mass
        return a, self.damping * length / self.mass - 0.5 * a * self.soil_step / length

    def is_stable(self, length):
        a, c = self.numbers(length)
        return c < 1 and a * a < 4 * c + 2 * c * c + a * c

    def longest(self):
        low, high = self.soil_step, 1.0
        while high - low > 1e-9 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.is_stable(middle) else (low, middle)
        return low

    def growth(self, length, method):
        """Of an oscillation per step. Explicit: the norm of the recurrence after many steps, to the power of one by their
        number. Iterated, p' = x': a recurrence of (x, v H) with the determinant 1 - c/(1 + a/4 + c/2)."""
        a, c = self.numbers(length)
        if method is iterated:
            return math.sqrt(1 - c / (1 + a / 4 + c / 2))
        x, u, p, scale, steps = 1.0, 0.0, 1.0, 0.0, 4000
        for _ in range(steps):
            end = x + u
            f = -a * (p + end) / 2 - c * (end - p)
            x, u, p = end + f / 2, u + f, end
            size = math.hypot(x, u, p)
            x, u, p, scale = x / size, u / size, p / size, scale + math.log(size)
        return math.exp(scale / steps)


def amplitude(heights, rest, of):
    """Of the oscillation about the height at rest, over a part of the heights."""
    return math.sqrt(sum((y - rest) ** 2 for y in heights[of]) / len(heights[of]))


def measured_growth(soil, machine, method, length, rest, steps):
    """Growth per step of a small oscillation, from its mean square over the first and the last third."""
    heights, count = run(soil, machine, method, length, steps * length)
    third = steps // 3
    ratio = amplitude(heights, rest, slice(-third, None)) / amplitude(heights, rest, slice(0, third))
    return ratio ** (1 / (len(heights) - third)), count


# Each of four spheres, 2.35 g, is a spring and a dashpot to the plate and to the floor, in series.
RADIUS, DENSITY, NORMAL, RESTITUTION = 6e-3, 2600.0, 100e3, 0.5
MASS, SOIL_STEP = 0.5, 5e-6  # kg, of light-plate.yaml; s, of four-spheres.yaml


def four_spheres():
    sphere = DENSITY * 4 / 3 * math.pi * RADIUS**3
    ratio = -math.log(RESTITUTION) / math.hypot(math.pi, math.log(RESTITUTION))
    dashpot = 2 * ratio * math.sqrt(sphere * NORMAL)
    return Bound(MASS, 4 * NORMAL / 2, 4 * dashpot / 2, SOIL_STEP)


def at_rest(soil, machine):
    """The plate comes to rest on the spheres by steps that are stable; returns its height."""
    heights, _ = run(soil, machine, explicit, 20 * SOIL_STEP, 0.6)
    return sum(heights[-100:]) / 100


def growths(soils, machines, method, shares, steps=120):
    """Per share of the bound: step, growth by theory and as measured, soil steps per step. The oscillation begins with
    0.1 um, where the weight presses each sphere in by 12 um: no contact opens."""
    bound = four_spheres()
    soil, machine = soils.instance(), machines.instance()
    rest = at_rest(soil, machine)
    saved = soil.save(), machine.save()
    for share in shares:
        soil.restore(saved[0])
        machine.restore(saved[1])
        length = SOIL_STEP * round(share * bound.longest() / SOIL_STEP)
        machine_step(machine, 9.81 * MASS - 0.3, 20 * SOIL_STEP)  # a push of 0.3 N for 0.1 ms
        growth, count = measured_growth(soil, machine, method, length, rest, steps)
        yield length, bound.growth(length, method), growth, count
    soil.close()
    machine.close()


def stability(soil_file, machine_file):
    """Growth per step of a small oscillation of a light plate on four spheres, and its bound."""
    bound = four_spheres()
    print(f"K = {bound.stiffness:.4g} N/m, C = {bound.damping:.4g} N s/m, m = {MASS} kg: "
          f"explicit exchange is stable up to {bound.longest() * 1e3:.4f} ms")
    print("method     step, ms   growth per step by theory   measured   soil steps per step")
    with Fmu(soil_file) as soils, Fmu(machine_file) as machines:
        for method in explicit, iterated:
            for length, theory, growth, count in growths(soils, machines, method, (0.7, 0.9, 1.1, 1.3)):
                print(f"{method.__name__:10} {length * 1e3:8.3f} {theory:20.5f} {growth:17.5f} {count:12.2f}")


def cost(soil_file):
    """Time of a rollback, which is save and restore, against that of the step that it takes back."""
    with Fmu(soil_file) as soils:
        soil = soils.instance()
        soil_step(soil, 0.018, -0.5, 16e-3)  # into contact

        def best(action, rounds=30):
            times = []
            for _ in range(rounds):
                start = time.perf_counter()
                action()
                times.append(time.perf_counter() - start)
            return min(times)

        def rollback(length=0.0):
            saved = soil.save()
            if length:
                soil.step(length)
            soil.restore(saved)
            soil.free(saved)

        print("step, ms   step takes, ms   rollback, ms   ratio")
        back = best(rollback)
        for length in 0.2e-3, 1e-3, 2e-3:
            step = best(lambda: rollback(length)) - back
            print(f"{length * 1e3:8g} {step * 1e3:16.2f} {back * 1e3:14.2f} {back / step:7.3f}")
        soil.close()


if __name__ == "__main__":
    {"convergence": convergence, "stability": stability, "cost": cost}[sys.argv[1]](*sys.argv[2:])
