#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coupling/simulation.hpp"
#include "libdem/packing/layers.hpp"
#include "libdem/packing/settle.hpp"
#include "libdem/step/accuracy.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/bed_profile.hpp"
#include "libsim/setup/fibre_facts.hpp"
#include "libsim/setup/fibres.hpp"
#include "libsim/setup/inlets.hpp"
#include "libsim/setup/machine.hpp"

namespace subsoil::dem {
class MovingBed;
}

/// Everything a scenario describes, built and ready to step.
namespace subsoil::sim {

class FrameParts;
struct MovingSoil;

/// A boundary of the bed and who it belongs to.
struct SurfaceRecord {
  enum class Owner { container, given, machine };
  std::string name;
  Owner owner = Owner::given;
  int boundary = 0;
  std::size_t mesh = 0;  ///< of the boundary's shape: surfaces of one body and material share a boundary
  int body = 0;          ///< of the machine, for Owner::machine
  Vec3 reference{};      ///< point of its wrench in the axes of its pose; of walls it is the world's origin
  bool moves = false;
  std::optional<WearSection> wear{};
};

/// Spheres of the bed that keep their velocity, by the name that the scenario gives them.
struct FixedBody {
  std::string name;
  std::vector<std::uint32_t> ids;  ///< rising; empty: all fixed ones that no other body names, a rough floor
};

/// A surface that only pictures show (a wheel whose soil is a law), in body axes.
struct DrawnSurface {
  std::string name;
  int body = 0;
  dem::TriangleMesh mesh;
};

struct SoilReport {
  std::size_t spheres = 0, clumps = 0;                             ///< without fibres, as all that follows
  double mass = 0;                                                 ///< kg
  double settled_for = 0;                                          ///< s
  double rms_speed = 0;                                            ///< m/s at the end of settling
  double bulk_density = 0;                                         ///< kg/m3
  double surface_mean = 0, surface_spread = 0;                     ///< m
  double coordination = 0;                                         ///< contacts per sphere
  std::vector<std::pair<std::string, dem::LayerReport>> layers{};  ///< from the surface down, with their materials
  std::vector<DepthRow> by_depth{};                                ///< from the surface down; empty where none settled
  std::size_t carved = 0;
  std::size_t unsettled_inside = 0;  ///< removed where a tool stands, of a bed that is not settled before
  /// Spheres of fibres have this number or a higher one, in the order of the scenario (FibreGroup).
  std::uint32_t fibres_from = dem::kAllSpheres;
  std::size_t displaced = 0;         ///< spheres of the bed that were left out for fibres
  std::vector<FibreFacts> fibres{};  ///< at the start, as World::fibres
  bool stopped = false;              ///< a signal came while it was still settling
};

/// Bodies that may meet.
struct PossibleImpact {
  dem::Law law;
  dem::StepQuestion question;
  bool at_surface;
  int material, other;  ///< of the sphere, and of what it meets
  std::string between;
  std::string body{};    ///< of the machine, which yields to the sphere; empty: none does
  double body_mass = 0;  ///< kg, where it yields most, with its joints and drivers as they are at the start
};

struct ImpactError {
  double speed = 0;  ///< m/s, far away
  double error = 0;  ///< of restitution
};

struct StepReport {
  double soil_step = 0;        ///< s, used
  dem::StableStep limit;       ///< smallest over all laws
  dem::AccurateStep accurate;  ///< likewise, at the speed expected, `safety` of the stable step at most
  double machine_step = 0;     ///< s
  double machine_parts = 1;    ///< into which fixed steps are divided for the fastest waves of beams
  double expected_speed = 0;   ///< m/s, at which bodies may meet
  std::vector<PossibleImpact> impacts;

  /// Step at which every possible impact at a speed, m/s, errs by no more than the tolerance, but for those that no step
  /// down to a sixtieth of the stable one resolves.
  dem::AccurateStep at_speed(double speed, double tolerance, double longest) const;
  /// Maximum error of restitution at a speed with the step used.
  double error_at(double speed) const;
  /// Maximum error where the fastest sphere had a speed, m/s: far away, or where the pull of an approach had made it of
  /// a lower one. Looks at five speeds between these.
  ImpactError error_where_met(double fastest) const;
};

/// Called while a bed settles: time settled, rms speed. False ends the settling.
using SettleProgress = std::function<bool(double time, double rms_speed)>;

struct World {
  dem::LawTable laws;
  std::unique_ptr<mbd::Machine> machine;
  std::unique_ptr<dem::Bed> bed;
  std::vector<SurfaceRecord> surfaces;
  std::vector<DrawnSurface> drawn;
  std::vector<FixedBody> fixed;
  std::vector<coupling::BodySurface> body_surfaces;
  std::vector<coupling::GivenMotion> motions;
  std::shared_ptr<MovingSoil> moving;  ///< null: the container stands
  std::vector<PouredSoil> inlets;
  std::vector<FibreGroup> fibres;
  FrameParts* frame_parts = nullptr;  ///< of the bed's engine; null: this process writes all spheres of frames
  SoilReport soil;
  StepReport step;
  double container_shift = 0;  ///< m upward, to bring the surface to its datum
  int travel = 1;              ///< travel_direction() at the start, whatever a restart brings
};

struct BuildOptions {
  int threads = 0;
  bool settle = true;                       ///< no: `check` looks at the bed as placed
  bool place_soil = true;                   ///< no: the spheres come from a restart, and
  std::vector<dem::SphereSpec> restored{};  ///< these stand for them while the stable step is found
  SettleProgress progress{};
  std::function<bool()> keep_settling_due{};  ///< both or neither
  std::function<void(const dem::SettleState&, const dem::Bed&)> keep_settling{};
  const dem::MovingBed* moving = nullptr;      ///< of a restart
  const dem::SettleState* settling = nullptr;  ///< of a settling bed, to continue from
  MachineStart machine_start{};
};

World build_world(const Loaded& loaded, const BuildOptions& options);

/// Of a program, on the spheres of a world that is built. Throws ScenarioError where its soil can have none.
void add_sphere_forces(World& world, const Loaded& loaded, const std::vector<dem::NamedSphereForce>& forces);

/// The stable step over all laws, and the step of the run: given ones at or above the limit are refused.
void choose_step(World& world, const Loaded& loaded, dem::StepQuestion question);

/// The step of the run, and what is counted in steps: the machine's step and lags of servos that are left out.
void use_soil_step(World& world, const Scenario& scenario, double step);

/// What the step means for impacts, in words.
std::string accuracy_words(const StepReport& step);

/// Bodies of the machine so light that impacts on them have another restitution than their law gives, by above 0.02.
std::vector<std::string> restitution_warnings(const StepReport& step);

/// Pose of a boundary that follows its moves, as a function of time.
std::function<dem::Pose(double)> motion_of(const BoundarySection& boundary);

}  // namespace subsoil::sim
