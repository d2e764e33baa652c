# tool_kratos.py CASE BED.csv, in an empty folder
import csv, json, math, os, sys, time
import KratosMultiphysics as Kratos
from KratosMultiphysics import DEMApplication as Dem
from KratosMultiphysics.DEMApplication.DEM_analysis_stage import DEMAnalysisStage

case, bed = sys.argv[1:3]
k, e, density, dt, end, poisson = 50e3, 0.4, 2600, 20e-6, 0.1, 0.25
rows = [[float(x) for x in row] for row in list(csv.reader(open(bed)))[1:]]
radius = rows[0][3] * 1e-3
# Its linear law derives k from Young's moduli and the radius: 1.432 pi 0.31225 E* r/2 of a pair, pi 0.31225 E* r at a wall.
young = 2 * (1 - poisson**2) * k / (1.432 * math.pi * 0.31225 * radius / 2)
of_wall = (1 - poisson**2) / (math.pi * 0.31225 * radius / k - (1 - poisson**2) / young)
def relation(a, b, mu):
    return {"material_names_list": [a, b], "material_ids_list": [1, 1 if b == "soil" else 2], "Variables": {
        "COEFFICIENT_OF_RESTITUTION": e, "STATIC_FRICTION": mu, "DYNAMIC_FRICTION": mu, "FRICTION_DECAY": 500, "ROLLING_FRICTION": 0.0,
        "ROLLING_FRICTION_WITH_WALLS": 0.0, "SEVERITY_OF_WEAR": 0.0, "IMPACT_WEAR_SEVERITY": 0.0, "BRINELL_HARDNESS": 200.0,
        "DEM_DISCONTINUUM_CONSTITUTIVE_LAW_NAME": "DEM_D_Linear_viscous_Coulomb",
        "DEM_ROLLING_FRICTION_MODEL_NAME": "DEMRollingFrictionModelConstantTorque"}}
json.dump({"materials": [
    {"material_name": "soil", "material_id": 1, "Variables": {"PARTICLE_DENSITY": density, "YOUNG_MODULUS": young, "POISSON_RATIO": poisson}},
    {"material_name": "steel", "material_id": 2, "Variables": {"YOUNG_MODULUS": of_wall, "POISSON_RATIO": poisson, "COMPUTE_WEAR": False}}],
    "material_relations": [relation("soil", "soil", 0.5), relation("soil", "steel", 0.3)],
    "material_assignation_table": [["SpheresPart", "soil"], ["RigidFacePart", "steel"]]}, open("MaterialsDEM.json", "w"))

def block(name, lines):
    return f"Begin {name}\n" + "".join(f"{line}\n" for line in lines) + f"End {name.split()[0]}\n\n"
n = len(rows)
with open("caseDEM.mdpa", "w") as out:
    out.write(block("Properties 0", []))
    out.write(block("Nodes", [f"{i + 1} {r[0]!r} {r[1]!r} {r[2]!r}" for i, r in enumerate(rows)]))
    out.write(block("Elements SphericParticle3D", [f"{i + 1} 0 {i + 1}" for i in range(n)]))
    out.write(block("NodalData RADIUS", [f"{i + 1} 0 {r[3] * 1e-3!r}" for i, r in enumerate(rows)]))
floor, height = float(os.environ["FLOOR"]), float(os.environ["HEIGHT"])
def hexahedron(low, high, open_top):
    c = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (0, 2, 6, 4), (1, 5, 7, 3)] + ([] if open_top else [(2, 3, 7, 6)])
    return c, [t for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
bin_points, bin_faces = hexahedron((0, floor, -0.05), (0.24, floor + 0.2, 0.05), True)
if case == "tine":
    points, faces = hexahedron((0.032, height - 0.06, -0.015), (0.048, height + 0.06, 0.015), False)
    centre, velocity, spin = (0.04, height, 0), (0.5, 0, 0), (0, 0, 0)
else:  # rigid triangles only: 48 along the rim
    m, r, half = 48, 0.06, 0.03
    centre, velocity, spin = (0.07, height, 0), (0.4, 0, 0), (0, 0, -8)
    ring = [(centre[0] + r * math.cos(2 * math.pi * i / m), height + r * math.sin(2 * math.pi * i / m)) for i in range(m)]
    points = [(x, y, s) for s in (-half, half) for x, y in ring] + [(centre[0], height, -half), (centre[0], height, half)]
    faces = []
    for i in range(m):
        j = (i + 1) % m
        faces += [(i, j, m + j), (i, m + j, m + i), (2 * m, j, i), (2 * m + 1, m + i, m + j)]
with open("caseDEM_FEM_boundary.mdpa", "w") as out:
    p = bin_points + points
    f = bin_faces + [tuple(len(bin_points) + i for i in face) for face in faces]
    out.write(block("Properties 0", []))
    out.write(block("Nodes", [f"{i + 1} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(p)]))
    out.write(block("Conditions RigidFace3D3N", [f"{i + 1} 0 {a + 1} {b + 1} {c + 1}" for i, (a, b, c) in enumerate(f)]))
    for name, first, last, nodes, moved in (("1", 0, len(bin_faces), range(len(bin_points)), False),
                                            ("2", len(bin_faces), len(f), range(len(bin_points), len(p)), True)):
        data = [f"RIGID_BODY_MOTION {int(moved)}", "FREE_BODY_MOTION 0", "FIXED_MESH_OPTION 0", f"IDENTIFIER part{name}"]
        if moved:
            vector = lambda v: "[3] (%r, %r, %r)" % tuple(v)
            data += ["LINEAR_VELOCITY " + vector(velocity), "ANGULAR_VELOCITY " + vector(spin), "ROTATION_CENTER " + vector(centre),
                     "VELOCITY_PERIOD 0.0", "ANGULAR_VELOCITY_PERIOD 0.0", "VELOCITY_START_TIME 0.0", "VELOCITY_STOP_TIME 100.0",
                     "ANGULAR_VELOCITY_START_TIME 0.0", "ANGULAR_VELOCITY_STOP_TIME 100.0"]
        out.write(f"Begin SubModelPart {name}\n" + block("SubModelPartData", data) + block("SubModelPartNodes", [i + 1 for i in nodes]) +
                  block("SubModelPartConditions", [i + 1 for i in range(first, last)]) + "End SubModelPart\n\n")
parameters = Kratos.Parameters(json.dumps({
    "problem_name": "case", "Dimension": 3, "GravityX": 0.0, "GravityY": -9.81, "GravityZ": 0.0, "RotationOption": True,
    "BoundingBoxOption": False, "dem_inlet_option": False, "do_print_results_option": False,
    "solver_settings": {"strategy": "sphere_strategy", "RemoveBallsInitiallyTouchingWalls": False,
                        "material_import_settings": {"materials_filename": "MaterialsDEM.json"}},
    "ElementType": "SphericPartDEMElement3D", "TranslationalIntegrationScheme": "Symplectic_Euler",
    "RotationalIntegrationScheme": "Direct_Integration", "MaxTimeStep": dt, "FinalTime": end, "NeighbourSearchFrequency": 20,
    "SearchTolerance": 1e-3, "search_tolerance_against_walls": 1e-3,
    "GraphExportFreq": 1e9, "VelTrapGraphExportFreq": 1e9, "OutputTimeStep": 1e9, "PostContactForces": True, "PostElasticForces": True}))

class Stage(DEMAnalysisStage):
    forces, steps = [], 0
    def Initialize(self):
        super().Initialize()
        self.tool = self.rigid_face_model_part.GetSubModelPart("2")
        self.start = time.time()
    def FinalizeSolutionStep(self):
        super().FinalizeSolutionStep()
        if self.steps % 50 == 0:
            total = [0.0, 0.0, 0.0]
            for node in self.tool.Nodes:
                for d, x in enumerate(node.GetSolutionStepValue(Dem.CONTACT_FORCES)):
                    total[d] += x
            self.forces.append(total)
        self.steps += 1
    def Finalize(self):
        result = {"seconds": time.time() - self.start, "steps": self.steps, "forces": self.forces}
        print("RESULT " + json.dumps(result), flush=True)
        os._exit(0)
Stage(Kratos.Model(), parameters).Run()
