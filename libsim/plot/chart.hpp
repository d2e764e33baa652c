#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace subsoil::sim {

/// Points of a chart over each other, in the units of its axes.
struct ChartCurve {
  enum class Style { line, dashed, dots };
  std::string name;  ///< in the key; empty: not in it
  std::vector<double> x, y;
  Style style = Style::line;
  int colour = 0;  ///< number in the palette; the same number, the same colour
};

/// One sheet with two axes: a load over a path, points and the line through them, a heap's outline.
struct Chart {
  std::string title, x_label, y_label;  ///< labels with units: "depth [mm]"
  std::vector<ChartCurve> curves;
  bool equal_scale = false;       ///< a metre is as long along y as along x
  bool from_zero = false;         ///< both axes begin at zero
  int width = 900, height = 560;  ///< pixels
};

/// The kind of file by suffix (.png .svg .pdf). Throws std::runtime_error when gnuplot is not installed or fails.
void draw_chart(const Chart& chart, const std::filesystem::path& out);

}  // namespace subsoil::sim
