#!/usr/bin/env python3
"""Depth control by a PID in Python: a force on a tine holds its tip 40 mm below the surface, sampled at 1 kHz.

    python python/examples/depth_control.py
"""
import pathlib

import numpy as np
import subsoil

SCENARIO = pathlib.Path(__file__).resolve().parent / "tine.yaml"
HALF = 0.1  # m, from the tine's centre of mass to its tip


class Pid:
    """u = K_p e + I + D with clamped output; the integral is held while the output is at a bound."""

    def __init__(self, proportional, integral, derivative, period, largest):
        self.proportional, self.integral, self.derivative, self.period, self.largest = proportional, integral, derivative, period, largest
        self.sum, self.before = 0.0, None

    def __call__(self, error):
        rate = 0.0 if self.before is None else (error - self.before) / self.period
        self.before = error
        output = self.proportional * error + self.sum + self.derivative * rate
        if abs(output) < self.largest:
            self.sum += self.integral * error * self.period
        return max(-self.largest, min(self.largest, output))


def run(set_point=-0.04, until=0.8, start="50 mm", period=1e-3, threads=0):
    """Times, s, heights of the tip, m, forces of the controller, N, at the samples."""
    sim = subsoil.Simulation(SCENARIO, sets=[f"parameters.depth={start}"], forces_on=["tine"], threads=threads)
    weight = 8 * 9.81
    pid = Pid(proportional=8e3, integral=4e4, derivative=300, period=period, largest=400)
    history = []

    def control(at):
        (_, y, _), _ = at.body("tine")
        force = weight + pid(set_point - (y - HALF))
        at.set_force("tine", 0, force)
        history.append((at.time, y - HALF, force))

    sim.observe(control, every=period)
    sim.run_until(until)
    return np.array(history).T


def main():
    time, tip, force = run()
    late = time > 0.5
    print(f"depth {-1e3 * tip[late].mean():.1f} mm, deviation {1e3 * tip[late].std():.2f} mm, "
          f"mean force {force[late].mean():.0f} N after 0.5 s")


if __name__ == "__main__":
    main()
