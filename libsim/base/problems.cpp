#include "libsim/base/problems.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <string_view>
#include <tuple>

namespace subsoil::sim {

std::string Place::text() const { return line > 0 ? fmt::format("{}:{}:{}", file, line, column) : file; }

void Problems::add(const Place& place, const std::string& path, const std::string& rule) {
  found_.emplace_back(place, fmt::format("{} {}: {}", place.text(), path, rule));
}
void Problems::add(const Place& place, const std::string& path, const std::string& value, const std::string& rule) {
  if (value.empty()) return add(place, path, rule);
  found_.emplace_back(place, fmt::format("{} {} = {}: {}", place.text(), path, value, rule));
}

std::vector<std::string> Problems::lines() const {
  std::map<std::string, std::size_t> files;  // in the order in which they first came up
  for (const auto& [place, line] : found_) files.emplace(place.file, files.size());
  const auto key = [&](const Place& p) { return std::tuple{files.at(p.file), p.line, p.column}; };
  auto sorted = found_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const auto& a, const auto& b) { return key(a.first) < key(b.first); });
  std::vector<std::string> lines;
  for (auto& [place, line] : sorted) lines.push_back(std::move(line));
  return lines;
}

ScenarioError::ScenarioError(const Problems& problems)
    : std::runtime_error(fmt::format("{}", fmt::join(problems.lines(), "\n"))), lines(problems.lines()) {}

namespace {

/// Levenshtein distance: letters to change, add or drop.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, change}));
    }
  }
  return row.back();
}

/// `spring-damper` with `spring`, `rotational spring-damper` with `rotational spring`.
bool begins_with_words(std::string_view name, std::string_view words) {
  constexpr std::string_view ends = " -._";
  return words.size() >= 4 && name.size() > words.size() && name.starts_with(words) &&
         ends.find(name[words.size()]) != std::string_view::npos;
}

}  // namespace

const std::string* nearest(std::string_view word, const std::vector<std::string>& known) {
  const std::string* found = nullptr;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const std::size_t d = distance(word, candidate);
    if (d < least) {
      least = d;
      found = &candidate;
    }
  }
  if (found != nullptr && least <= 1) return found;
  const std::string* whole = nullptr;
  for (const std::string& candidate : known)
    if (begins_with_words(candidate, word) && (whole == nullptr || candidate.size() < whole->size()))
      whole = &candidate;
  return whole != nullptr ? whole : found;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
  if (const std::string* near = nearest(word, known)) return fmt::format("; did you mean `{}`?", *near);
  if (known.empty()) return "; none are known here";
  return fmt::format("; known here: {}", fmt::join(known, ", "));
}

}  // namespace subsoil::sim
