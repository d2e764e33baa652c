#include "libsim/report/numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libsim/scenario/towing_drivers.hpp"

namespace subsoil::sim {
namespace {

constexpr double degree = std::numbers::pi / 180;

class QuantityList {
 public:
  explicit QuantityList(const RunFolder& run) : run_(run) {}

  bool add(const std::string& key, const std::string& column) {
    const int found = run_.column(column);
    if (found < 0) return false;
    const auto same = [&](const Quantity& q) { return q.key == key || q.column == column; };
    if (std::any_of(list.begin(), list.end(), same)) return false;
    list.push_back({key, column, run_.series->columns[static_cast<std::size_t>(found)].unit});
    return true;
  }
  /// The first column whose name ends so.
  void add_first(const std::string& ending) {
    for (const SeriesColumn& c : run_.series->columns)
      if (c.name.ends_with(ending) && add(c.name, c.name)) return;
  }
  std::vector<Quantity> list;

 private:
  const RunFolder& run_;
};

/// The machine's body that meets the soil: SHOVEL of the column SHOVEL.soil.Fx.
std::string tool_body(const Series& series) {
  const std::string ending = ".soil.Fx";
  for (const SeriesColumn& c : series.columns)
    if (c.name.ends_with(ending)) return c.name.substr(0, c.name.size() - ending.size());
  return {};
}

void add_spring(const RunFolder& run, QuantityList& out) {
  for (const SeriesColumn& c : run.series->columns)
    if (c.name.ends_with(".length") && out.add("spring force", c.name.substr(0, c.name.size() - 7) + ".force")) return;
}

/// The force of the driver along x; of several each by its name, since no one of them is the pull of the machine.
void add_pull(const RunFolder& run, QuantityList& out) {
  if (!run.scenario || !run.scenario->machine) return;
  std::vector<std::string> towing;
  for (const TowingDriver& d : towing_drivers(*run.scenario->machine)) towing.push_back(d.name);
  const auto& drivers = run.scenario->machine->drivers;
  if (towing.empty() && drivers.size() == 1) towing.push_back(drivers.front().name);  // along a slide
  for (const std::string& name : towing) out.add(towing.size() == 1 ? "pull" : "pull of " + name, name + ".force");
}

double depth_of(const ToolPath& tool) { return *std::max_element(tool.depth.begin(), tool.depth.end()); }

}  // namespace

std::vector<Quantity> quantities(const RunFolder& run) {
  QuantityList out(run);
  if (!run.series) return {};
  if (!out.add("pull", "pull")) add_pull(run, out);
  if (!out.add("draft", "draft")) out.add("draft", "soil.draft");
  if (!out.add("lift", "lift")) out.add("lift", "soil.lift");
  if (!out.add("spring force", "spring force")) add_spring(run, out);
  const std::string body = tool_body(*run.series);
  if (!out.add("pitch", "pitch")) out.add("pitch", body + ".angle");
  if (!out.add("height", "height")) out.add("height", body + ".y");
  for (const SeriesColumn& c : run.series->columns)
    if (c.is_watch()) out.add(c.name, c.name);
  if (out.list.empty() && run.scenario)  // what moves is the tool, and not the first wall of the container
    for (const BoundarySection& b : run.scenario->boundaries)
      if (b.is_moved())
        for (const char* component : {".Fx", ".Fy"}) out.add(b.name + component, b.name + component);
  if (out.list.empty())
    for (const char* component : {".Fx", ".Fy"}) out.add_first(component);
  if (out.list.empty())  // a machine alone that watches nothing
    for (const SeriesColumn& c : run.series->columns)
      if (c.name != "time" && out.list.size() < 6) out.add(c.name, c.name);
  return out.list;
}

std::vector<ReportNumber> numbers_of(const RunFolder& run, const std::vector<Quantity>& all) {
  std::vector<ReportNumber> out;
  if (!run.series) return out;
  const std::vector<double>& time = run.series->at("time");
  for (const Quantity& q : all) {
    const std::vector<double>& values = run.series->at(q.column);
    const RowKind kind = run.kind_of(static_cast<std::size_t>(run.column(q.column)));
    const WindowStatistics s = statistics(time, values, run.window, kind);
    if (s.rows == 0) continue;
    const auto add = [&](const std::string& what, double value, double half, const std::string& unit) {
      out.push_back({q.key, what, unit, value, half, run.window});
    };
    const WindowNumbers n = run.window_numbers(q.column, s);
    add("mean", n.mean, n.half_width, q.unit);
    add("standard deviation of the rows", s.deviation, none, q.unit);
    const std::string of_rows = n.of_steps ? "" : " of the rows";
    add("least" + of_rows, n.least, none, q.unit);
    add("largest" + of_rows, n.largest, none, q.unit);
    add("span" + of_rows, n.largest - n.least, none, q.unit);
    const TimeWindow whole{time.front(), time.back(), "the whole record"};
    const WindowStatistics record = statistics(time, values, whole, kind);
    const auto add_whole = [&](const char* what, double value) {
      out.push_back({q.key, what, q.unit, value, none, whole});
    };
    add_whole("least of all rows", record.least);
    add_whole("largest of all rows", record.largest);
    add_whole("span of all rows", record.largest - record.least);
    if (const SpectralLine line = strongest_line(time, values, run.window, kind); std::isfinite(line.period)) {
      add("period of the strongest line", line.period, none, "s");
      add("amplitude of that line", line.amplitude, none, q.unit);
    }
  }
  return out;
}

std::optional<WindowStatistics> draft_of(const RunFolder& run) {
  if (!run.series) return {};
  for (const char* name : {"draft", "soil.draft"})
    if (const int column = run.column(name); column >= 0) {
      WindowStatistics s = statistics(run.series->at("time"), run.series->values[static_cast<std::size_t>(column)],
                                      run.window, run.kind_of(static_cast<std::size_t>(column)));
      const WindowNumbers n = run.window_numbers(name, s);
      s.mean = n.mean, s.half_width = n.half_width;
      return s;
    }
  return {};
}

std::vector<ToolDraft> drafts_of(const RunFolder& run) {
  std::vector<ToolDraft> out;
  if (!run.series || !run.summary.is_object() || !run.summary.contains("tools")) return out;
  for (const auto& [name, tool] : run.summary["tools"].items()) {
    const std::string direction = run.text({"tools", name, "direction"});
    if (direction.size() != 2) continue;
    const std::string ending = direction[1] == 'x' ? ".Fx" : ".Fz", of_body = name + ".soil" + ending;
    const std::string column = run.column(of_body) >= 0 ? of_body : name + ending;
    const int found = run.column(column);
    WindowStatistics rows;
    if (found >= 0)
      rows = statistics(run.series->at("time"), run.series->values[static_cast<std::size_t>(found)], run.window,
                        run.kind_of(static_cast<std::size_t>(found)));
    const WindowNumbers n = run.window_numbers(column, rows);
    out.push_back({name, direction, direction[0] == '+' ? -n.mean : n.mean, n.half_width});
  }
  return out;
}

std::vector<ReportNumber> numbers_of_soil(const RunFolder& run, const ToolPath& tool,
                                          const std::optional<Furrow>& furrow) {
  std::vector<ReportNumber> out;
  TimeWindow whole{0, none, "frames of the whole record"};
  if (run.series) whole.from = run.series->at("time").front(), whole.until = run.series->at("time").back();
  const auto add = [&](const std::string& quantity, const std::string& what, const std::string& unit, double value,
                       double half, const TimeWindow& window) {
    out.push_back({quantity, what, unit, value, half, window});
  };
  const double depth = depth_of(tool);
  add("tool", "greatest depth of the tip", "m", depth, none, whole);
  add("tool", "width in the soil", "m", tool.width, none, whole);
  if (tool.shanks.size() > 1)
    add("tool", "tools that stand apart in it", "1", static_cast<double>(tool.shanks.size()), none, whole);
  add("tool", "mean speed of travel", "m/s", tool.speed, none, whole);
  if (!furrow) return out;
  TimeWindow ends = whole;
  ends.rule = fmt::format("first frame to last, stretch {} = {:.3f} ... {:.3f} m{}", furrow->along, furrow->from,
                          furrow->until, furrow->steady ? "" : ", which is not of steady work");
  add("furrow", "area below the surface", "m^2", furrow->furrow_area, none, ends);
  add("furrow", "area of the heaps", "m^2", furrow->heap_area, none, ends);
  add("furrow", "largest heave", "m", furrow->heave, none, ends);
  add("furrow", "largest drop of the surface", "m", furrow->depth, none, ends);
  add("furrow", "ridge to ridge", "m", furrow->ridge_to_ridge, none, ends);
  add("furrow", "disturbed area", "m^2", furrow->disturbed_area, none, ends);
  add("furrow", "loosened area", "m^2", furrow->loosened_area, none, ends);
  add("furrow", "swell over the disturbed area", "1", furrow->swell, none, ends);
  if (const SpecificDraft specific = specific_draft(tool, *furrow, drafts_of(run), run.window);
      std::isfinite(specific.value))
    add("specific draft", "mean draft over disturbed area", "N/m^2", specific.value, specific.half_width, run.window);
  return out;
}

std::vector<ReportNumber> numbers_of_fibres(const RunFolder& run) {
  std::vector<ReportNumber> out;
  if (!run.summary.is_object() || !run.summary.contains("fibres") || !run.summary["fibres"].is_object()) return out;
  const double begin = run.series ? run.series->at("time").front() : 0, end = run.number({"run", "simulated [s]"});
  for (const auto& [name, fibres] : run.summary["fibres"].items()) {
    const auto add = [&](const std::string& what, const char* unit, const std::vector<std::string>& keys, bool at_end) {
      std::vector<std::string> path{"fibres", name, at_end ? "at the end" : "at the start"};
      path.insert(path.end(), keys.begin(), keys.end());
      const double value = run.number(path), at = at_end ? end : begin;
      if (std::isfinite(value))
        out.push_back({"fibres " + name, what, unit, value, none, {at, at, at_end ? "the last instant" : "the first"}});
    };
    add("mass", "kg", {"mass [kg]"}, true);
    add("share buried at the start", "1", {"buried share"}, false);
    add("share buried at the end", "1", {"buried share"}, true);
    add("mass on the surface at the end", "kg", {"on the surface [kg]"}, true);
    add("mean depth of what is buried", "m", {"mean depth of what is buried [m]"}, true);
    const Json& bands = fibres.contains("at the end") ? fibres["at the end"].value("by depth", Json::array()) : Json();
    for (const Json& band : bands)
      if (const double share = band.value("share", 0.0); share > 0) {
        const double from = band.value("from [m]", 0.0);
        const std::string until = band["to [m]"].is_number()
                                      ? fmt::format(" to {:.0f} mm", 1e3 * band["to [m]"].get<double>())
                                      : " mm and more";
        out.push_back({"fibres " + name,
                       fmt::format("share at depths of {:.0f}{}", 1e3 * from, until),
                       "1",
                       share,
                       none,
                       {end, end, "the last instant"}});
      }
    add("angle to the horizontal at the start", "rad", {"angle to the horizontal [rad]"}, false);
    add("angle to the horizontal at the end", "rad", {"angle to the horizontal [rad]"}, true);
    add("angle to x at the end", "rad", {"angle to x [rad]"}, true);
    add("nematic order at the end", "1", {"nematic order"}, true);
    add("broken bonds", "1", {"broken bonds"}, true);
    add("bonds cut by edges", "1", {"cut by edges"}, true);
    if (!fibres.contains("force on surfaces [N]")) continue;
    for (const auto& [surface, force] : fibres["force on surfaces [N]"].items())
      for (std::size_t d = 0; d < 3; ++d)
        if (const Json& mean = force.value("mean of frames", Json::array()); mean.size() == 3 && mean[d].is_number())
          out.push_back(
              {"fibres " + name,
               fmt::format("force on {} along {}, mean of {} frames", surface, "xyz"[d], force.value("frames", 0)), "N",
               mean[d].get<double>(), none, run.window});
  }
  return out;
}

namespace {

/// Formulas of draft are of a tool that is drawn along: why there is none, or empty. A tool that turns in place or goes
/// down has a depth too, and so has one whose failure wedge, about as long as it is deep, has not formed yet.
std::string no_draft(const std::optional<ToolPath>& tool) {
  if (!tool) return "needs the depth, width, rake and speed of a tool: none was found in the frames";
  const double depth = depth_of(*tool);
  if (tool->travel >= depth) return {};
  return fmt::format("is of a tool that travels: this one's tip went {:.0f} mm along, less than it is deep, {:.0f} mm",
                     1e3 * tool->travel, 1e3 * depth);
}

double known_error(double error) { return std::isfinite(error) ? error : 0; }

/// "12.30 +- 0.40 kPa"; of a value without a known error, that.
std::string with_error(double value, double error, int digits, const char* unit) {
  if (!std::isfinite(error)) return fmt::format("{:.{}f} {} (error not known)", value, digits, unit);
  return fmt::format("{:.{}f} +- {:.{}f} {}", value, digits, error, digits, unit);
}

/// "127", or "25 + 25" of shanks that stand apart; mm.
std::string widths_text(const ToolPath& tool) {
  std::string text;
  for (const Shank& s : tool.shanks) text += fmt::format("{}{:.0f}", text.empty() ? "" : " + ", 1e3 * s.width());
  return text;
}
/// "60", or "60 + 50" of shanks that do not reach as deep; mm.
std::string depths_text(const ToolPath& tool) {
  std::string one, all;
  bool alike = true;
  for (const Shank& s : tool.shanks) {
    const std::string text = fmt::format("{:.0f}", 1e3 * s.depth);
    alike = alike && (one.empty() || one == text);
    one = text, all += (all.empty() ? "" : " + ") + text;
  }
  return alike ? one : all;
}

ModelBand asabe(const std::optional<ToolPath>& tool) {
  ModelBand out{"ASABE D497, narrow-point subsoiler", {}, no_draft(tool)};
  if (!out.text.empty()) return out;
  const std::size_t tools = tool->shanks.size();
  Band all;
  for (const Shank& shank : tool->shanks) {
    const Band each = asabe_subsoiler(shank.depth, tool->speed);
    all.low += each.low, all.high += each.high;
  }
  out.band = all;
  out.text = fmt::format("{} tool{}, depth {} mm, {:.2f} m/s; coarse soil - 50 % to fine soil + 50 %", tools,
                         tools == 1 ? "" : "s", depths_text(*tool), tool->speed);
  return out;
}

/// Least and largest over the corners of rake, cohesion and friction angle.
ModelBand mckyes(const RunFolder& run, const std::optional<ToolPath>& tool, const std::optional<SoilStrength>& given) {
  ModelBand out{"McKyes-Ali narrow tine", {}, no_draft(tool)};
  if (!out.text.empty()) return out;
  const double density = run.number({"soil", "bulk density [kg/m3]"});
  if (!given)
    out.text =
        "needs the soil's cohesion and friction angle: give --shear FOLDER of `subsoil test shear`, "
        "or --cohesion and --friction-angle";
  else if (!std::isfinite(density))
    out.text = "needs the soil's bulk density, which stands in summary.json";
  else if (!(tool->rake_high > tool->rake_low || tool->rake_high > 0))
    out.text = "needs a rake: the tool has no front face";
  if (!out.text.empty()) return out;
  Band band{std::numeric_limits<double>::infinity(), 0};
  bool vertical = false;  // no wedge ahead
  for (const double steep : {0.0, 0.5, 1.0})
    for (const double c : {-1.0, 1.0})
      for (const double f : {-1.0, 1.0}) {
        WedgeSoil soil{.density = density,
                       .cohesion = std::max(0.0, given->cohesion + c * known_error(given->cohesion_error)),
                       .friction = std::max(0.0, given->friction + f * known_error(given->friction_error)),
                       .adhesion = given->adhesion};
        soil.wall_friction = given->wall_friction.value_or(2.0 / 3 * soil.friction);
        double draft = 0;  // of shanks that stand apart the sum: their wedges are taken not to meet
        for (const Shank& shank : tool->shanks) {
          const double rake = shank.rake_low + steep * (shank.rake_high - shank.rake_low);
          vertical = vertical || mckyes_ali_rupture(soil, shank.width(), shank.depth, rake) > 89 * degree;
          draft += mckyes_ali(soil, shank.width(), shank.depth, rake);
        }
        if (!std::isfinite(draft)) continue;
        band.low = std::min(band.low, draft), band.high = std::max(band.high, draft);
      }
  if (band.low > band.high) {
    out.text = "gives nothing for this rake and soil";
    return out;
  }
  out.band = band;
  out.text =
      fmt::format("c {}, phi {}, delta {}, {:.0f} kg/m3, width {} mm, depth {} mm, rake {:.0f} to {:.0f} deg",
                  with_error(given->cohesion * 1e-3, given->cohesion_error * 1e-3, 2, "kPa"),
                  with_error(given->friction / degree, given->friction_error / degree, 1, "deg"),
                  given->wall_friction ? fmt::format("{:.1f} deg", *given->wall_friction / degree) : "2/3 phi", density,
                  widths_text(*tool), depths_text(*tool), tool->rake_low / degree, tool->rake_high / degree);
  if (vertical) out.text += "; at the minimum rake no wedge forms ahead: the lower end is a bound";
  return out;
}

}  // namespace

std::vector<ModelBand> model_bands(const RunFolder& run, const std::optional<ToolPath>& tool,
                                   const std::optional<SoilStrength>& soil) {
  if (!draft_of(run)) return {};  // nothing to set them beside
  return {asabe(tool), mckyes(run, tool, soil)};
}

}  // namespace subsoil::sim
