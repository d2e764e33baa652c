#pragma once
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "libsim/studies/sweep/study.hpp"

namespace subsoil::sim {

/// SIGINT or SIGTERM came while runs were under way.
struct StudyInterrupted : std::runtime_error {
  StudyInterrupted() : std::runtime_error("interrupted") {}
};

/// Runs of a study whose points are found on the way, in FOLDER/points as those of a sweep. The same points asked for
/// in the same order have the same numbers, so that a study that was killed reads what it had run.
class GrowingStudy {
 public:
  GrowingStudy(Study study, std::filesystem::path folder, PoolOptions pool);

  /// Runs these side by side, but for those that were run before; returns their places in study().points, in order. A
  /// point that the scenario refuses is a failed one, with its words. Throws StudyInterrupted.
  std::vector<std::size_t> run(const std::vector<SweepPoint>& points);
  const Study& study() const { return study_; }
  const std::vector<PointResult>& results() const { return results_; }

 private:
  bool refused(const SweepPoint& point, PointResult& result) const;

  Study study_;
  std::filesystem::path folder_;
  PoolOptions pool_;
  std::vector<PointResult> results_;
  std::map<std::vector<std::string>, std::size_t> known_;
};

/// Overrides that keep a run of a machine alone from writing frames that nobody looks at.
std::vector<std::string> without_frames(const std::string& scenario, const std::vector<std::string>& sets);

}  // namespace subsoil::sim
