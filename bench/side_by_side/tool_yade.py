# yade -n -x -j1 tool_yade.py CASE BED.csv
import csv, json, math, os, sys, time
from yade import *

case, bed = sys.argv[1:3]
k, ratio, e, mu, mu_steel, density, dt, end = 50e3, 6 / 7, 0.4, math.atan(0.5), math.atan(0.3), 2600, 20e-6, 0.1
rows = [[float(x) for x in row] for row in list(csv.reader(open(bed)))[1:]]
radius = rows[0][3] * 1e-3
beta = -math.log(e) / math.hypot(math.pi, math.log(e))
mass = density * 4 / 3 * math.pi * radius**3
# Materials in series give the pair: 2 k and twice the dashpot of m/2; at steel the dashpot is that of m.
pair, at_steel = 2 * beta * math.sqrt(0.5 * mass * k), 2 * beta * math.sqrt(mass * k)
steel_c = 1 / (1 / at_steel - 1 / (2 * pair))
soil = O.materials.append(ViscElMat(kn=2 * k, ks=2 * ratio * k, cn=2 * pair, cs=2 * math.sqrt(ratio) * pair, frictionAngle=mu, density=density))
steel = O.materials.append(ViscElMat(kn=2 * k, ks=2 * ratio * k, cn=steel_c, cs=math.sqrt(ratio) * steel_c, frictionAngle=mu_steel, density=7850))
for axis, sense, at in ((0, 1, 0), (0, -1, 0.24), (1, 1, float(os.environ["FLOOR"])), (2, 1, -0.05), (2, -1, 0.05)):
    O.bodies.append(wall(at, axis, sense=sense, material=steel))
for x, y, z, r in rows:
    O.bodies.append(sphere((x, y, z), r * 1e-3, material=soil))
height = float(os.environ["HEIGHT"])
if case == "tine":
    tool = [O.bodies.append(box((0.04, height, 0), (0.008, 0.06, 0.015), fixed=True, material=steel))]
    O.bodies[tool[0]].state.vel = (0.5, 0, 0)
    moves = []
else:  # no cylinder meets spheres here: 48 facets of the mantle and of each side
    n, r, half, c = 48, 0.06, 0.03, Vector3(0.07, height, 0)
    rim = [Vector3(r * math.cos(2 * math.pi * i / n), r * math.sin(2 * math.pi * i / n), 0) for i in range(n)]
    z, facets = Vector3(0, 0, half), []
    for i in range(n):
        p, q = c + rim[i], c + rim[(i + 1) % n]
        facets += [(p - z, q - z, q + z), (p - z, q + z, p + z), (c + z, p + z, q + z), (c - z, q - z, p - z)]
    tool = O.bodies.append([facet(f, material=steel) for f in facets])
    turn = RotationEngine(ids=tool, rotationAxis=(0, 0, 1), angularVelocity=-8, rotateAroundZero=True, zeroPoint=c)
    moves = [CombinedKinematicEngine(ids=tool, comb=[TranslationEngine(ids=tool, translationAxis=(1, 0, 0), velocity=0.4), turn]),
             PyRunner(command="turn.zeroPoint += Vector3(0.4 * dt, 0, 0)", iterPeriod=1)]
forces = []
def sample():
    forces.append(list(sum((O.forces.f(i) for i in tool), Vector3.Zero)))
O.dt = dt
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb()]),
             InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
                             [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]),
             PyRunner(command="sample()", iterPeriod=50)] + moves + [NewtonIntegrator(damping=0, gravity=(0, -9.81, 0))]
O.run(1, True)
for i in O.interactions:
    if i.isReal:
        stiff = [i.phys.kn / k, i.phys.ks / (ratio * k), i.phys.cn / (pair if min(i.id1, i.id2) > 4 and max(i.id1, i.id2) < tool[0] else at_steel)]
        assert max(abs(s - 1) for s in stiff) < 1e-6, stiff
start = time.time()
O.run(round(end / dt) - 1, True)
print("RESULT " + json.dumps({"seconds": time.time() - start, "steps": O.iter, "forces": forces}), flush=True)
os._exit(0)
