#include "libsim/plot/canvas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libsim/plot/gnuplot.hpp"

namespace subsoil::sim {

/// Neighbours of one style share a block, parted by an empty line: gnuplot draws them as pieces of one plot.
void Canvas::add(const std::vector<Spot>& points, bool closed, const std::string& style) {
  if (points.empty()) return;
  const auto put = [&](Spot p) { blocks_ += fmt::format("{:.2f} {:.2f}\n", p.x, p.y); };
  if (style == last_style_) {
    blocks_.resize(blocks_.size() - 4);  // EOD and its line end
    blocks_ += '\n';
  } else {
    blocks_ += fmt::format("$b{} << EOD\n", count_);
    plots_ += fmt::format("{}$b{} {}", plots_.empty() ? "" : ", \\\n  ", count_++, style);
  }
  for (const Spot p : points) put(p);
  if (closed) put(points.front());
  blocks_ += "EOD\n";
  last_style_ = style;
}

void Canvas::line(const std::vector<Spot>& points, const Pen& pen, bool closed) {
  add(points, closed,
      fmt::format("with lines linewidth {:.3g} dashtype {} linecolor rgb '{}'", pen.width,
                  pen.dashed ? "(8,5)" : "solid", pen.colour));
}

void Canvas::area(const std::vector<Spot>& points, const std::string& colour, double clear) {
  const int alpha = static_cast<int>(std::lround(255 * std::clamp(clear, 0.0, 1.0)));
  add(points, true,
      fmt::format("with filledcurves closed fillcolor rgb '#{:02x}{}' fillstyle solid noborder", alpha,
                  colour.substr(1)));
}

void Canvas::disk(Spot centre, double radius, const std::string& fill, const Pen& pen) {
  std::vector<Spot> rim;
  constexpr int sides = 40;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    rim.push_back(centre + radius * Spot{std::cos(angle), std::sin(angle)});
  }
  if (!fill.empty()) area(rim, fill);
  line(rim, pen, true);
}

void Canvas::words(Spot at, const std::string& text, Align align, int size, const std::string& colour) {
  const char* where = align == Align::left ? "left" : align == Align::right ? "right" : "center";
  labels_ += fmt::format("set label {} at {:.2f},{:.2f} {} font ',{}' textcolor rgb '{}' front\n", gnuplot_text(text),
                         at.x, at.y, where, size, colour);
}

std::string Canvas::script(const std::string& suffix) const {
  return fmt::format(
      "set encoding utf8\n{}set output {{out}}\n"
      "unset border\nunset tics\nunset key\nset lmargin at screen 0\nset rmargin at screen 1\n"
      "set bmargin at screen 0\nset tmargin at screen 1\nset xrange [0:{}]\nset yrange [0:{}]\n{}{}plot {}\n"
      "unset output\n",
      gnuplot_terminal(suffix, width_, height_), width_, height_, blocks_, labels_, plots_);
}

}  // namespace subsoil::sim
