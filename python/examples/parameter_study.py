#!/usr/bin/env python3
"""Parameter study with SciPy: mean draft of a blade over its depth, the law F = c d^n fitted, and the depth for a draft.

    python python/examples/parameter_study.py
"""
import pathlib

import numpy as np
import subsoil
from scipy.optimize import brentq, curve_fit

SCENARIO = pathlib.Path(__file__).resolve().parent / "tine.yaml"


def draft(depth, until=0.5, threads=0):
    """Mean draft, N, of a blade 80 mm wide that is held at a depth, m, from 0.15 s on."""
    sim = subsoil.Simulation(SCENARIO, threads=threads, sets=[
        f"parameters.depth={depth} m", "machine.drivers.hold={coordinate: tine.y, velocity: 0 m/s}",
        "machine.surfaces.shank.box=20 200 80 mm"])
    sim.run_until(0.15)
    sim.run_until(until)
    (fx, _, _), _ = sim.wrench("shank")  # mean over the last call
    return -fx


def study(depths, until=0.5, threads=0):
    """Drafts, N, with c, n and their standard errors of F = c (d/40 mm)^n."""
    drafts = np.array([draft(depth, until, threads) for depth in depths])
    (c, n), covariance = curve_fit(lambda d, c, n: c * (d / 0.04)**n, depths, drafts, p0=(drafts.mean(), 1.5))
    return drafts, (c, n), np.sqrt(np.diag(covariance))


def main():
    depths = np.array([0.02, 0.03, 0.04, 0.05, 0.06])
    drafts, (c, n), (c_error, n_error) = study(depths)
    for depth, force in zip(depths, drafts):
        print(f"{1e3 * depth:4.0f} mm  {force:6.2f} N")
    print(f"F = ({c:.1f} +- {c_error:.1f}) N (d/40 mm)^({n:.2f} +- {n_error:.2f})")
    half = brentq(lambda d: c * (d / 0.04)**n - drafts.max() / 2, depths[0], depths[-1])
    print(f"half of the maximum draft at {1e3 * half:.1f} mm")


if __name__ == "__main__":
    main()
