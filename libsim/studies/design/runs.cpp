#include "libsim/studies/design/runs.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

GrowingStudy::GrowingStudy(Study study, std::filesystem::path folder, PoolOptions pool)
    : study_(std::move(study)), folder_(std::move(folder)), pool_(pool) {}

bool GrowingStudy::refused(const SweepPoint& point, PointResult& result) const {
  try {
    static_cast<void>(load_scenario(study_.scenario, point.sets));
    return false;
  } catch (const std::exception& error) {
    const std::string text = error.what();
    result.end = PointResult::End::failed;
    result.cause = text.substr(0, text.find('\n'));
    result.value.assign(study_.numbers.size(), std::numeric_limits<double>::quiet_NaN());
    result.half_width = result.value;
    return true;
  }
}

std::vector<std::size_t> GrowingStudy::run(const std::vector<SweepPoint>& points) {
  std::vector<std::size_t> places, fresh, open;
  for (const SweepPoint& point : points) {
    const auto [known, added] = known_.try_emplace(point.values, study_.points.size());
    places.push_back(known->second);
    if (!added) continue;
    study_.points.push_back(point), results_.emplace_back();
    if (refused(point, results_.back())) continue;
    fresh.push_back(places.back());
    if (point_is_open(study_, folder_, places.back(), false)) open.push_back(places.back());
  }
  if (!open.empty() && !run_points(study_, folder_, open, pool_)) throw StudyInterrupted();
  for (const std::size_t k : fresh) results_[k] = read_result(study_, folder_, k);
  return places;
}

std::vector<std::string> without_frames(const std::string& scenario, const std::vector<std::string>& sets) {
  const Scenario s = load_scenario(scenario, sets).scenario;
  if (s.has_bed() || !s.runs_in_time() || !s.output.at.empty()) return {};
  return {fmt::format("output.every={:.12g} s", s.time.end), "output.state=none"};
}

}  // namespace subsoil::sim
