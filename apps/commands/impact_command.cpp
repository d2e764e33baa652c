#include <fmt/format.h>

#include "apps/commands/commands.hpp"
#include "libsim/studies/impact/ground_fit.hpp"
#include "libsim/studies/impact/report.hpp"

namespace subsoil::sim {
namespace {

/// Short words for what is asked most.
std::string key_of(const std::string& flag) {
  if (flag == "mass" || flag == "radius" || flag == "density") return "first." + flag;
  return flag == "speed" ? "speeds" : flag;
}

struct Words {
  std::string file;
  std::vector<std::string> sets;
};

/// `FILE --key value --key=value ...` of any key of a study.
Words words_of(const ImpactRequest& request) {
  Words words{{}, request.sets};
  for (std::size_t i = 0; i < request.words.size(); ++i) {
    const std::string& word = request.words[i];
    if (!word.starts_with("--")) {
      if (!words.file.empty())
        throw std::invalid_argument(fmt::format("{}: one file at most; there is {}", word, words.file));
      words.file = word;
      continue;
    }
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos && i + 1 == request.words.size())
      throw std::invalid_argument(fmt::format("{} has no value; give one, such as --speed \"2 m/s\"", word));
    const std::string key = key_of(word.substr(2, equals == std::string::npos ? equals : equals - 2));
    words.sets.push_back(key + "=" + (equals == std::string::npos ? request.words[++i] : word.substr(equals + 1)));
  }
  return words;
}

}  // namespace

int impact_command(const ImpactRequest& request) {
  const Words words = words_of(request);
  LoadedStudy loaded = load_study(words.file, words.sets);
  if (!request.data.empty() || loaded.study.fit_to) {
    const bool ground = std::holds_alternative<GroundImpact>(loaded.study.model);
    const auto measured = [&] { return request.data.empty() ? measured_of(loaded) : read_measured(request.data); };
    const ImpactFit fit = ground && !request.data.empty() ? fit_ground(loaded, request.data)
                                                          : fit_impact(loaded, measured(), request.free);
    fmt::print("{}", fit_text(fit));
    loaded.study.model = fit.model;
  } else if (loaded.study.speeds.empty()) {
    throw ScenarioError(loaded.where("speeds") + ": is missing: speeds of approach, in m/s; for a fit give --fit");
  }
  const std::vector<ImpactRow> rows = strike_all(loaded);
  if (!rows.empty()) fmt::print("{}", impact_table(loaded.study, rows));
  if (request.out.empty()) return exit_ok;
  write_impact(loaded.study, rows, request.out, request.pictures);
  fmt::print("{}\n", request.out);
  return exit_ok;
}

}  // namespace subsoil::sim
