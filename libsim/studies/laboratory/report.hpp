#pragma once
#include <filesystem>
#include <string>

#include "libsim/studies/laboratory/findings.hpp"

namespace subsoil::sim {

/// A unit that a reader takes in at a glance, for angles and stresses: factor on the SI value, and its name.
struct HandyUnit {
  double factor = 1;
  std::string unit;
};
HandyUnit handy_unit(const std::string& unit, double size);

/// The table for the prompt: mean, error and spread of every number, and its value per packing.
std::string findings_table(const Findings& found);

/// TEST.csv (numbers, SI, a row each), TEST-CURVE.csv, and the pictures TEST-CHART of this kind (svg, png, pdf), left
/// out where gnuplot is not installed, in `folder`, which is made.
void write_findings(const Findings& found, const std::filesystem::path& folder, const std::string& pictures);

}  // namespace subsoil::sim
