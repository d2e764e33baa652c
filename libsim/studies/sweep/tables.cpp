#include "libsim/studies/sweep/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/base/version.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/hdf5.hpp"
#include "libsim/io/hdf5_driver.hpp"
#include "libsim/report/page.hpp"

namespace subsoil::sim {

std::string unit_of(const std::vector<PointResult>& results, std::size_t number) {
  for (const PointResult& r : results)
    if (number < r.unit.size() && !r.unit[number].empty()) return r.unit[number];
  return {};
}

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() || unit == "1" ? name : fmt::format("{} [{}]", name, unit);
}
namespace {

const char* word_of(PointResult::End end) {
  return end == PointResult::End::reached ? "reached" : end == PointResult::End::failed ? "failed" : "open";
}

std::string point_words(const Study& study, std::size_t k) {
  std::string text;
  for (std::size_t p = 0; p < study.parameters.size(); ++p)
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", study.parameters[p], study.points[k].values[p]);
  return text;
}

/// What is said of points that reached their end without this number; empty without any.
std::string without_number(const Study& study, const std::vector<PointResult>& results, std::size_t number) {
  std::size_t count = 0, first = 0;
  for (std::size_t k = results.size(); k-- > 0;)
    if (results[k].end == PointResult::End::reached && !std::isfinite(results[k].value[number])) ++count, first = k;
  if (count == 0) return {};
  return fmt::format(
      "warning: {} of {} points have no number `{}`, first {:04} ({}): no such column or path, no value (0/0) or no "
      "row in its window; their cells stay empty\n",
      count, results.size(), study.numbers[number].name, first + 1, point_words(study, first));
}

/// Scatter of a number between packings; empty without.
std::string scatter_words(const Study& study, const std::vector<PointResult>& results, std::size_t number) {
  const std::optional<Scatter> s = scatter(study, results, number);
  if (!s) return {};
  const std::string& name = study.numbers[number].name;
  if (s->settings == 1)
    return fmt::format("{}: {:.5g} +- {:.2g} over {} packings (95 %), standard deviation {:.2g}\n", name, s->mean,
                       s->half_width, s->packings, s->deviation);
  return fmt::format("{}: standard deviation {:.2g} between packings, over {} settings of the other parameters\n", name,
                     s->deviation, s->settings);
}

/// Of a parameter whose values are numbers with units, as its first value has it: "mm" of "40 mm".
std::string unit_of(const Study& study, std::size_t parameter) {
  if (study.points.empty() || !std::isfinite(study.points.front().places[parameter])) return {};
  const std::string& value = study.points.front().values[parameter];
  const std::size_t end = value.find_first_not_of("+-.0123456789eE");
  const std::size_t begin = end == std::string::npos ? end : value.find_first_not_of(' ', end);
  return begin == std::string::npos ? std::string() : value.substr(begin);
}

std::string csv_text(const Study& study, const std::vector<PointResult>& results) {
  std::string text = "point";
  for (const std::string& p : study.parameters) text += fmt::format(",{}", csv::quoted(p));
  for (std::size_t n = 0; n < study.numbers.size(); ++n) {
    const std::string &name = study.numbers[n].name, unit = unit_of(results, n);
    text +=
        fmt::format(",{},{}", csv::quoted(with_unit(name, unit)), csv::quoted(with_unit(name + " half width", unit)));
  }
  text += ",end,wall time [s],cause\n";
  const auto add = [&](double v) {
    text += ',';
    if (std::isfinite(v)) csv::append_number(text, v, csv::exact_digits);
  };
  for (std::size_t k = 0; k < results.size(); ++k) {
    text += std::to_string(k + 1);
    for (const std::string& v : study.points[k].values) text += fmt::format(",{}", csv::quoted(v));
    for (std::size_t n = 0; n < study.numbers.size(); ++n) add(results[k].value[n]), add(results[k].half_width[n]);
    text += std::string(",") + word_of(results[k].end);
    add(results[k].wall_time);
    text += fmt::format(",{}\n", csv::quoted(results[k].cause));
  }
  return text;
}

void write_hdf5(const Study& study, const std::vector<PointResult>& results, const std::filesystem::path& path) {
  {
    h5::Handle file = h5::create_file(temporary_name(path));
    h5::set_attribute(file, "subsoil sweep", std::int64_t{1});
    h5::set_attribute(file, "title", study.title);
    std::vector<std::string> ends, causes;
    std::vector<double> wall;
    for (const PointResult& r : results)
      ends.emplace_back(word_of(r.end)), causes.push_back(r.cause), wall.push_back(r.wall_time);
    h5::create_group(file, "parameters");
    h5::create_group(file, "values");
    for (std::size_t p = 0; p < study.parameters.size(); ++p) {
      std::vector<double> places;
      std::vector<std::string> words;
      for (const SweepPoint& point : study.points) places.push_back(point.places[p]), words.push_back(point.values[p]);
      h5::write<double>(file, "parameters/" + study.parameters[p], places);
      h5::write_text(file, "values/" + study.parameters[p], words);
    }
    h5::create_group(file, "numbers");
    h5::create_group(file, "half widths");
    for (std::size_t n = 0; n < study.numbers.size(); ++n) {
      std::vector<double> value, half;
      for (const PointResult& r : results) value.push_back(r.value[n]), half.push_back(r.half_width[n]);
      h5::write<double>(file, "numbers/" + study.numbers[n].name, value);
      h5::write<double>(file, "half widths/" + study.numbers[n].name, half);
    }
    h5::write<double>(file, "wall time", wall);
    h5::write_text(file, "end", ends);
    h5::write_text(file, "cause", causes);
    h5::close_file(file);
  }
  put_in_place(path);
}

}  // namespace

void write_tables(const Study& study, const std::vector<PointResult>& results, const std::filesystem::path& folder) {
  write_atomically(folder / "sweep.csv", csv_text(study, results));
  write_hdf5(study, results, folder / "sweep.h5");
}

Json sweep_json(const Study& study, const std::vector<PointResult>& results,
                const std::optional<std::pair<std::size_t, bool>>& best) {
  Json out{{"format", "subsoil sweep 1"},
           {"version", version()},
           {"title", study.title},
           {"scenario", study.scenario},
           {"parameters", study.parameters}};
  for (const SweepNumber& n : study.numbers) out["numbers"].push_back(n.name);
  for (std::size_t n = 0; n < study.numbers.size(); ++n)
    out["number labels"].push_back(with_unit(study.numbers[n].name, unit_of(results, n)));
  for (std::size_t p = 0; p < study.parameters.size(); ++p)
    out["parameter labels"].push_back(with_unit(study.parameters[p], unit_of(study, p)));
  for (std::size_t k = 0; k < results.size(); ++k) {
    Json point{{"values", study.points[k].values},
               {"end", word_of(results[k].end)},
               {"cause", results[k].cause},
               {"wall time", json_rounded(results[k].wall_time)}};
    for (std::size_t p = 0; p < study.parameters.size(); ++p)
      point["places"].push_back(json_rounded(study.points[k].places[p]));
    for (std::size_t n = 0; n < study.numbers.size(); ++n) {
      point["value"].push_back(json_rounded(results[k].value[n]));
      point["half width"].push_back(json_rounded(results[k].half_width[n]));
    }
    out["points"].push_back(point);
  }
  out["effects"] = Json::array();
  for (const Effect& e : effects(study, results)) {
    Json effect{{"parameter", e.parameter},
                {"number", e.number},
                {"slope", json_rounded(e.slope)},
                {"slope half", json_rounded(e.slope_half)}};
    effect["levels"] = Json::array();
    for (const LevelMean& l : e.levels)
      effect["levels"].push_back({{"value", l.value},
                                  {"place", json_rounded(l.place)},
                                  {"count", l.count},
                                  {"mean", json_rounded(l.mean)},
                                  {"half width", json_rounded(l.half_width)}});
    out["effects"].push_back(effect);
  }
  if (best)
    if (const auto k = best_point(results, best->first, best->second))
      out["best"] = {{"point", *k}, {"number", best->first}, {"largest", best->second}};
  return out;
}

void write_sweep_page(const Json& data, const std::filesystem::path& path) {
  write_atomically(path, report_page("subsoil: " + data["title"].get<std::string>(), data, page_sweep_js));
}

std::string sweep_text(const Study& study, const std::vector<PointResult>& results,
                       const std::optional<std::pair<std::size_t, bool>>& best) {
  std::size_t reached = 0, failed = 0;
  for (const PointResult& r : results)
    reached += r.end == PointResult::End::reached ? 1 : 0, failed += r.end == PointResult::End::failed ? 1 : 0;
  std::string text = fmt::format("{} points: {} reached their end, {} failed, {} not run\n", results.size(), reached,
                                 failed, results.size() - reached - failed);
  for (std::size_t k = 0; k < results.size(); ++k)
    if (results[k].end == PointResult::End::failed)
      text += fmt::format("failed {:04} ({}): {}\n", k + 1, point_words(study, k), results[k].cause);
  for (std::size_t n = 0; n < study.numbers.size(); ++n) text += without_number(study, results, n);
  for (std::size_t n = 0; n < study.numbers.size(); ++n) text += scatter_words(study, results, n);
  for (const Effect& e : effects(study, results))
    if (std::isfinite(e.slope))
      text += fmt::format("{} over {}: {:+.4g} +- {:.2g} from its minimum to its maximum value\n",
                          study.numbers[e.number].name, study.parameters[e.parameter], e.slope, e.slope_half);
  if (best)
    if (const auto k = best_point(results, best->first, best->second))
      text +=
          fmt::format("{} {}: {:.5g} at point {:04} ({})\n", best->second ? "largest" : "least",
                      study.numbers[best->first].name, results[*k].value[best->first], *k + 1, point_words(study, *k));
  return text;
}

}  // namespace subsoil::sim
