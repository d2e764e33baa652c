#pragma once
#include <filesystem>
#include <vector>

#include "libsim/studies/impact/report.hpp"

namespace subsoil::sim {

/// Writes a study and its events into one HDF5 file; every dataset has an attribute `unit`, numbers are doubles in SI.
///     /                    attributes: format (1), title, model, study (the explicit YAML copy)
///     /parameters/KEY      a number each: of the model, of both bodies (first.mass, ...), of the pair; words as text
///     /table/QUANTITY      one value per speed; /table/speed; "stepped QUANTITY" what the engine's steps make of it
///     /courses/K           K = 000, 001, ... in the order of the speeds, attribute speed [m/s]: time, indentation,
///                          speed, force of the closed form; `stepped` holds the same, every step of the engine
/// Throws std::runtime_error when the file cannot be written; one that is there is written over.
void write_impact_file(const ImpactStudy& study, const std::vector<ImpactRow>& rows, const std::filesystem::path& path);

}  // namespace subsoil::sim
