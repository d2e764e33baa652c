#include "libsim/plot/chart.hpp"

#include <fmt/format.h>

#include "libsim/io/csv.hpp"
#include "libsim/plot/gnuplot.hpp"

namespace subsoil::sim {
namespace {

std::string style_of(const ChartCurve& curve) {
  const char* colour = plot_colours[static_cast<std::size_t>(curve.colour) % plot_colours.size()];
  switch (curve.style) {
    case ChartCurve::Style::line:
      return fmt::format("with lines linewidth 1.6 linecolor rgb '{}'", colour);
    case ChartCurve::Style::dashed:
      return fmt::format("with lines linewidth 1.4 dashtype 2 linecolor rgb '{}'", colour);
    case ChartCurve::Style::dots:
      return fmt::format("with points pointtype 7 pointsize 0.6 linecolor rgb '{}'", colour);
  }
  return {};
}

}  // namespace

void draw_chart(const Chart& chart, const std::filesystem::path& out) {
  std::string script =
      "set encoding utf8\n" + gnuplot_terminal(out.extension().string(), chart.width, chart.height) +
      "set output {out}\nset border 3 linecolor rgb '#555555'\n"
      "set tics nomirror out scale 0.6 textcolor rgb '#222222'\n"
      "set grid linetype 1 linewidth 0.6 linecolor rgb '#e4e4e4'\nset key outside right top samplen 2\n";
  if (chart.equal_scale) script += "set size ratio -1\n";
  if (chart.from_zero) script += "set xrange [0:*]\nset yrange [0:*]\n";
  script += fmt::format("set title {} textcolor rgb '#222222'\nset xlabel {}\nset ylabel {}\n",
                        gnuplot_text(chart.title), gnuplot_text(chart.x_label), gnuplot_text(chart.y_label));
  std::string plots;
  for (std::size_t k = 0; k < chart.curves.size(); ++k) {
    const ChartCurve& curve = chart.curves[k];
    script += fmt::format("$c{} << EOD\n", k);
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      csv::append_number(script, curve.x[i]);
      script += ' ';
      csv::append_number(script, curve.y[i]);
      script += '\n';
    }
    script += "EOD\n";
    plots += fmt::format("{}$c{} {} {}", k == 0 ? "plot " : ", ", k, style_of(curve),
                         curve.name.empty() ? "notitle" : "title " + gnuplot_text(curve.name));
  }
  run_gnuplot(script + plots + "\nunset output\n", out);
}

}  // namespace subsoil::sim
