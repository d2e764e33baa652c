#pragma once
#include <filesystem>
#include <optional>

#include "libsim/studies/calibrate/calibration.hpp"

namespace subsoil::sim {

/// Evaluations on disk, so that a calibration continues where it was stopped: a first line with the plan, a header,
/// a line per evaluation. What a plan may change and keep its evaluations: ranges, values, tolerances, numbers of
/// points.
class EvaluationStore {
 public:
  /// Reads what is there; a line cut short by a killed run is left out. Throws std::runtime_error for another plan's.
  EvaluationStore(std::filesystem::path file, const Plan& plan);
  std::optional<Evaluation> find(Evaluation::Why why, const std::vector<double>& parameters) const;
  void add(const Evaluation& evaluation);

 private:
  void write() const;
  std::filesystem::path file_;
  std::string mark_, header_;
  std::size_t parameters_, targets_;
  std::vector<Evaluation> kept_;
};

}  // namespace subsoil::sim
