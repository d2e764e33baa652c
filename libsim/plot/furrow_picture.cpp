#include "libsim/plot/furrow_picture.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "libsim/io/csv.hpp"
#include "libsim/plot/gnuplot.hpp"
#include "libsim/post/disturbance.hpp"

namespace subsoil::sim {
namespace {

constexpr double mm = 1e3;

std::string cells_block(const char* name, const Furrow& f, const std::vector<double>& values, double factor) {
  std::string text = fmt::format("${} << EOD\n", name);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) continue;
    const double z = f.z0 + (static_cast<double>(k % f.columns) + 0.5) * f.column,
                 y = f.y0 + (static_cast<double>(k / f.columns) + 0.5) * f.cell;
    text += fmt::format("{:.6g} {:.6g} {:.6g}\n", mm * z, mm * y, factor * values[k]);
  }
  return text + "EOD\n";
}

std::string surface_block(const char* name, const Furrow& f, const std::vector<double>& heights) {
  std::string text = fmt::format("${} << EOD\n", name);
  for (std::size_t c = 0; c < f.columns; ++c)
    text += std::isfinite(heights[c]) ? fmt::format("{:.6g} {:.6g}\n", mm * f.z[c], mm * heights[c]) : "\n";
  return text + "EOD\n";
}

std::string panel(const char* block, const Furrow& f, const char* label, const char* palette, double low, double high,
                  const std::string& title) {
  return fmt::format(
      "set title {} font ',11' textcolor rgb '#222222'\nset palette {}\nset cbrange [{:.6g}:{:.6g}]\nset cblabel {}\n"
      "plot ${} using 1:2:({:.6g}):({:.6g}):3 with boxxyerror fillstyle solid noborder fillcolor palette notitle, "
      "$before with lines linewidth 1.6 dashtype 2 linecolor rgb '#222222' title 'surface before', "
      "$after with lines linewidth 2 linecolor rgb '#D55E00' title 'surface after'\n",
      gnuplot_text(title), palette, low, high, gnuplot_text(label), block, 0.5 * mm * f.column, 0.5 * mm * f.cell);
}

std::string script_of(const Furrow& f, const std::string& name, const std::string& suffix) {
  double largest = 0, rise = Furrow::loosening;
  for (const double m : f.moved)
    if (std::isfinite(m)) largest = std::max(largest, mm * m);
  for (const double l : f.loosened)
    if (std::isfinite(l)) rise = std::max(rise, std::abs(l));
  const double height = static_cast<double>(f.rows) * f.cell + f.heave,
               width = static_cast<double>(f.columns) * f.column;
  const int pixels = std::clamp(static_cast<int>(2 * 760 * height / width) + 190, 420, 1400);
  std::string script = "set encoding utf8\n" + gnuplot_terminal(suffix, 900, pixels) +
                       "set output {out}\nset border 3 linecolor rgb '#555555'\nset tics nomirror out scale 0.6\n"
                       "set size ratio -1\nset key outside below horizontal samplen 2\nset bmargin 5.5\n"
                       "set ylabel 'height [mm]'\n" +
                       fmt::format("set xlabel 'across the travel, {} [mm]'\n", f.across) +
                       fmt::format("set xrange [{:.6g}:{:.6g}]\n", mm * f.z0, mm * (f.z0 + width));
  script += surface_block("before", f, f.before) + surface_block("after", f, f.after);
  script += cells_block("moved", f, f.moved, mm) + cells_block("loosened", f, f.loosened, 1);
  script += fmt::format("set multiplot layout 2,1 title {} font ',12'\n",
                        gnuplot_text(fmt::format("{}: {} = {:.3f} ... {:.3f} m{}", name, f.along, f.from, f.until,
                                                 f.steady ? "" : ", before steady work")));
  script += panel("moved", f, "mm", "defined (0 '#f4f4f4', 0.05 '#fde7cf', 1 '#8c2d04')", 0, largest,
                  fmt::format("mean displacement by place before; disturbed (above {:.3g} mm): {:.0f} cm²",
                              mm * f.threshold, 1e4 * f.disturbed_area));
  script += panel(
      "loosened", f, "", "defined (-1 '#2166ac', 0 '#f7f7f7', 1 '#b2182b')", -rise, rise,
      fmt::format("rise of porosity; loosened (above {:.2f}): {:.0f} cm²", Furrow::loosening, 1e4 * f.loosened_area));
  return script + "unset multiplot\nunset output\n";
}

}  // namespace

void draw_furrow(const std::filesystem::path& run, const std::filesystem::path& out) {
  const Disturbance d = disturbance_of(run);
  if (!d.furrow) throw std::invalid_argument(run.string() + ": no furrow: " + d.why);
  const auto whole = std::filesystem::absolute(run).lexically_normal();
  const std::string name = (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  run_gnuplot(script_of(*d.furrow, name, out.extension().string()), out);
}

}  // namespace subsoil::sim
