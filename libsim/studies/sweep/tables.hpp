#pragma once
#include <filesystem>

#include "libsim/base/json.hpp"
#include "libsim/studies/sweep/effects.hpp"

namespace subsoil::sim {

/// Unit of a number, of the first run that knows it; empty: none does.
std::string unit_of(const std::vector<PointResult>& results, std::size_t number);
/// "draft [N]"; a number without dimension, or of an unknown one, keeps its name.
std::string with_unit(const std::string& name, const std::string& unit);

/// FOLDER/sweep.csv and sweep.h5: a row per point with values, numbers, end, cause and wall time.
void write_tables(const Study& study, const std::vector<PointResult>& results, const std::filesystem::path& folder);

/// What the page of a sweep draws. `best`: number and whether its maximum is wanted; none without.
Json sweep_json(const Study& study, const std::vector<PointResult>& results,
                const std::optional<std::pair<std::size_t, bool>>& best);
/// FOLDER/sweep.html.
void write_sweep_page(const Json& data, const std::filesystem::path& path);

/// A few lines for the terminal: what is done, what failed and why, strongest effects, best point.
std::string sweep_text(const Study& study, const std::vector<PointResult>& results,
                       const std::optional<std::pair<std::size_t, bool>>& best);

}  // namespace subsoil::sim
