#!/usr/bin/env python3
"""A tine of Exudyn's multibody in the soil FMU, by FMPy; exit code 77 without either.

usage: fmu_exudyn.py PROGRAM FOLDER

A carriage of 50 kg slides along x with 0.4 m/s. A tine of 1.5 kg with six degrees of freedom hangs on it by an elastic
connector without damping, twisted by 25 degrees about its shank, and passes through the soil of examples/fmu/tine.yaml.
In each communication step the soil FMU takes pose and velocity of the tine and returns the mean wrench about its centre
of mass, which Exudyn holds over the step (explicit exchange).

Oracles, from what Exudyn states of its bodies alone:
    momentum   p(t) - p(0) of carriage and tine along x = sum of F_x H: no other force acts along x
    spin       of a free tine, without the connector: L(t) - L(0) about the centre of mass = sum of M H
    energy     kinetic, potential and elastic energy: E(t) - E(0) = sum of the work of F and M on the tine
    exchange   work on the tine less that of the surface as the soil moved it, evenly over a step: falls with H
"""
import pathlib
import shutil
import subprocess
import sys

try:
    import exudyn as exu
    import numpy as np
    from exudyn.utilities import InertiaCuboid
    from fmpy import extract, instantiate_fmu, read_model_description
except ImportError as error:
    print(error)
    sys.exit(77)

PROGRAM, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
SCENARIO = pathlib.Path(__file__).resolve().parents[2] / "examples" / "fmu" / "tine.yaml"
G = 9.81
SIZE, MASS, CARRIAGE = np.array([0.016, 0.14, 0.03]), 1.5, 50.0
INERTIA = MASS / 12 * np.array([SIZE[1]**2 + SIZE[2]**2, SIZE[0]**2 + SIZE[2]**2, SIZE[0]**2 + SIZE[1]**2])
STIFFNESS = np.array([40e3, 40e3, 40e3, 200.0, 200.0, 200.0])  # N/m, N m/rad
START, ANGLE, SPEED = np.array([0.05, 0.03, 0.0]), np.radians(25), 0.4
TOP = np.array([0, SIZE[1] / 2, 0])  # of the connector, in the tine's axes
TWIST = np.array([[np.cos(ANGLE), 0, np.sin(ANGLE)], [0, 1, 0], [-np.sin(ANGLE), 0, np.cos(ANGLE)]])


class Soil:
    """The soil FMU under FMPy."""

    def __init__(self, file):
        self.folder = extract(str(file))
        description = read_model_description(str(file))
        reference = {v.name: v.valueReference for v in description.modelVariables}
        kinds = {"position": "xyz", "quaternion": "wxyz", "velocity": "xyz", "angular velocity": "xyz"}
        self.inputs = [reference[f"tools.tine.{kind}.{a}"] for kind, axes in kinds.items() for a in axes]
        self.outputs = [reference[f"tools.tine.{kind}.{a}"] for kind in ("force", "moment") for a in "xyz"]
        self.fmu = instantiate_fmu(self.folder, description, "CoSimulation")
        self.fmu.enterInitializationMode(None, 0)
        self.fmu.exitInitializationMode()

    def step(self, time, length, pose):
        """Mean force and moment about the centre of mass over a step, world axes."""
        self.fmu.setFloat64(self.inputs, [float(x) for part in pose for x in part])
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=length)
        wrench = np.array(self.fmu.getFloat64(self.outputs))
        return wrench[:3], wrench[3:]

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


class Multibody:
    """The tine, with its carriage or free."""

    def __init__(self, free, speed, spin, steps_within):
        self.system = exu.SystemContainer()
        self.mbs = mbs = self.system.AddSystem()
        kind = exu.NodeType.RotationEulerParameters
        self.tine = mbs.CreateRigidBody(
            referencePosition=list(START), referenceRotationMatrix=TWIST, initialVelocity=list(speed),
            initialAngularVelocity=list(spin), gravity=[0, -G, 0], nodeType=kind,
            inertia=InertiaCuboid(MASS / np.prod(SIZE), list(SIZE)))
        self.free, self.time = free, 0.0
        if not free:
            top = START + TWIST @ TOP
            self.carriage = mbs.CreateRigidBody(
                referencePosition=list(top), initialVelocity=list(speed), gravity=[0, -G, 0], nodeType=kind,
                inertia=InertiaCuboid(CARRIAGE / 0.1**3, [0.1, 0.1, 0.1]))
            mbs.CreateGenericJoint(itemNumbers=[mbs.CreateGround(), self.carriage], position=list(top),
                                   constrainedAxes=[0, 1, 1, 1, 1, 1])
            # Turned with the tine at rest: no connector is strained at the start.
            self.connector = mbs.CreateRigidBodySpringDamper(
                itemNumbers=[self.carriage, self.tine], localPosition0=[0, 0, 0], localPosition1=list(TOP),
                stiffness=np.diag(STIFFNESS), rotationMatrixJoint=np.eye(3), useGlobalFrame=True)
        self.force = mbs.CreateForce(itemNumber=self.tine)
        self.torque = mbs.CreateTorque(itemNumber=self.tine)
        mbs.Assemble()
        self.settings = exu.SimulationSettings()
        t = self.settings.timeIntegration
        t.verboseMode = 0
        t.generalizedAlpha.spectralRadius = 1.0  # no numerical damping
        t.newton.relativeTolerance, t.newton.absoluteTolerance = 1e-10, 1e-12
        self.settings.solution.file.write = False
        self.steps_within = steps_within

    def of(self, kind, body=None):
        return np.array(self.mbs.GetObjectOutputBody(self.tine if body is None else body, kind, localPosition=[0, 0, 0]))

    def state(self):
        v = exu.OutputVariableType
        rotation = self.of(v.RotationMatrix).reshape(3, 3)
        return self.of(v.Position), rotation, self.of(v.Velocity), self.of(v.AngularVelocity)

    def pose(self):
        position, rotation, velocity, spin = self.state()
        return position, quaternion(rotation), velocity, spin

    def step(self, force, moment, length):
        self.mbs.SetLoadParameter(self.force, "loadVector", [float(x) for x in force])
        self.mbs.SetLoadParameter(self.torque, "loadVector", [float(x) for x in moment])
        t = self.settings.timeIntegration
        t.startTime, t.endTime, t.numberOfSteps = self.time, self.time + length, self.steps_within
        if not self.mbs.SolveDynamic(self.settings, updateInitialValues=True, storeSolver=False, autoAssemble=False):
            raise RuntimeError("Exudyn's solver failed")
        self.time += length

    def momentum(self):
        """N s, of all bodies."""
        out = MASS * self.state()[2]
        if not self.free:
            out = out + CARRIAGE * self.of(exu.OutputVariableType.Velocity, self.carriage)
        return out

    def spin(self):
        """N m s, about the centre of mass."""
        _, rotation, _, omega = self.state()
        return rotation @ (INERTIA * (rotation.T @ omega))

    def energy(self):
        position, rotation, velocity, omega = self.state()
        out = 0.5 * MASS * velocity @ velocity + MASS * G * position[1]
        out += 0.5 * (rotation.T @ omega) @ (INERTIA * (rotation.T @ omega))
        if not self.free:
            v = exu.OutputVariableType
            speed = self.of(v.Velocity, self.carriage)
            out += 0.5 * CARRIAGE * speed @ speed + CARRIAGE * G * self.of(v.Position, self.carriage)[1]
            strain = np.concatenate([self.mbs.GetObjectOutput(self.connector, v.DisplacementLocal),
                                     self.mbs.GetObjectOutput(self.connector, v.Rotation)])
            out += 0.5 * strain @ (STIFFNESS * strain)
        return out


def quaternion(r):
    """w x y z of a rotation matrix of less than half a turn."""
    w = 0.5 * np.sqrt(1 + np.trace(r))
    return np.array([w, (r[2, 1] - r[1, 2]) / (4 * w), (r[0, 2] - r[2, 0]) / (4 * w), (r[1, 0] - r[0, 1]) / (4 * w)])


def rotation_vector(before, after):
    """World axes, of the rotation between two attitudes."""
    q = quaternion(after @ before.T)
    sine = np.linalg.norm(q[1:])
    return q[1:] * (2 * np.arctan2(sine, q[0]) / sine) if sine > 0 else 2 * q[1:]


def run(file, length, end, free=False, speed=(SPEED, 0, 0), spin=(0, 0, 0), steps_within=5):
    soil, body = Soil(file), Multibody(free, speed, spin, steps_within)
    momentum, turned, energy = body.momentum(), body.spin(), body.energy()
    impulse, angular, work, of_surface, passed, largest = np.zeros(3), np.zeros(3), 0.0, 0.0, 0.0, 0.0
    for k in range(round(end / length)):
        position, rotation, velocity, omega = body.state()
        force, moment = soil.step(k * length, length, body.pose())
        body.step(force, moment, length)
        after = body.state()
        impulse += force * length
        angular += moment * length
        work += force @ (after[0] - position) + moment @ rotation_vector(rotation, after[1])
        of_surface += (force @ velocity + moment @ omega) * length
        passed += abs(force @ velocity + moment @ omega) * length
        largest = max(largest, np.linalg.norm(force))
    soil.close()
    weight = np.array([0, -MASS * G * end, 0]) if free else np.zeros(3)
    return {"momentum": body.momentum() - momentum - weight, "impulse": impulse,
            "spin": body.spin() - turned, "angular": angular, "energy": body.energy() - energy, "work": work,
            "of surface": of_surface, "passed": passed, "largest": largest, "end": body.state()[0]}


def check(condition, text):
    print(("ok " if condition else "FAILED ") + text, flush=True)
    check.failed = check.failed or not condition


check.failed = False
fmu = FOLDER / "tine.fmu"
subprocess.run([PROGRAM, "fmu", SCENARIO, "--out", fmu, "--step", "0.5 ms"], check=True, capture_output=True)

print("carriage   H, ms   p_x, N s   impulse   E, J   work, J   exchange, J   passed, J")
errors = []
for length in 1e-3, 0.5e-3, 0.25e-3:
    r = run(fmu, length, 0.15)
    exchange = r["work"] - r["of surface"]
    errors.append(abs(exchange))
    print(f"{length * 1e3:16.2f} {r['momentum'][0]:10.6f} {r['impulse'][0]:9.6f} {r['energy']:8.5f} {r['work']:8.5f} "
          f"{exchange:10.2e} {r['passed']:9.4f}")
    # A force that is constant over a step gives its impulse to rounding.
    check(abs(r["momentum"][0] - r["impulse"][0]) < 1e-10 * abs(r["impulse"][0]),
          f"H = {length * 1e3} ms: momentum along x closes to {abs(r['momentum'][0] / r['impulse'][0] - 1):.1e}")
    # The trapezoidal rule keeps quadratic energies; the connector's rotations are not quadratic: of second order in its
    # steps of H/5.
    check(abs(r["energy"] - r["work"]) < 1e-6 * r["passed"],
          f"H = {length * 1e3} ms: energy closes to {abs(r['energy'] - r['work']) / r['passed']:.1e} of the work done")
    check(r["largest"] > 10, f"the soil resists: {r['largest']:.0f} N at most")
check(errors[0] > 1.3 * errors[1] > 1.3**2 * errors[2], f"the exchange's energy falls with the step: {[f'{x:.2e}' for x in errors]}")

print("free tine, thrown and spinning")
r = run(fmu, 0.5e-3, 0.04, free=True, speed=(0.5, -1.0, 0.3), spin=(2, 3, -4))
for axis in range(3):
    scale = max(np.abs(r["impulse"]))
    check(abs(r["momentum"][axis] - r["impulse"][axis]) < 1e-10 * scale,
          f"momentum along {'xyz'[axis]}: {r['momentum'][axis]:.6f} N s, impulse {r['impulse'][axis]:.6f} N s")
for axis in range(3):
    # Euler parameters by the trapezoidal rule in 5 steps per communication step: of second order in w H/5 = 4e-4.
    scale = max(np.abs(r["angular"]))
    check(abs(r["spin"][axis] - r["angular"][axis]) < 1e-4 * scale,
          f"spin about {'xyz'[axis]}: {r['spin'][axis]:.6f} N m s, angular impulse {r['angular'][axis]:.6f} N m s")
check(abs(r["energy"] - r["work"]) < 1e-4 * r["passed"], f"energy {r['energy']:.6f} J, work {r['work']:.6f} J")
sys.exit(1 if check.failed else 0)
