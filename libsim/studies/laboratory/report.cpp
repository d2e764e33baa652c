#include "libsim/studies/laboratory/report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/series_writer.hpp"
#include "libsim/plot/plot.hpp"

namespace subsoil::sim {
namespace {

std::string csv_number(double value) {
  std::string text;
  csv::append_number(text, value, csv::exact_digits);
  return text;
}

/// One packing has neither an error nor a spread.
std::string known(double value) { return std::isfinite(value) ? fmt::format("{:.2g}", value) : "not known"; }

}  // namespace

HandyUnit handy_unit(const std::string& unit, double size) {
  if (unit == "rad") return {180 / std::numbers::pi, "deg"};
  if (unit.starts_with("Pa") && std::abs(size) >= 2e6) return {1e-6, fmt::format("M{}", unit)};
  if (unit.starts_with("Pa") && std::abs(size) >= 200) return {1e-3, fmt::format("k{}", unit)};
  if (unit == "m" && std::abs(size) < 1) return {1e3, "mm"};
  return {1, unit};
}

std::string findings_table(const Findings& found) {
  std::string text =
      fmt::format("{:<28} {:>11} {:>11} {:>11}   per packing\n", found.test, "mean", "+- 95 %", "spread");
  for (const Number& n : found.numbers) {
    const Replicates over = n.replicates();
    const HandyUnit handy = handy_unit(n.unit, over.mean);
    text += fmt::format("{:<28} {:>11.4g} {:>11} {:>11}  ", n.name + " [" + handy.unit + "]", over.mean * handy.factor,
                        known(over.half_width() * handy.factor), known(over.deviation() * handy.factor));
    for (const double v : n.values) text += fmt::format(" {:.4g}", v * handy.factor);
    text += '\n';
  }
  for (const std::string& note : found.diagnostics) text += note + '\n';
  return text;
}

void write_findings(const Findings& found, const std::filesystem::path& folder, const std::string& pictures) {
  std::filesystem::create_directories(folder);
  std::string table = "quantity,unit,mean,error,spread";
  const std::size_t packings = found.numbers.empty() ? 0 : found.numbers.front().values.size();
  for (std::size_t p = 0; p < packings; ++p) table += fmt::format(",packing {}", p + 1);
  for (const Number& n : found.numbers) {
    const Replicates over = n.replicates();
    table += fmt::format("\n{},{},{},{},{}", n.name, n.unit, csv_number(over.mean), csv_number(over.half_width()),
                         csv_number(over.deviation()));
    for (const double v : n.values) table += fmt::format(",{}", csv_number(v));
  }
  write_atomically(folder / (found.test + ".csv"), table + "\n");
  for (const SpecimenCurve& curve : found.curves) {
    SeriesWriter writer(folder / (found.test + "-" + curve.name + ".csv"), curve.columns, csv::exact_digits);
    for (const auto& row : curve.rows) writer.write(row);
  }
  if (!gnuplot_found()) return;
  for (const NamedChart& chart : found.charts)
    draw_chart(chart.chart, folder / (found.test + "-" + chart.name + "." + pictures));
}

}  // namespace subsoil::sim
