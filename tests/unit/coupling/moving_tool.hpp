#pragma once
#include <cstring>
#include <memory>

#include "coupling/simulation.hpp"
#include "libdem/geometry/mesh_builders.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "tests/tools/dem_beds.hpp"

/// A tool on a sprung arm behind a trolley driven down a slope of 45 deg, through 320 spheres; beside it a boundary on
/// a given path.
namespace subsoil::coupling::test {

struct MovingTool {
  static constexpr double step = 1e-5;
  std::unique_ptr<dem::Bed> bed;
  std::unique_ptr<mbd::Machine> machine;
  std::unique_ptr<Simulation> simulation;
  int tool = 0, surface = 0;

  explicit MovingTool(int threads = 1, int soil_steps = 1,
                      mbd::IntegratorKind kind = mbd::IntegratorKind::adams_moulton) {
    bed = std::make_unique<dem::Bed>(dem::test::table(dem::test::soil()), dem::test::quiet({0, -9.81, 0}, threads));
    dem::test::Dice dice(31);
    bed->add(dem::test::loose_lattice({0, 0, 0}, 8, 5, 8, 0.0197, 0.01, 0.2, 0.4, dice));
    dem::test::add_bin(*bed, 0.16, 0.16);
    const int stirrer = add(dem::box_mesh({0.02, 0.08, 0.02}));
    surface = add(dem::box_mesh({0.03, 0.12, 0.04}, {0, 0, 0.08}));
    mbd::Model m;
    const int trolley =
        m.add({.name = "trolley", .mass = 30, .inertia = 1, .pose = {0.09, 0.4, 0}, .velocity = {2, -2, 0}});
    tool = m.add({.name = "tool", .mass = 4, .inertia = 0.03, .pose = {0.09, 0.161, 0}, .velocity = {2, -2, 0}});
    m.add("rail",
          mbd::Translational{.body_a = mbd::ground, .body_b = trolley, .p_a = {0.09, 0.4}, .angle_a = -M_PI / 4});
    m.add("tow", mbd::CoordinateDriver{.body = trolley, .motion = {.velocity = 2.0}});
    m.add("hinge", mbd::Revolute{.body_a = trolley, .body_b = tool, .p_b = {0, 0.239}});
    m.add("spring", mbd::RotationalSpringDamper{.body_a = trolley, .body_b = tool, .stiffness = 800, .damping = 3});
    machine = std::make_unique<mbd::Machine>(m, mbd::MachineOptions{.integrator = kind});
    machine->start_from_pose();
    const auto path = [](double t) {
      return dem::Pose{{0.03, 0.142 - 2 * t, 0.13}, dem::Quaternion::from_rotation_vector({0, 20 * t, 0})};
    };
    simulation = std::make_unique<Simulation>(bed.get(), machine.get(), std::vector<BodySurface>{{tool, surface}},
                                              std::vector<GivenMotion>{{stirrer, path}},
                                              SimulationOptions{.soil_step = step, .soil_steps = soil_steps});
  }

  void run(int steps) {
    for (int n = 0; n < steps; ++n) simulation->step({.energy = n + 1 == steps, .snapshot = nullptr});
  }

  std::vector<double> machine_state() const {
    std::vector<double> values(machine->column_names().size());
    machine->columns(values);
    const InterfaceWork work = simulation->interface_work();
    const dem::Wrench& w = simulation->soil_on_body(tool);
    values.insert(values.end(),
                  {work.on_soil, work.on_machine, w.force.x, w.force.y, w.force.z, w.moment.x, w.moment.y, w.moment.z});
    return values;
  }

  /// Over the bits of all spheres, the machine's columns, the work and the wrench.
  std::uint64_t hash() const {
    std::uint64_t h = dem::test::hash(*bed);
    for (const double x : machine_state()) {
      std::uint64_t bits;
      std::memcpy(&bits, &x, 8);
      h = (h ^ bits) * 1099511628211ull;
    }
    return h;
  }

 private:
  int add(const dem::TriangleMesh& mesh) {
    dem::Boundary b;
    b.shape = dem::MeshSurface(mesh);
    return bed->add(std::move(b));
  }
};

}  // namespace subsoil::coupling::test
