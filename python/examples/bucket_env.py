#!/usr/bin/env python3
"""An environment of a bucket in the style of Gymnasium: reset, step, observation, reward.

    python python/examples/bucket_env.py

With the package gymnasium the class is a gymnasium.Env with its spaces; without it the methods are the same.
"""
import pathlib
import time

import numpy as np
import subsoil

try:
    import gymnasium
    Env = gymnasium.Env
except ImportError:
    gymnasium, Env = None, object

SCENARIO = pathlib.Path(__file__).resolve().parent / "bucket.yaml"
DRIVERS = [f"machine.drivers.{name}.velocity" for name in ("x", "y", "angle")]
SURFACES = ["bottom", "back", "top"]
LARGEST = np.array([0.4, 0.4, 2.0])  # m/s, m/s, rad/s
LOW, HIGH = np.array([0.07, 0.01, -1.5]), np.array([0.5, 0.3, 1.5])  # of the pose: m, m, rad


class BucketEnv(Env):
    """Fill a bucket and lift it.

    action: velocities of the bucket as shares of LARGEST, (3,) in [-1, 1]: x, y, angle
    observation: pose x m, y m, angle rad; force of the soil x N, y N, its moment about the bucket N m; spheres in it, (7,)
    reward: spheres that came above LIFT in the bucket, less work on the soil, J, over WORK
    terminated: the plates press the soil beyond the limit of its law; reward -PENALTY
    """
    PERIOD, LIFT, WORK, PENALTY = 0.02, 0.08, 5.0, 10.0  # s; m; J; 1

    def __init__(self, threads=0, length=100):
        self.sim = subsoil.Simulation(SCENARIO, inputs=DRIVERS, threads=threads)
        self.start, self.length = self.sim.save(), length
        self.taken = self.lifted = 0
        if gymnasium is not None:
            self.action_space = gymnasium.spaces.Box(-1, 1, (3,), np.float32)
            self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (7,), np.float64)

    def reset(self, *, seed=None, options=None):
        if gymnasium is not None:
            super().reset(seed=seed)
        self.sim.restore(self.start)  # the settled bed, in memory
        self.rates = np.zeros(3)
        self.taken = self.lifted = 0
        return self.observation(), {}

    def inside(self):
        """Which spheres are in the bucket: centres between its plates, (n,)."""
        (x, y, angle), _ = self.sim.body("bucket")
        d = self.sim.position[:, :2] - (x, y)
        along, across = d @ (np.cos(angle), np.sin(angle)), d @ (-np.sin(angle), np.cos(angle))
        return (np.abs(along) < 0.06) & (np.abs(across) < 0.04)

    def wrench(self):
        """Mean wrench of the soil over the last step about the bucket's centre: x N, y N, N m."""
        about = (*self.sim.body("bucket")[0][:2], 0)
        both = [self.sim.wrench(name, about) for name in SURFACES]
        force, moment = (sum(one[k] for one in both) for k in (0, 1))
        return np.array([force[0], force[1], moment[2]])

    def observation(self):
        return np.concatenate([self.sim.body("bucket")[0], self.wrench() if self.taken else np.zeros(3), [self.inside().sum()]])

    def step(self, action):
        pose = self.sim.body("bucket")[0]
        rates = np.clip(action, -1, 1) * LARGEST
        rates = np.clip(rates, (LOW - pose) / self.PERIOD, (HIGH - pose) / self.PERIOD)  # stays clear of the walls
        for name, now, rate in zip(DRIVERS, self.rates, rates):  # a ramp: a velocity that jumps is an impact
            self.sim.set_input(name, float(now), rate=float(rate - now) / self.PERIOD)
        begin = self.sim.time
        try:
            self.sim.run_until(begin + self.PERIOD)
        except subsoil.SimulationFault as fault:  # pressed beyond the limit of the soil's law
            return self.observation(), -self.PENALTY, True, False, {"lifted": 0, "work": 0.0, "fault": str(fault)}
        took = self.sim.time - begin
        work = -float(self.wrench() @ (self.rates + rates) / 2) * took
        self.rates = self.rates + (rates - self.rates) * took / self.PERIOD
        self.taken += 1
        in_bucket = self.inside()
        lifted = int((in_bucket & (self.sim.position[:, 1] > self.LIFT)).sum())
        reward = lifted - self.lifted - work / self.WORK
        self.lifted = lifted
        return self.observation(), reward, False, self.taken >= self.length, {"lifted": lifted, "work": work}


def dig(k):
    """Actions of a plan by hand: tilt, down, forward, turn, up."""
    return (0, 0, -1) if k < 12 else (0.5, -1, 0) if k < 18 else (1, 0, 0) if k < 44 else (0.5, 0.3, 1) if k < 66 else (0, 1, 0)


def main(steps=85):
    env = BucketEnv(threads=1)
    env.reset(seed=1)
    begin, total = time.perf_counter(), 0.0
    for k in range(steps):
        observation, reward, _, _, info = env.step(np.array(dig(k)))
        total += reward
    took = time.perf_counter() - begin
    begin = time.perf_counter()
    env.reset()
    print(f"{info['lifted']} of {len(env.sim.id)} spheres lifted, reward {total:.1f}; {steps / took:.0f} steps/s of "
          f"{1e3 * env.PERIOD:.0f} ms, {1e3 * (time.perf_counter() - begin):.1f} ms for a reset")
    return info["lifted"], total


if __name__ == "__main__":
    main()
