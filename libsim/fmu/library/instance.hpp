#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "libsim/fmu/model.hpp"
#include "libsim/run/simulation.hpp"

/// One instance of an FMU: what the functions of FMI 2.0 and FMI 3.0 have in common.
namespace subsoil::sim {

class FmuInstance {
 public:
  enum class Level { info, warning, error };
  using Log = std::function<void(Level, const std::string&)>;
  /// Called at the end of a soil step inside a communication step: the time, true where the step shall end early.
  using Intermediate = std::function<bool(double time)>;

  /// @param resources folder of the unpacked FMU
  FmuInstance(const std::filesystem::path& resources, const std::string& token, Log log);

  double get(std::uint32_t reference);
  void set(std::uint32_t reference, double value);

  /// @param stop no step may end later; FMI lets an importer leave it open
  void start_at(double time, std::optional<double> stop) { time_ = time, stop_ = stop; }
  void enter_initialization();
  void exit_initialization();
  /// From the communication point, where inputs are set, over `length`. Returns the time reached: the end, unless
  /// `intermediate` ends it early.
  double step(double time, double length, const Intermediate& intermediate = {});
  void reset();

  struct State {
    Simulation::State simulation;
    std::vector<double> values, applied;
    std::vector<char> given;
    double offset = 0, time = 0;
    bool initialized = false;
    std::vector<std::byte> serialized{};  ///< once asked for: importers ask for size and bytes
  };
  std::shared_ptr<State> save();
  void restore(const State& state);
  const std::vector<std::byte>& serialized(const std::shared_ptr<State>& state) const;
  static std::shared_ptr<State> state_of(std::span<const std::byte> bytes);

  /// Warnings and errors always; the rest where the importer asks for it.
  void log(Level level, const std::string& text) const {
    if (level != Level::info || logs_all) log_(level, text);
  }
  bool logs_all = false;

 private:
  struct Tool {
    std::string name;
    std::uint32_t input = 0, point = 0, output = 0;  ///< first references
  };
  Simulation& simulation();
  double advance(double time, double length, const Intermediate& intermediate);
  void build();
  SurfaceMotion given_motion(std::size_t tool) const;
  void place_tools();
  void take_start();
  void take_columns();
  void take_bodies();
  void move_tools(double target);
  void apply_inputs(double length);  ///< for a step of so many s; 0: for the start
  void sum_wrenches(double t, std::vector<dem::Wrench>& sums);
  void put_wrenches(const std::vector<dem::Wrench>& sums, long steps);
  const FmuVariable& variable(std::uint32_t reference) const;

  std::filesystem::path resources_;
  Log log_;
  FmuModel model_;
  std::vector<Tool> tools_;
  std::optional<Simulation> simulation_;
  std::vector<double> values_;   ///< of all variables, by reference
  std::vector<double> applied_;  ///< of inputs, as the simulation has them; NaN: never set
  std::vector<char> given_;      ///< that the importer has set
  std::vector<dem::Pose> pose_;  ///< of tools, at the start of a step, and
  std::vector<SurfaceMotion> motion_;
  double motion_from_ = 0;
  double offset_ = 0;           ///< time of the importer less that of the scenario
  double time_ = 0;             ///< of the importer
  std::optional<double> stop_;  ///< of the importer
  bool initialized_ = false, start_is_known_ = false;
  std::string failed_;  ///< why the last step failed; empty: it did not
};

/// Messages of the program go to the instance that is inside a call on this thread.
class LogScope {
 public:
  explicit LogScope(FmuInstance& instance);
  ~LogScope();
  LogScope(const LogScope&) = delete;
  LogScope& operator=(const LogScope&) = delete;

 private:
  FmuInstance* before_;
};

}  // namespace subsoil::sim
