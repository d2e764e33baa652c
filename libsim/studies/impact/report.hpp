#pragma once
#include <filesystem>
#include <optional>
#include <vector>

#include "libsim/studies/impact/study.hpp"

namespace subsoil::sim {

/// One speed: the closed form, and the engine's own steps where the model is a contact law too.
struct ImpactRow {
  dem::impact::Event closed;
  std::optional<dem::impact::Event> stepped;
};

/// A number that is reported of an event.
struct ImpactQuantity {
  const char* name;
  const char* unit;
  double (*of)(const dem::impact::Event&);
};
/// What a model reports, in the order of tables and files; of the ground element the shares of energy too.
const std::vector<ImpactQuantity>& impact_quantities(const ImpactStudy& study);

/// Strikes at every speed of the study. Throws ScenarioError with the place of the model when the bodies lack what it
/// needs.
std::vector<ImpactRow> strike_all(const LoadedStudy& loaded);

/// The contact law that is this model at this speed, if there is one.
std::optional<dem::Law> law_of(const ImpactModel& model, const dem::impact::Pair& pair, double speed);

/// The table for the prompt: quantities down, speeds across; below, the engine's steps less the closed form.
std::string impact_table(const ImpactStudy& study, const std::vector<ImpactRow>& rows);

/// impact.csv (a row per speed), impact.h5 (results_file.hpp), course-SPEED.csv and stepped-SPEED.csv (time, x, v, F),
/// and the pictures impact (x, v, F over time) and loop (F over x) of this kind (svg, png, pdf) in `folder`, which is
/// made.
void write_impact(const ImpactStudy& study, const std::vector<ImpactRow>& rows, const std::filesystem::path& folder,
                  const std::string& pictures = "svg");

}  // namespace subsoil::sim
