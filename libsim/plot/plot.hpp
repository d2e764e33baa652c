#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "libsim/io/series.hpp"

/// `subsoil plot DIR...`: the monitors of one or several runs over time or another column, drawn by gnuplot.
namespace subsoil::sim {

struct PlotOptions {
  std::vector<std::string> columns;  ///< names of series columns; empty: the monitors
  std::string over = "time";         ///< column along the sheet: a depth, a travel
  int width = 1100;                  ///< pixels
  int panel_height = 210;            ///< pixels
};

/// Stacked panels with a common axis, one line per run in each; the kind of file by suffix (.png .svg .pdf).
/// Every monitor is drawn; pull, draft, spring force, pitch and height come first, in this order. Throws
/// std::runtime_error when a series is missing, no column is common, or gnuplot is not installed (with the cure).
void plot(const std::vector<std::filesystem::path>& runs, const std::filesystem::path& out, const PlotOptions& = {});

/// A series and the name of its line.
struct NamedSeries {
  std::string name;
  Series series;
};
/// The same sheet of series held in memory: `columns` over the column `x`.
void plot_series(const std::vector<NamedSeries>& runs, const std::string& x, const std::vector<std::string>& columns,
                 const std::filesystem::path& out, const PlotOptions& = {});

/// True when gnuplot is found on PATH.
bool gnuplot_found();

}  // namespace subsoil::sim
