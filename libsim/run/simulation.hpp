#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "libdem/geometry/boundary.hpp"
#include "libdem/particles/particles.hpp"
#include "libdem/sphere_force.hpp"
#include "libmbd/base/body.hpp"

/// A scenario that is stepped in process: by another simulator, a controller, a script.
///
///   auto sim = Simulation::from_file("tine.yaml", {.sets = {"time.end=1s"}});
///   sim.set_motion("tine", {.position = {0, 0.1, 0}, .velocity = {0.5, 0, 0}});
///   while (sim.time() < 1) {
///     sim.run_until(sim.time() + 1e-3);
///     const dem::Wrench w = sim.mean_wrench("tine", {0, 0.1, 0});
///   }
///
/// It steps as `subsoil run` does (Stepper): without inputs the bits are the same, machines alone with a method of
/// variable step excepted, whose steps end where the caller asks. Units are SI; x along travel, y up, z across.
namespace subsoil::sim {

/// A step that failed; what() states time, fault and cure.
struct SimulationFault : std::runtime_error {
  SimulationFault(const std::string& text, double at) : std::runtime_error(text), time(at) {}
  double time;  ///< s
};

struct SimulationOptions {
  std::vector<std::string> sets{};    ///< path=value
  int threads = 0;                    ///< 0: as in the scenario
  std::vector<std::string> inputs{};  ///< functions of time whose values are set from outside; see available_inputs()
  /// Act on the spheres from the start on, not while a bed settles.
  std::vector<dem::NamedSphereForce> sphere_forces{};
  std::vector<std::string> forces_on{};  ///< bodies on which set_force() acts
  bool energies = false;                 ///< columns that are sums over all spheres are taken at the end of each call
  std::filesystem::path start{};         ///< a file of State::write(): the bed is taken from it; empty: prepared
  bool settle = true;                    ///< no: the bed as placed, as `subsoil check` looks at it
  std::function<bool(double time, double rms_speed)> settling{};  ///< called while a bed settles; false ends that
};

/// Motion of a surface from the present instant on: constant velocity and angular velocity, world axes.
struct SurfaceMotion {
  dem::Vec3 position;  ///< of the origin of its axes, m
  dem::Quaternion attitude{1, 0, 0, 0};
  dem::Vec3 velocity{}, angular_velocity{};  ///< m/s, rad/s
};

struct SurfaceInfo {
  enum class Owner { container, given, machine };
  std::string name;
  Owner owner = Owner::given;
  std::string body;  ///< of the machine; empty: none
};

struct ColumnInfo {
  std::string name, unit;
  bool of_sum = false;  ///< a sum over all spheres: see SimulationOptions::energies
};

struct InputInfo {
  std::string name, unit;
  double value = 0;  ///< now
};

class Simulation {
 public:
  /// Read, checked, built, bed prepared. Throw ScenarioError.
  static Simulation from_file(const std::filesystem::path& file, const SimulationOptions& options = {});
  /// @param name stands for the file in messages; includes are looked up in its folder
  static Simulation from_text(const std::string& text, const std::string& name, const SimulationOptions& options = {});
  /// Functions of time of a scenario that SimulationOptions::inputs may name.
  static std::vector<std::string> available_inputs(const std::string& text, const std::string& name,
                                                   const std::vector<std::string>& sets = {});
  Simulation(Simulation&&) noexcept;
  ~Simulation();

  // --- time ---
  double time() const;         ///< s
  double end() const;          ///< s, as the scenario has it; no step ends there by itself
  double step_length() const;  ///< s, of the soil; of a machine alone its longest
  long steps() const;
  /// So many steps. Throws SimulationFault. False where an observer ended it.
  bool step(long count = 1);
  /// Up to the first end of a step at or behind `t`; machines alone with a method of variable step end at `t`.
  bool run_until(double t);

  // --- what is there ---
  bool has_bed() const;
  bool has_machine() const;
  const std::string& scenario_text() const;  ///< with every default explicit
  /// What `subsoil check` would warn of; of a path that set_motion() has replaced nothing.
  std::vector<std::string> warnings() const;
  /// Spheres in the engine's own order, which changes between steps; valid until the next step.
  std::span<const dem::Sphere> spheres() const;
  /// The same ones, with the values of this instant for as long as the pointer lives: the engine's own memory, which it
  /// leaves to the holder when it steps on.
  std::shared_ptr<const std::span<const dem::Sphere>> held_spheres();
  const std::vector<SurfaceInfo>& surfaces() const;
  dem::Pose pose(const std::string& surface) const;  ///< of its axes, at time()
  /// Of the spheres on a surface at the start of the last step, world axes, about a world point.
  dem::Wrench wrench(const std::string& surface, const dem::Vec3& about) const;
  /// Mean over the steps of the last call of step() or run_until().
  dem::Wrench mean_wrench(const std::string& surface, const dem::Vec3& about) const;
  std::vector<std::string> bodies() const;
  mbd::BodyState body(const std::string& name) const;
  /// Columns of series.csv. Values are of the last step of the last call: positions of its start, forces over it; sums
  /// over all spheres are NaN unless SimulationOptions::energies.
  const std::vector<ColumnInfo>& columns() const;
  std::span<const double> values() const;
  double value(const std::string& column) const;

  // --- what acts from outside ---
  /// Of a given boundary. A pose other than the present one is reached within the next step.
  void set_motion(const std::string& surface, const SurfaceMotion& motion);
  std::vector<InputInfo> inputs() const;
  /// From now on value + rate (t - now). An integrator takes up a value or a rate that jumps as it does a wrench.
  void set_input(const std::string& name, double value, double rate = 0);
  /// On the centre of mass of a body that SimulationOptions::forces_on names, N and N m.
  void set_force(const std::string& body, double fx, double fy, double moment = 0);

  /// Of those that SimulationOptions::sphere_forces names, to be read or changed between two steps.
  dem::SphereForce& sphere_force(const std::string& name);

  // --- observers ---
  /// Called at the first step that begins at or behind each multiple of `every` s after now; 0: at every step. What it
  /// sets acts in that step. False ends the call of step() or run_until(). Returns a number for stop_observing().
  int observe(double every, std::function<bool(Simulation&)> observer);
  void stop_observing(int number);

  // --- state ---
  /// Bed, machine, coupling, inputs and motions; in memory.
  class State {
   public:
    State();
    State(const State&);
    State(State&&) noexcept;
    State& operator=(const State&);
    State& operator=(State&&) noexcept;
    ~State();
    double time() const;
    /// Whether the simulation continues from it with the same bits: not near a singular configuration.
    bool is_exact() const;
    std::vector<std::byte> bytes() const;
    /// To a file that SimulationOptions::start takes, also for a scenario that names other files or another step.
    void write(const std::filesystem::path& file) const;
    /// Throws std::runtime_error for bytes that are no state of this version.
    static State from_bytes(std::span<const std::byte> bytes);

   private:
    friend class Simulation;
    struct Impl;
    std::shared_ptr<const Impl> impl_;
  };
  /// A machine restarts from its own state here, so that what follows is what follows restore(): see Stepper.
  State save();
  /// Of the same scenario; throws std::invalid_argument.
  void restore(const State& state);

 private:
  struct Impl;
  explicit Simulation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace subsoil::sim
