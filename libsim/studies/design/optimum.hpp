#pragma once
#include <filesystem>
#include <optional>

#include "libsim/studies/design/plan.hpp"
#include "libsim/studies/design/runs.hpp"
#include "libsim/studies/design/search.hpp"

namespace subsoil::sim {

/// All designs that were run, a row each, in their order.
struct DesignRow {
  std::size_t search = 0;          ///< that asked for it first
  std::vector<double> parameters;  ///< in their units
  Worth worth;
  bool feasible = false;
  std::vector<double> missed_by;  ///< of each constraint, as a share of its larger side
  double missed = 0;              ///< the most by which a constraint is missed, as a share of its larger side
};

struct Optimum {
  SearchMethod method = SearchMethod::automatic;
  std::vector<DesignRow> rows;
  std::vector<SearchEnd> ends;
  std::vector<std::optional<std::size_t>> best_of;  ///< per search: row
  std::optional<std::size_t> best;                  ///< row; not feasible where none is
};

/// Runs all searches of a plan. Throws StudyInterrupted.
Optimum find_optimum(const OptimisePlan& plan, GrowingStudy& study);
Study study_of(const OptimisePlan& plan);

/// FOLDER/optimise.csv (a row per design) and, where there is an optimum, best.yaml: the whole scenario, which runs.
void write_optimum(const OptimisePlan& plan, const Optimum& found, const GrowingStudy& study,
                   const std::filesystem::path& folder);
/// What the screen shows.
std::string optimum_text(const OptimisePlan& plan, const Optimum& found, const GrowingStudy& study);

}  // namespace subsoil::sim
