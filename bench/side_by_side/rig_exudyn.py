# rig_exudyn.py STEPS
import json, sys, time
import exudyn as exu
import numpy as np
from exudyn.utilities import *

steps = int(sys.argv[1])
mbs = exu.SystemContainer().AddSystem()
before, bodies = mbs.CreateGround(), []
for k in range(3):
    inertia = RigidBodyInertia(mass=2, inertiaTensor=np.diag([1e-3, 0.0416666666666667, 0.0416666666666667]))
    body = mbs.CreateRigidBody(referencePosition=[0.25 + 0.5 * k, 0, 0], inertia=inertia, gravity=[0, -9.81, 0], create2D=True)
    ends = [mbs.AddMarker(MarkerBodyRigid(bodyNumber=b, localPosition=p))
            for b, p in ((before, [0.25 if k else 0, 0, 0]), (body, [-0.25, 0, 0]))]
    mbs.AddObject(ObjectJointRevolute2D(markerNumbers=ends))
    before = body
    bodies.append(body)
mbs.Assemble()
settings = exu.SimulationSettings()
settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, 2
settings.timeIntegration.verboseMode = 0
settings.timeIntegration.newton.relativeTolerance = 1e-10
settings.solution.file.write = False
start = time.time()
mbs.SolveDynamic(settings, showHints=False)
seconds = time.time() - start
print("RESULT " + json.dumps({"seconds": seconds, "steps": steps,
                              "end": [float(x) for x in mbs.GetObjectOutputBody(bodies[-1], exu.OutputVariableType.Position, [0, 0, 0])]}))
