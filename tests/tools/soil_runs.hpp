#pragma once
#include <filesystem>

#include "libsim/io/series.hpp"

/// What tests of runs with soil look up in their results.
namespace subsoil::sim::test {

/// What boundaries and gravity leave unchanged, in a row of the series (J): the terms of the bed's energy balance less
/// the work of boundaries.
inline double conserved_energy(const Series& series, std::size_t row) {
  double all = -series.at("soil.boundary work")[row];
  for (const char* term : {"soil.kinetic", "soil.spin", "soil.gravity", "soil.stored", "soil.damped", "soil.slid",
                           "soil.rolled", "soil.removed"})
    all += series.at(term)[row];
  return all;
}

/// A state in the folder of a run; empty: there is none.
inline std::filesystem::path state_in(const std::filesystem::path& out) {
  for (const auto& entry : std::filesystem::directory_iterator(out))
    if (entry.path().filename().string().rfind("state-", 0) == 0) return entry.path();
  return {};
}

}  // namespace subsoil::sim::test
