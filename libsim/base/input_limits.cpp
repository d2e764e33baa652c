#include "libsim/base/input_limits.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "libsim/base/problems.hpp"

namespace subsoil::sim {
namespace {

struct Named {
  const char* name;
  std::size_t InputLimits::*limit;
};
constexpr Named all[] = {{"scenario-bytes", &InputLimits::scenario_bytes},
                         {"values", &InputLimits::values},
                         {"keys", &InputLimits::keys},
                         {"anchors", &InputLimits::anchors},
                         {"files", &InputLimits::files},
                         {"depth", &InputLimits::depth},
                         {"name-bytes", &InputLimits::name_bytes},
                         {"text-bytes", &InputLimits::text_bytes},
                         {"frames", &InputLimits::frames},
                         {"rows", &InputLimits::rows},
                         {"steps", &InputLimits::steps},
                         {"triangles", &InputLimits::triangles},
                         {"bed-rows", &InputLimits::bed_rows},
                         {"array-bytes", &InputLimits::array_bytes},
                         {"read-seconds", &InputLimits::read_seconds},
                         {"read-bytes", &InputLimits::read_bytes}};

void read_one(std::string_view part, InputLimits& limits) {
  const std::size_t equals = std::min(part.find('='), part.size());
  const std::string_view name = part.substr(0, equals), number = part.substr(std::min(equals + 1, part.size()));
  const auto found = std::find_if(std::begin(all), std::end(all), [&](const Named& n) { return n.name == name; });
  if (found == std::end(all)) {
    std::vector<const char*> names;
    for (const Named& n : all) names.push_back(n.name);
    throw ScenarioError(
        fmt::format("SUBSOIL_LIMITS: `{}` is no limit; there are {}", name.substr(0, 60), fmt::join(names, ", ")));
  }
  double value = 0;
  const auto [end, code] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (code != std::errc{} || end != number.data() + number.size() || !(value >= 1 && value <= 1e18))
    throw ScenarioError(
        fmt::format("SUBSOIL_LIMITS: {} = `{}`: must be a whole number in [1, 1e18]", name, number.substr(0, 60)));
  limits.*(found->limit) = static_cast<std::size_t>(value);
}

}  // namespace

void read_limits(const std::string& text, InputLimits& limits) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    read_one(std::string_view(text).substr(begin, end - begin), limits);
    begin = end + 1;
  }
}

const InputLimits& input_limits() {
  static const InputLimits limits = [] {
    InputLimits given;
    if (const char* text = std::getenv("SUBSOIL_LIMITS")) read_limits(text, given);
    return given;
  }();
  return limits;
}

std::string allow_more(const char* name) {
  return fmt::format("; SUBSOIL_LIMITS={}=N in the environment allows more", name);
}

}  // namespace subsoil::sim
