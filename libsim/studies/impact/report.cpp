#include "libsim/studies/impact/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "libdem/laws/hertz_mindlin.hpp"
#include "libdem/laws/hunt_crossley.hpp"
#include "libdem/laws/hysteretic.hpp"
#include "libdem/laws/jkr.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/series.hpp"
#include "libsim/io/series_writer.hpp"
#include "libsim/plot/plot.hpp"
#include "libsim/studies/impact/results_file.hpp"

namespace subsoil::sim {
namespace {

using dem::impact::Event;
using Quantity = ImpactQuantity;

std::string label(const Quantity& q) { return fmt::format("{} [{}]", q.name, q.unit); }

/// A sphere for the bed when the model needs no shape: its radius is only the moment arm of a friction that is not
/// there, and large beside the indentation.
dem::impact::Strikers shaped(dem::impact::Strikers bodies, double largest) {
  if (std::isfinite(bodies.radius())) return bodies;
  bodies.radius_1 = 1e3 * largest;
  return bodies;
}

/// The bodies that the bed strikes: JKR's attraction goes with the radius of the pair, whatever bodies have it.
dem::impact::Strikers bodies_for(const dem::Law& law, const ImpactStudy& study, const dem::impact::Pair& pair,
                                 double largest) {
  if (law.get_if<dem::Jkr>() != nullptr) return {.mass_1 = pair.mass, .radius_1 = pair.radius};
  return shaped(strikers_of(study), largest);
}

/// Whether the engine has stepped any of the events: not those in which the bodies stay together.
bool any_stepped(const std::vector<ImpactRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const ImpactRow& row) { return row.stepped.has_value(); });
}

Series course_of(const Event& e) {
  Series series{{{"time", "s"}, {"indentation", "m"}, {"speed", "m/s"}, {"force", "N"}}, {{}, {}, {}, {}}};
  for (const dem::impact::Sample& s : e.course) {
    const double values[] = {s.t, s.x, s.v, s.f};
    for (std::size_t k = 0; k < 4; ++k) series.values[k].push_back(values[k]);
  }
  return series;
}

void write_course(const std::filesystem::path& path, const Event& e) {
  const Series course = course_of(e);
  SeriesWriter writer(path, course.columns, csv::exact_digits);
  for (const dem::impact::Sample& s : e.course) writer.write(std::array{s.t, s.x, s.v, s.f});
}

std::string title_of(const ImpactStudy& study) { return model_word(study); }

}  // namespace

const std::vector<ImpactQuantity>& impact_quantities(const ImpactStudy& study) {
  static const std::vector<ImpactQuantity> usual{
      {"largest indentation", "m", [](const Event& e) { return e.largest; }},
      {"peak force", "N", [](const Event& e) { return e.peak_force; }},
      {"time of peak force", "s", [](const Event& e) { return e.peak_time; }},
      {"duration of compression", "s", [](const Event& e) { return e.time_in; }},
      {"duration of restitution", "s", [](const Event& e) { return e.time_out; }},
      {"duration", "s", [](const Event& e) { return e.duration(); }},
      {"rebound", "m/s", [](const Event& e) { return e.rebound; }},
      {"restitution", "1", [](const Event& e) { return e.restitution; }},
      {"lost energy", "J", [](const Event& e) { return e.lost; }},
  };
  static const std::vector<ImpactQuantity> of_ground = [] {
    std::vector<ImpactQuantity> all = usual;
    all.push_back({"lost at touch", "J", [](const Event& e) { return e.at_touch; }});
    all.push_back({"into the ground", "J", [](const Event& e) { return e.in_ground; }});
    return all;
  }();
  return std::holds_alternative<GroundImpact>(study.model) ? of_ground : usual;
}

std::optional<dem::Law> law_of(const ImpactModel& model, const dem::impact::Pair& pair, double speed) {
  dem::HuntCrossley law;
  law.friction.mu = law.friction.mu_r = 0;
  if (const auto* m = std::get_if<dem::impact::HuntCrossleyModel>(&model)) {
    law.impact = *m;
  } else if (const auto* m = std::get_if<dem::impact::EnergyEquivalent>(&model)) {
    law.impact.restitution = m->restitution_at(pair, speed), law.impact.at_speed = speed;
  } else if (std::holds_alternative<dem::impact::Hertz>(model)) {
    dem::HertzMindlin hertz;
    hertz.E_eff = pair.E_eff, hertz.G_eff = pair.E_eff, hertz.restitution = 1;  // G has no part without friction
    hertz.friction.mu = 0;
    return hertz;
  } else if (const auto* m = std::get_if<dem::impact::Jkr>(&model)) {
    dem::Jkr jkr;
    jkr.E_eff = jkr.G_eff = pair.E_eff, jkr.work = m->w, jkr.restitution = 1;
    jkr.friction.mu = 0;
    return jkr;
  } else if (const auto* m = std::get_if<dem::impact::Hysteretic>(&model)) {
    dem::Hysteretic spring;
    spring.K1 = m->loading(pair), spring.restitution = m->restitution_at(pair, speed);
    spring.friction.mu = 0;
    return spring;
  } else {
    return {};
  }
  // The pair's stiffness as a number: the radius that the bed sees may not be the one it comes from.
  law.impact.c = law.impact.stiffness(pair);
  return law;
}

std::vector<ImpactRow> strike_all(const LoadedStudy& loaded) {
  const ImpactStudy& s = loaded.study;
  const dem::impact::Pair pair = pair_of(s);
  std::vector<ImpactRow> rows;
  try {
    for (const double speed : s.speeds) {
      ImpactRow row;
      row.closed =
          std::visit([&](const auto& m) { return m.strike(pair, speed, static_cast<int>(s.samples)); }, s.model);
      const auto law = s.steps > 0 ? law_of(s.model, pair, speed) : std::nullopt;
      if (law && !row.closed.sticks)
        row.stepped = strike_in_bed(*law, bodies_for(*law, s, pair, row.closed.largest), speed,
                                    row.closed.time_in / static_cast<double>(s.steps));
      rows.push_back(std::move(row));
    }
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(loaded.where("model") + ": " + error.what());
  }
  return rows;
}

std::string impact_table(const ImpactStudy& study, const std::vector<ImpactRow>& rows) {
  std::string text =
      fmt::format("{}, effective mass {:.6g} kg\n{:<28}", title_of(study), pair_of(study).mass, "speed [m/s]");
  for (const ImpactRow& row : rows) text += fmt::format(" {:>18.10g}", row.closed.speed);
  for (const Quantity& q : impact_quantities(study)) {
    text += fmt::format("\n{:<28}", label(q));
    for (const ImpactRow& row : rows) text += fmt::format(" {:>18.11g}", q.of(row.closed));
  }
  if (any_stepped(rows)) {
    text += fmt::format("\nthe engine in {} steps of compression, relative difference\n", study.steps);
    for (const Quantity& q : impact_quantities(study)) {
      text += fmt::format("{:<28}", std::string("  ") + q.name);
      for (const ImpactRow& row : rows) {
        const double closed = q.of(row.closed);
        text += closed == 0 || !row.stepped ? fmt::format(" {:>18}", "-")
                                            : fmt::format(" {:>18.1e}", (q.of(*row.stepped) - closed) / closed);
      }
      text += '\n';
    }
  } else {
    text += '\n';
  }
  for (const ImpactRow& row : rows)
    if (row.closed.sticks) text += fmt::format("at {:g} m/s the bodies stay together\n", row.closed.speed);
  return text;
}

void write_impact(const ImpactStudy& study, const std::vector<ImpactRow>& rows, const std::filesystem::path& folder,
                  const std::string& pictures) {
  std::filesystem::create_directories(folder);
  std::vector<SeriesColumn> columns{{"speed", "m/s"}};
  for (const Quantity& q : impact_quantities(study)) columns.push_back({q.name, q.unit});
  const bool stepped = any_stepped(rows);
  if (stepped)
    for (const Quantity& q : impact_quantities(study)) columns.push_back({std::string("stepped ") + q.name, q.unit});
  SeriesWriter table(folder / "impact.csv", columns, csv::exact_digits);
  std::vector<NamedSeries> courses;
  for (const ImpactRow& row : rows) {
    std::vector<double> values{row.closed.speed};
    for (const Quantity& q : impact_quantities(study)) values.push_back(q.of(row.closed));
    if (stepped)
      for (const Quantity& q : impact_quantities(study))
        values.push_back(row.stepped ? q.of(*row.stepped) : std::numeric_limits<double>::quiet_NaN());
    table.write(values);
    const std::string name = fmt::format("{:g}", row.closed.speed);
    write_course(folder / ("course-" + name + ".csv"), row.closed);
    if (row.stepped) write_course(folder / ("stepped-" + name + ".csv"), *row.stepped);
    courses.push_back({title_of(study) + ", " + name + " m/s", course_of(row.closed)});
  }
  write_impact_file(study, rows, folder / "impact.h5");
  if (courses.empty() || !gnuplot_found()) return;
  plot_series(courses, "time", {"indentation", "speed", "force"}, folder / ("impact." + pictures));
  PlotOptions loop;
  loop.width = 800, loop.panel_height = 460;
  plot_series(courses, "indentation", {"force"}, folder / ("loop." + pictures), loop);
}

}  // namespace subsoil::sim
