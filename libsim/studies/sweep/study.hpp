#pragma once
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libsim/io/file_lock.hpp"
#include "libsim/studies/sweep/plan.hpp"
#include "libsim/studies/sweep/pool.hpp"

/// Many runs of one scenario in a folder: which are done, running what is left, reading what they give.
namespace subsoil::sim {

struct Study {
  std::string title, scenario;
  std::vector<std::string> parameters;    ///< names
  std::optional<std::size_t> packings{};  ///< the parameter given by `seeds`: names of packings, not an amount
  std::vector<SweepPoint> points;
  std::vector<SweepNumber> numbers;
  Keep keep = Keep::numbers;
};

/// What a point has given.
struct PointResult {
  enum class End { open, reached, failed };
  End end = End::open;
  std::string cause;                  ///< of a failure
  std::vector<std::string> warnings;  ///< of its run
  double wall_time = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> value, half_width;  ///< per number, NaN where it could not be taken
  std::vector<std::string> unit;          ///< per number; empty: not known
};

/// FOLDER/points/0007.
std::filesystem::path point_folder(const std::filesystem::path& folder, std::size_t point);

/// Points without result yet, in order. A point is done when its folder holds a `point.json` with the mark of the same
/// scenario; one of another scenario throws ScenarioError: another plan's folder. `again`: failed points count as open.
bool point_is_open(const Study& study, const std::filesystem::path& folder, std::size_t point, bool again);
std::vector<std::size_t> open_points(const Study& study, const std::filesystem::path& folder, bool again);

/// Runs these points and writes `point.json` of each when it ends, so that a kill loses only what runs. Progress with
/// the remaining time is shown as that of a run. False when a signal came.
bool run_points(const Study& study, const std::filesystem::path& folder, const std::vector<std::size_t>& points,
                const PoolOptions& options);

/// Results of one point, and of all, from their folders.
PointResult read_result(const Study& study, const std::filesystem::path& folder, std::size_t point);
std::vector<PointResult> read_results(const Study& study, const std::filesystem::path& folder);

/// Keeps a second program out of the folder while it lives: throws ScenarioError when there is one.
class StudyLock {
 public:
  explicit StudyLock(const std::filesystem::path& folder);

 private:
  FileLock lock_;
};

/// Means of draft and pull where the scenario monitors them, else of soil.draft, else of every monitor.
std::vector<SweepNumber> usual_numbers(const Scenario& scenario);

}  // namespace subsoil::sim
