#include "libsim/keys/fields.hpp"
#include "libsim/keys/registry.hpp"
#include "libsim/studies/calibrate/plan.hpp"
#include "libsim/studies/design/plan.hpp"
#include "libsim/studies/impact/study.hpp"
#include "libsim/studies/laboratory/tests.hpp"
#include "libsim/studies/sweep/plan.hpp"

/// What the commands add to scenarios and their reference: one entry each.
namespace subsoil::sim {
namespace {

template <class T>
Declare prototype() {
  return [](Fields& fields) {
    T value;
    declare(fields, value);
  };
}

}  // namespace

const std::vector<CommandSection>& command_sections() {
  static const std::vector<CommandSection> sections{
      {"test", "laboratory tests of the material, run by `subsoil test`; a run does not look at it",
       prototype<LaboratoryTests>()}};
  return sections;
}

const std::vector<CommandFile>& command_files() {
  static const std::vector<CommandFile> files{
      {"impact", "The file of `subsoil impact`",
       "The same rules hold; a key may also stand as a flag, `--model jkr --w \"50 mJ/m^2\"` "
       "([impact.md](impact.md)).",
       prototype<ImpactStudy>()},
      {"calibrate", "The file of `subsoil calibrate`",
       "The same rules hold; values of targets carry the unit of their number "
       "([calibrate.md](calibrate.md)).",
       prototype<Plan>()},
      {"sweep", "The file of `subsoil sweep`", "The same rules hold ([sweep.md](sweep.md)).", prototype<SweepPlan>()},
      {"optimise", "The file of `subsoil optimise`", "The same rules hold ([optimise.md](optimise.md)).",
       prototype<OptimisePlan>()},
      {"sensitivity", "The file of `subsoil sensitivity`", "The same rules hold ([sensitivity.md](sensitivity.md)).",
       prototype<SensitivityPlan>()}};
  return files;
}

}  // namespace subsoil::sim
