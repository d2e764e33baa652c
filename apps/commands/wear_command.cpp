#include "apps/commands/wear_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "apps/commands/command_pages.hpp"
#include "apps/commands/quantity_option.hpp"
#include "libsim/base/signals.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/studies/wear/wear_study.hpp"

namespace subsoil::sim {
namespace {

WearRequest request_of(const WearWords& words) {
  WearRequest out;
  out.run = words.run;
  out.out = words.out.empty() ? std::filesystem::path(words.run) / "wear" : std::filesystem::path(words.out);
  out.hectares = words.hectares, out.passes = words.passes, out.repeat = words.repeat;
  if (!words.spread.empty()) out.spread = quantity_option("--spread", words.spread, "m", true);
  if (!words.width.empty()) out.width = quantity_option("--width", words.width, "m", true);
  if (!words.length.empty()) out.length = quantity_option("--length", words.length, "m", true);
  if (!words.law.empty()) out.law = words.law == "archard" ? WearLaw::archard : WearLaw::finnie;
  out.pool.threads = words.threads;
  out.pictures = words.pictures;
  return out;
}

void print(const WearRequest& request, const WearResult& result) {
  for (const WornSurface& one : result.surfaces) {
    fmt::print("{}: {:.4g} m^3 a run, {:.4g} kg, by {}'s law, {} triangles\n", one.name, one.volume,
               one.density * one.volume, one.law == WearLaw::archard ? "Archard" : "Finnie", one.volumes.size());
    if (std::abs(one.share - 1) > 0.01)
      fmt::print("note: by the last frame {:.0f} % of it had come: the distribution is that of this frame\n",
                 100 * one.share);
  }
  if (result.strip)
    fmt::print("a run works {:.4g} ha: a strip {:.4g} m wide and {:.4g} m long ({})\n", result.strip->hectares(),
               result.strip->width, result.strip->length, result.strip->source);
  for (const WearStep& step : result.steps) {
    if (step.passes == 0) continue;
    for (const WornState& s : step.surfaces)
      fmt::print(
          "{}, {:.5g} runs: {} has lost {:.4g} m^3, {:.4g} kg; depth {:.3g} m at most, {:.3g} m on average; "
          "farthest vertex {:.3g} m\n{}\n",
          step.label, step.passes, s.name, s.volume, s.mass, s.by.deepest, s.mean_depth(), s.by.farthest,
          s.file.string());
    for (std::size_t n = 0; n < step.value.size(); ++n)
      fmt::print("{}: {:.5g} +- {:.2g}\n", result.numbers[n], step.value[n], step.half_width[n]);
  }
  fmt::print("{}\n", (request.out / "wear.csv").string());
  if (!request.repeat && !result.steps.empty())
    fmt::print("next pass: subsoil run {}\n", result.steps.back().scenario.string());
}

}  // namespace

CLI::App* add_wear(CLI::App& app, WearWords& words) {
  CLI::App* word = app.add_subcommand("wear", "the shape of tools after hectares of the wear that a run has had");
  word->footer(
      "Needs a run whose surfaces have `wear` with constants. Writes STL files, scenarios with them and wear.csv.\n"
      "Equations and restrictions: docs/reference/wear.md");
  word->add_option("run", words.run, "result directory")->required()->type_name(takes_folder);
  CLI::Option* hectares =
      word->add_option("--hectares", words.hectares, "area after which the shape is wanted, such as 10 or 10,20,40")
          ->delimiter(',');
  word->add_option("--passes", words.passes, "in place of hectares: how many times this run")
      ->delimiter(',')
      ->excludes(hectares);
  word->add_option("--spread", words.spread,
                   "standard deviation along the surface over which depths spread, such as \"10 mm\"; default: none");
  word->add_option("--width", words.width, "of the strip that the run works; default: of the tool in the soil");
  word->add_option("--length", words.length, "of this strip; default: the travel of the tool");
  word->add_option("--law", words.law, "of surfaces with constants of both")
      ->check(CLI::IsMember({"archard", "finnie"}));
  word->add_option("--out", words.out, "folder; default: RUN/wear");
  word->add_flag(
      "--repeat", words.repeat,
      "run again with each worn tool: the next step wears as this run does, and draft is known over hectares");
  word->add_option("--threads", words.threads, "with --repeat: threads of a run; default: 1")
      ->check(CLI::Range(1, 1024));
  word->add_option("--pictures", words.pictures, "with --repeat: kind of the picture")
      ->check(CLI::IsMember({"svg", "png", "pdf"}));
  return word;
}

int wear_command(const WearWords& words) {
  const WearRequest request = request_of(words);
  const WearResult result = wear_study(request);
  if (result.interrupted) {
    fmt::print(stderr, "stopped; the same command continues from here\n");
    return exit_of(caught_signal());
  }
  print(request, result);
  return exit_ok;
}

}  // namespace subsoil::sim
