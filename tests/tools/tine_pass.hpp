#pragma once
#include <memory>
#include <utility>

#include "coupling/simulation.hpp"
#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/laws/wet.hpp"
#include "libdem/packing/placement.hpp"
#include "libdem/packing/settle.hpp"
#include "libdem/step/stability.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/translational.hpp"

/// A small pass through the coupling: 780 spheres of wet soil, an 80 mm wide tine 40 mm deep, towed at 0.5 m/s.
namespace subsoil::coupling::test {

struct TineSetup {
  std::uint64_t seed = 1;
  double mu = 0.5;
  double attraction = 1;  ///< factor on K_B of all pairs
  bool sprung = false;    ///< the tine hangs on a spring behind the towed trolley, else it is the trolley
  double settle = 0.15;   ///< s
};

/// Energy of bed, machine and what is between them, J, since the pass began.
struct TineEnergy {
  double bed = 0, machine = 0, interface = 0;  ///< closures, each 0 in a perfect balance
  double driver_work = 0;
  double put_in = 0;  ///< sizes of the driver's work and of gravity's on the soil
  dem::Losses lost;
  double closure() const { return bed + machine + interface; }
};

class TinePass {
 public:
  static constexpr double speed = 0.5, depth = 0.04, width = 0.08, thickness = 0.03;

  explicit TinePass(const TineSetup& setup) : setup_(setup), bed_(dem::softened(laws(), 0, 0.1), options()) {
    make_bed();
    make_machine();
    simulation_ = std::make_unique<Simulation>(&bed_, machine_.get(), std::vector<BodySurface>{{tine_, surface_}},
                                               std::vector<GivenMotion>{}, SimulationOptions{.soil_step = step_});
  }

  /// Runs until the tine's front has travelled this far into the soil, m; the draft's mean counts from `from` on.
  void run(double from, double until) {
    double sum = 0, pull = 0;
    long count = 0;
    momentum_before_ = momentum();
    const long steps = std::lround((until + clearance_) / speed / step_),
               first = std::lround((from + clearance_) / speed / step_);
    for (long n = 0; n <= steps; ++n) {
      simulation_->step({.energy = n == 0 || n == steps, .snapshot = nullptr});
      if (n == 0) start_energy();
      // The bed's first kick is half a step long (leapfrog).
      for (int b = 0; b < bed_.boundary_count(); ++b)
        impulse_ -= bed_.boundary(b).wrench.force * (n == 0 ? 0.5 * step_ : step_);
      if (n < first) continue;
      sum -= simulation_->soil_on_body(tine_).force.x;
      pull += machine_->driver_force("tow");
      ++count;
    }
    draft_ = sum / static_cast<double>(count), pull_ = pull / static_cast<double>(count);
    elapsed_ = (static_cast<double>(steps) + 0.5) * step_;
  }

  double draft() const { return draft_; }       ///< N, mean over the window
  double driver_pull() const { return pull_; }  ///< N, mean over the same window
  double step() const { return step_; }
  std::size_t spheres() const { return bed_.spheres().size(); }
  const mbd::Machine& machine() const { return *machine_; }

  TineEnergy energy() const {
    const dem::BedEnergy& b = bed_.energy();
    const mbd::MachineEnergy m = machine_->energy();
    TineEnergy e;
    e.bed = (b.total() - b.boundary_work) - bed_start_;
    e.machine = m.balance();
    e.interface = simulation_->interface_work().error();
    e.driver_work = m.driver_work;
    e.put_in = std::abs(m.driver_work) + std::abs(b.gravity - gravity_start_);
    e.lost = b.lost;
    return e;
  }

  /// What is left of Newton's law for the whole bed: change of momentum - impulse of surfaces and gravity, N s.
  dem::Vec3 impulse_gap() const {
    dem::Vec3 weight;
    for (const dem::Sphere& s : bed_.spheres()) weight += bed_.options().gravity * s.m;
    return momentum() - momentum_before_ - impulse_ - weight * elapsed_;
  }
  dem::Vec3 impulse() const { return impulse_; }  ///< of all surfaces on the spheres, N s

 private:
  static constexpr double clearance_ = 0.005;  ///< m between tine and soil at the start
  static constexpr double length_ = 0.27, height_ = 0.12, breadth_ = 0.2;

  dem::LawTable laws() const {
    dem::Wet soil;
    soil.K_X = 16000, soil.C_X = 20, soil.K_Y = 8000, soil.C_Y = 20, soil.K_B = 2500 * setup_.attraction;
    soil.dc = soil.dB = 2e-3;
    soil.friction.mu = setup_.mu, soil.friction.mu_r = 0.1;
    dem::Wet steel = soil;
    steel.K_X = 24000, steel.K_Y = 12000, steel.K_B = 1000 * setup_.attraction;
    return {.materials = 2, .index = {0, 1, 1, 1}, .laws = {soil, steel}};
  }

  static dem::BedOptions options() {
    dem::BedOptions o;
    o.threads = 1;
    o.overlap_limit = 0.8;  // a sphere caught at the tine's edge is pressed in by up to 0.6 of its radius
    return o;
  }

  void add_wall(const dem::Vec3& point, const dem::Vec3& normal) {
    dem::Boundary b;
    b.shape = dem::Plane(point, normal);
    b.material = 1;
    entry_wall_ = bed_.add(std::move(b));
  }

  void make_bed() {
    const dem::Bounds region{{0, 0, -breadth_ / 2}, {length_, height_, breadth_ / 2}};
    // A loose lattice, shaken: it falls together to a random packing.
    dem::LatticePlan plan{.region = region, .radius = dem::EqualRadius{0.01}, .jitter = 0.2, .seed = setup_.seed};
    plan.pitch = 0.02;
    bed_.add(dem::lattice(plan, {.density = 1800, .material = 0}));
    add_wall({}, {0, 1, 0});
    add_wall({0, 0, -breadth_ / 2}, {0, 0, 1});
    add_wall({0, 0, breadth_ / 2}, {0, 0, -1});
    add_wall({length_, 0, 0}, {-1, 0, 0});
    add_wall({}, {1, 0, 0});
    const dem::StepQuestion question{
        .smallest_radius = 0.01, .largest_radius = 0.01, .density = 1800, .speed = 1, .neighbours = 12};
    const dem::LawTable table = laws();
    step_ = 0.8 * std::min(dem::stable_step(table.laws[0], question).step,
                           dem::stable_step_at_surface(table.laws[1], question).step);
    dem::SettlePlan settle;
    settle.step = step_;
    settle.duration = 0.6 * setup_.settle;
    dem::settle(bed_, bed_.laws(), settle, region);
    settle.duration = 0.4 * setup_.settle;
    dem::settle(bed_, table, settle, region);
    bed_.boundary(entry_wall_).active = false;
    bed_.surfaces_changed();
    bed_.freeze();
    bed_.set_time(0);
    surface_height_ = dem::surface_height(bed_.spheres(), region).mean;
    dem::Boundary tine;
    tine.shape = dem::MeshSurface(dem::box_mesh({thickness, 0.2, width}));
    tine.material = 1;
    surface_ = bed_.add(std::move(tine));
  }

  void make_machine() {
    const double x = -clearance_ - thickness / 2, y = surface_height_ - depth + 0.1;
    mbd::Model m;
    tine_ = m.add({.name = "tine", .mass = 5, .inertia = 0.05, .pose = {x, y, 0}, .velocity = {speed, 0, 0}});
    int towed = tine_;
    if (setup_.sprung) {
      towed = m.add({.name = "trolley", .mass = 50, .inertia = 1, .pose = {x + 0.3, y, 0}, .velocity = {speed, 0, 0}});
      m.add("spring", mbd::SpringDamper{.body_a = tine_, .body_b = towed, .stiffness = 2e4, .damping = 60});
      m.add("slide", mbd::Translational{.body_a = towed, .body_b = tine_});
    }
    m.add("rail", mbd::Translational{.body_a = mbd::ground, .body_b = towed, .p_a = {0, y}});
    m.add("tow", mbd::CoordinateDriver{.body = towed, .motion = {.velocity = speed}});
    machine_ = std::make_unique<mbd::Machine>(m);
    machine_->start_from_pose();
  }

  void start_energy() {
    const dem::BedEnergy& b = bed_.energy();
    bed_start_ = b.total() - b.boundary_work;
    gravity_start_ = b.gravity;
  }

  dem::Vec3 momentum() const {
    dem::Vec3 p;
    for (const dem::Sphere& s : bed_.spheres()) p += s.m * s.v;
    return p;
  }

  TineSetup setup_;
  dem::Bed bed_;
  std::unique_ptr<mbd::Machine> machine_;
  std::unique_ptr<Simulation> simulation_;
  int entry_wall_ = 0, surface_ = 0, tine_ = 0;
  double step_ = 0, surface_height_ = 0, bed_start_ = 0, gravity_start_ = 0, draft_ = 0, pull_ = 0, elapsed_ = 0;
  dem::Vec3 momentum_before_, impulse_;
};

}  // namespace subsoil::coupling::test
