#include "libsim/report/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>

#include "libsim/base/version.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/post/disturbance.hpp"
#include "libsim/post/unit_factor.hpp"
#include "libsim/report/page.hpp"
#include "libsim/view/page.hpp"
#include "libsim/view/view.hpp"

namespace subsoil::sim {
namespace {

constexpr std::size_t most_rows = 6000;  // of a curve on the page
constexpr double film_bytes = 12e6;      // of the spheres of all runs: a page that can be mailed

Json numbers(const std::vector<double>& values, double factor = 1) {
  Json out = Json::array();
  for (const double v : values) out.push_back(json_rounded(factor * v));
  return out;
}

Json window_json(const TimeWindow& w) {
  return {{"from", json_rounded(w.from)}, {"until", json_rounded(w.until)}, {"rule", w.rule}};
}

/// Six numbers of Yuan & Yu 2020, figures 5 and 6, conclusions; docs/1s300.md.
struct SourceNumber {
  const char* quantity;
  const char* statistic;
  const char* unit;
  double value;
};
constexpr SourceNumber source_numbers[] = {
    {"pull", "largest of all rows", "N", 1493},         {"pull", "least of all rows", "N", -331},
    {"spring force", "largest of all rows", "N", 2623}, {"spring force", "least of all rows", "N", -2231},
    {"pitch", "span of all rows", "rad", 0.11},         {"height", "span of all rows", "m", 0.181}};

/// Rows of the series that the page draws: of a long one every so-many-th.
std::size_t stride_of(const Series& series) { return (series.rows() + most_rows - 1) / most_rows; }

std::vector<double> thinned(const std::vector<double>& values, std::size_t stride) {
  std::vector<double> out;
  for (std::size_t i = 0; i < values.size(); i += stride) out.push_back(values[i]);
  return out;
}

/// Columns that are rounding beside others of their unit are zero: a chart would be scaled to 1e-20 N, and a table
/// would state it.
void drop_rounding(Series& series) {
  constexpr double share = 1e-12;  // a hundred times what sums of doubles leave of what cancels in them
  const auto largest_of = [&](std::size_t c) {
    double most = 0;
    for (const double v : series.values[c])
      if (std::isfinite(v)) most = std::max(most, std::abs(v));
    return most;
  };
  std::map<std::string, double> of_unit;
  for (std::size_t c = 0; c < series.columns.size(); ++c) {
    double& most = of_unit[series.columns[c].unit];
    most = std::max(most, largest_of(c));
  }
  for (std::size_t c = 0; c < series.columns.size(); ++c)
    if (largest_of(c) <= share * of_unit[series.columns[c].unit])
      for (double& v : series.values[c])
        if (std::isfinite(v)) v = 0;
}

Json curves_json(const RunFolder& run, const std::vector<Quantity>& all) {
  Json out;
  const Series& series = *run.series;
  const std::size_t stride = stride_of(series);
  out["every"] = stride;
  out["time"] = numbers(thinned(series.at("time"), stride));
  out["columns"] = Json::array();
  for (const Quantity& q : all)
    out["columns"].push_back({{"key", q.key},
                              {"column", q.column},
                              {"unit", q.unit},
                              {"values", numbers(thinned(series.at(q.column), stride))}});
  return out;
}

/// The energy columns that move, J.
Json energy_curves(const RunFolder& run) {
  Json out = Json::array();
  const Series& series = *run.series;
  const std::size_t stride = std::max<std::size_t>(1, series.rows() / 1000);
  for (std::size_t c = 0; c < series.columns.size(); ++c) {
    if (series.columns[c].unit != "J") continue;
    const auto [low, high] = std::minmax_element(series.values[c].begin(), series.values[c].end());
    if (!(*high - *low > 0)) continue;
    out.push_back({{"key", series.columns[c].name}, {"values", numbers(thinned(series.values[c], stride))}});
  }
  if (out.empty()) return nullptr;
  return {{"time", numbers(thinned(series.at("time"), stride))}, {"columns", out}};
}

Json head_json(const RunFolder& run) {
  Json out = Json::array();
  const auto add = [&](const char* name, const std::string& text) {
    if (!text.empty()) out.push_back({name, text});
  };
  const auto amount = [&](const std::vector<std::string>& keys, const char* format, double factor = 1) {
    const double v = run.number(keys);
    return std::isfinite(v) ? fmt::format(fmt::runtime(format), v * factor) : std::string();
  };
  add("scenario", run.text({"run", "scenario"}));
  std::string sets;
  if (run.summary.is_object() && run.summary.contains("run") && run.summary["run"].contains("set"))
    for (const auto& set : run.summary["run"]["set"])
      if (set.is_string()) sets += (sets.empty() ? "" : "; ") + set.get<std::string>();
  add("changed by --set", sets);
  add("version", run.text({"run", "version"}));
  std::string end = run.text({"run", "end"});
  if (const std::string failure = run.text({"run", "failure"}); !failure.empty()) end += ": " + failure;
  add("end", end);
  add("simulated", amount({"run", "simulated [s]"}, "{:.4g} s"));
  add("spheres", amount({"soil", "spheres"}, "{:.0f}"));
  add("bulk density", amount({"soil", "bulk density [kg/m3]"}, "{:.0f} kg/m3"));
  add("soil step", amount({"run", "soil step [s]"}, "{:.4g} s") +
                       amount({"run", "soil step over stable step"}, ", {:.2f} of the stable step"));
  add("largest overlap", amount({"run", "largest overlap [share of a radius]"}, "{:.2f} radii"));
  add("computer", amount({"run", "threads"}, "{:.0f} threads, ") + run.text({"run", "instruction set"}) +
                      (run.text({"run", "precision"}).empty() ? "" : ", " + run.text({"run", "precision"})));
  add("cost", amount({"run", "wall time [s]"}, "{:.1f} s of wall time") + amount({"run", "steps"}, ", {:.0f} steps") +
                  amount({"run", "particle-steps per second"}, ", {:.1f} M particle-steps/s", 1e-6) +
                  amount({"run", "peak memory [bytes]"}, ", {:.0f} MB of memory", 1e-6));
  if (run.scenario && run.scenario->machine)
    add("machine", fmt::format("{} bodies, {} joints, {} drivers, {} forces", run.scenario->machine->bodies.size(),
                               run.scenario->machine->joints.size(), run.scenario->machine->drivers.size(),
                               run.scenario->machine->forces.size()));
  add("window", std::isfinite(run.window.until)
                    ? fmt::format("{:.4g} ... {:.4g} s ({})", run.window.from, run.window.until, run.window.rule)
                    : std::string());
  return out;
}

Json reaches_wall(const Json& summary) {
  if (!summary.is_object() || !summary.contains("disturbance")) return {};
  const Json& disturbance = summary["disturbance"];
  return disturbance.is_object() && disturbance.contains(reaches_wall_key) ? disturbance[reaches_wall_key] : Json();
}

/// @param reaches_wall as the run's summary says; null where that does not know
Json furrow_json(const Furrow& f, const Json& reaches_wall) {
  Json layers = Json::array();
  for (const LayerMotion& l : f.layers)
    layers.push_back({{"name", l.name},
                      {"spheres", l.spheres},
                      {"rise", json_rounded(l.rise)},
                      {"forward", json_rounded(l.forward)},
                      {"aside", json_rounded(l.aside)},
                      {"moved out", json_rounded(l.moved_out)}});
  return {{"steady", f.steady},
          {"from", json_rounded(f.from)},
          {"until", json_rounded(f.until)},
          {"cell", json_rounded(f.cell)},
          {"column", json_rounded(f.column)},
          {"along", std::string(1, f.along)},
          {"across", std::string(1, f.across)},
          {"z", numbers(f.z)},
          {"before", numbers(f.before)},
          {"after", numbers(f.after)},
          {"threshold", json_rounded(f.threshold)},
          {"rows", f.rows},
          {"columns", f.columns},
          {"y0", json_rounded(f.y0)},
          {"z0", json_rounded(f.z0)},
          {"moved", numbers(f.moved)},
          {"reaches wall", reaches_wall},
          {"layers", layers}};
}

Json rows_json(const std::vector<ReportNumber>& list) {
  Json out = Json::array();
  for (const ReportNumber& n : list)
    out.push_back({{"quantity", n.quantity},
                   {"statistic", n.statistic},
                   {"unit", n.unit},
                   {"value", json_rounded(n.value)},
                   {"half width", json_rounded(n.half_width)},
                   {"window", window_json(n.window)}});
  return out;
}

/// Instants of the stills: three over the approach, the middle and the end of the window.
std::vector<double> still_times(const RunFolder& run, const std::vector<double>& times) {
  if (times.empty()) return {};
  const double first = times.front(), last = times.back();
  const double from = std::clamp(run.window.from, first, last), until = std::clamp(run.window.until, from, last);
  std::vector<double> out;
  for (const double t :
       {first, 0.5 * (first + from), from, from + 0.33 * (until - from), from + 0.67 * (until - from), until})
    if (out.empty() || t > out.back() + 1e-9) out.push_back(t);
  return out;
}

/// One run of a report: what it gives as data and as numbers.
struct RunPart {
  RunFolder folder;
  std::vector<ReportNumber> list;
  Json json;
};

class RunReader {
 public:
  RunReader(const ReportRequest& request, RunFolder folder) : request_(request), part_{std::move(folder), {}, {}} {}

  RunPart read() {
    RunFolder& run = part_.folder;
    if (run.series) drop_rounding(*run.series);
    const std::vector<Quantity> all = quantities(run);
    part_.list = numbers_of(run, all);
    if (run.series) {
      part_.json["curves"] = curves_json(run, all);
      part_.json["energy curves"] = energy_curves(run);
    }
    std::optional<ToolPath> tool;
    if (run.series) part_.json["stills"] = numbers(still_times(run, run.series->at("time")));
    if (run.frames) tool = read_frames();
    const std::vector<ReportNumber> fibres = numbers_of_fibres(run);
    part_.list.insert(part_.list.end(), fibres.begin(), fibres.end());
    take_scene();
    if (request_.soil && !draft_of(run))
      run.missing.push_back(
          "models of the draft: the series has no column draft or soil.draft to set them beside; monitor the force of "
          "the soil on the tool as `draft`");
    for (const ModelBand& m : model_bands(run, tool, request_.soil)) {
      Json band{{"name", m.name}, {"text", m.text}};
      if (m.band) band["low"] = json_rounded(m.band->low), band["high"] = json_rounded(m.band->high);
      part_.json["bands"].push_back(band);
    }
    Json& out = part_.json;
    out["name"] = run.name;
    out["title"] = run.scenario ? run.scenario->title : run.text({"run", "title"});
    out["head"] = head_json(run);
    out["window"] = window_json(run.window);
    out["energy"] = run.summary.is_object() && run.summary.contains("energy") ? run.summary["energy"] : Json();
    out["warnings"] =
        run.summary.is_object() && run.summary.contains("warnings") ? run.summary["warnings"] : Json::array();
    out["missing"] = run.missing;
    out["numbers"] = rows_json(part_.list);
    return std::move(part_);
  }

 private:
  std::optional<ToolPath> read_frames() {
    RunFolder& run = part_.folder;
    try {
      const FramesFile file(run.path / "run.h5");
      if (file.times().empty()) throw std::runtime_error("holds no complete frame");
      if (request_.slice_given) refuse_slice_outside(file);
      const Scenario* const scenario = run.scenario ? &*run.scenario : nullptr;
      const Disturbance found =
          disturbance_of(file, scenario, soil_surface(run.number({"soil", "mean surface [m]"}), scenario, file),
                         run.number({"window", "from [s]"}));
      const std::optional<ToolPath>& tool = found.tool;
      part_.json["slice"] = slice(file, tool);
      part_.json["stills"] = numbers(still_times(run, file.times()));
      take_furrow(file, found);
      return tool;
    } catch (const SliceFault&) {
      throw;
    } catch (const std::exception& error) {
      run.missing.push_back(fmt::format("run.h5: {}; no spheres, no furrow", error.what()));
      return {};
    }
  }

  struct SliceFault : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
  };
  /// A section beside the spheres of the first frame would be an empty picture.
  void refuse_slice_outside(const FramesFile& file) const {
    const std::size_t first[] = {0};
    const dem::Bounds box = file.extent(first, true);
    if (!box.empty() && !(request_.slice >= box.low.z && request_.slice <= box.high.z))
      throw SliceFault(fmt::format("--slice {:.6g} m: is outside the bed of {}, which goes from z = {:.4g} to {:.4g} m",
                                   request_.slice, part_.folder.path.string(), box.low.z, box.high.z));
  }

  /// z of the section along x through the tool, m; null: through the middle of the bed.
  Json slice(const FramesFile& file, const std::optional<ToolPath>& tool) const {
    if (request_.slice_given) return request_.slice;
    if (file.particles() > 0 && tool && tool->axis == 0) return json_rounded(tool->middle);
    return {};
  }

  void take_scene() {
    try {
      ViewRequest view;
      view.run = part_.folder.path, view.bytes = film_bytes / static_cast<double>(request_.runs.size());
      part_.json["scene"] = view_scene(view);
    } catch (const std::exception& error) {
      part_.folder.missing.push_back(fmt::format("{}; no film, no still frames", error.what()));
    }
  }

  void take_furrow(const FramesFile& file, const Disturbance& found) {
    if (!found.tool) {
      if (file.particles() > 0)
        part_.folder.missing.push_back("tool in the soil: no moving surface comes below the soil's surface; no furrow");
      return;
    }
    if (found.furrow)
      part_.json["furrow"] = furrow_json(*found.furrow, reaches_wall(part_.folder.summary));
    else
      part_.folder.missing.push_back("furrow: " + found.why);
    const std::vector<ReportNumber> more = numbers_of_soil(part_.folder, *found.tool, found.furrow);
    part_.list.insert(part_.list.end(), more.begin(), more.end());
  }

  const ReportRequest& request_;
  RunPart part_;
};

/// Numbers and curves of a later run in the units of the first, which monitors may set otherwise in each. What has
/// another dimension is another quantity.
void take_units_of(const RunPart& first, RunPart& part) {
  for (ReportNumber& n : part.list) {
    const auto same =
        std::find_if(first.list.begin(), first.list.end(), [&](const ReportNumber& f) { return f.name() == n.name(); });
    if (same == first.list.end() || same->unit == n.unit) continue;
    if (const std::optional<double> factor = unit_factor(n.unit, same->unit))
      n.value *= *factor, n.half_width *= *factor, n.unit = same->unit;
    else
      n.statistic += " in " + n.unit;
  }
  part.json["numbers"] = rows_json(part.list);
  if (!part.json.contains("curves") || !first.json.contains("curves")) return;
  for (Json& curve : part.json["curves"]["columns"])
    for (const Json& same : first.json["curves"]["columns"]) {
      if (same["key"] != curve["key"] || same["unit"] == curve["unit"]) continue;
      if (const std::optional<double> factor = unit_factor(curve["unit"], same["unit"])) {
        for (Json& v : curve["values"])
          if (v.is_number()) v = v.get<double>() * *factor;
        curve["unit"] = same["unit"];
      } else {
        curve["key"] = curve["key"].get<std::string>() + " in " + curve["unit"].get<std::string>();
      }
    }
}

/// The machine-readable table: a row per number, run by run side by side, differences against the first.
Json table_json(const std::vector<RunPart>& parts, bool source) {
  std::vector<std::pair<std::string, const ReportNumber*>> order;
  for (const RunPart& part : parts)
    for (const ReportNumber& n : part.list)
      if (std::none_of(order.begin(), order.end(), [&](const auto& o) { return o.first == n.name(); }))
        order.emplace_back(n.name(), &n);
  Json rows = Json::array();
  for (const auto& [name, sample] : order) {
    Json row{{"quantity", sample->quantity}, {"statistic", sample->statistic}, {"unit", sample->unit}};
    const ReportNumber* first = nullptr;
    for (std::size_t r = 0; r < parts.size(); ++r) {
      const auto& list = parts[r].list;
      const auto found =
          std::find_if(list.begin(), list.end(), [&](const ReportNumber& n) { return n.name() == name; });
      Json cell{{"run", parts[r].folder.name}};
      if (found != list.end()) {
        cell["value"] = json_rounded(found->value), cell["half width"] = json_rounded(found->half_width);
        cell["from [s]"] = json_rounded(found->window.from), cell["until [s]"] = json_rounded(found->window.until);
        if (first != nullptr) {
          cell["difference"] = json_rounded(found->value - first->value);
          cell["difference half width"] = json_rounded(std::hypot(found->half_width, first->half_width));
        }
        if (r == 0) first = &*found;
      }
      row["runs"].push_back(cell);
    }
    if (source)
      for (const SourceNumber& s : source_numbers)
        if (sample->quantity == s.quantity && sample->statistic == s.statistic) row["source"] = s.value;
    rows.push_back(row);
  }
  return rows;
}

Json source_json() {
  Json out = Json::array();
  for (const SourceNumber& s : source_numbers)
    out.push_back({{"quantity", s.quantity}, {"statistic", s.statistic}, {"unit", s.unit}, {"value", s.value}});
  return out;
}

}  // namespace

Json report_data(const ReportRequest& request) {
  if (request.runs.empty()) throw std::invalid_argument("nothing to report: name at least one result directory");
  std::vector<RunPart> parts;
  std::map<std::string, int> names;
  for (const auto& path : request.runs) {
    RunFolder folder = read_run_folder(path);
    if (request.from || request.until) {
      const double end = folder.series ? folder.series->at("time").back() : folder.window.until;
      folder.window.from = request.from.value_or(folder.window.from);
      if (request.until) folder.window.until = *request.until;
      if (!request.until && folder.window.until <= folder.window.from) folder.window.until = end;
      if (folder.window.until > end * (1 + 1e-9))
        throw std::invalid_argument(
            fmt::format("--until {}: the record of {} ends at {:.6g} s", folder.window.until, folder.name, end));
      folder.window.rule = "given by --from and --until";
      if (!(folder.window.until > folder.window.from))
        throw std::invalid_argument(fmt::format("--from {} --until {}: the window ends before it begins",
                                                folder.window.from, folder.window.until));
    }
    if (const int n = ++names[folder.name]; n > 1) folder.name += fmt::format(" ({})", n);
    parts.push_back(RunReader(request, std::move(folder)).read());
    if (parts.size() > 1) take_units_of(parts.front(), parts.back());
  }
  Json data{{"format", "subsoil report 1"}, {"version", version()}};
  data["source"] = request.source ? source_json() : Json();
  data["runs"] = Json::array();
  data["table"] = table_json(parts, request.source);
  for (RunPart& part : parts) data["runs"].push_back(std::move(part.json));
  return data;
}

void write_report(const ReportRequest& request) {
  const Json data = report_data(request);
  std::string title;
  for (const auto& run : data["runs"]) title += (title.empty() ? "" : ", ") + run["name"].get<std::string>();
  write_atomically(request.out,
                   report_page("subsoil: " + title, data, page_report_js, {{"viewer", scene_page_frame()}}));
  for (const auto& run : data["runs"])
    for (const auto& line : run["missing"])
      fmt::print(stderr, "{}: {}\n", run["name"].get<std::string>(), line.get<std::string>());
}

SoilStrength read_strength(const std::filesystem::path& folder) {
  const std::filesystem::path path = std::filesystem::is_directory(folder) ? folder / "shear.csv" : folder;
  std::ifstream file(path);
  if (!file)
    throw std::invalid_argument(path.string() + ": is not there; `subsoil test shear SCENARIO --out FOLDER` writes it");
  SoilStrength out;
  bool cohesion = false, friction = false;
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> fields = csv::split(line);
    double mean = 0, error = 0;
    if (fields.size() < 4 || !csv::to_number(fields[2], mean)) continue;
    if (!csv::to_number(fields[3], error)) error = SoilStrength::unknown;  // of one packing there is none
    if (fields[0] == "cohesion") out.cohesion = mean, out.cohesion_error = error, cohesion = true;
    if (fields[0] == "friction angle") out.friction = mean, out.friction_error = error, friction = true;
  }
  if (!cohesion || !friction)
    throw std::invalid_argument(path.string() +
                                ": has no rows `cohesion` and `friction angle`; `subsoil test shear` "
                                "writes them");
  return out;
}

}  // namespace subsoil::sim
