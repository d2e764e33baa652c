#include "libsim/plot/gnuplot.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "libsim/io/atomic_file.hpp"
#include "libsim/plot/plot.hpp"
#include "libsim/plot/program.hpp"

namespace subsoil::sim {
namespace {

std::string content(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

}  // namespace

bool gnuplot_found() { return on_path("gnuplot"); }

std::string gnuplot_text(std::string_view text) {
  std::string safe = "'";
  for (const char c : text) {
    if (c == '\'') safe += '\'';
    safe += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return safe + "'";
}

std::string gnuplot_terminal(const std::string& suffix, int width, int height) {
  const char* rest = "background rgb 'white'";
  if (suffix == ".png")
    return fmt::format("set terminal pngcairo noenhanced rounded size {},{} font 'DejaVu Sans,11' {}\n", width, height,
                       rest);
  if (suffix == ".svg")
    return fmt::format("set terminal svg noenhanced rounded size {},{} font 'DejaVu Sans,13' {}\n", width, height,
                       rest);
  if (suffix == ".pdf")
    return fmt::format("set terminal pdfcairo noenhanced rounded size {:.2f},{:.2f} font 'DejaVu Sans,11'\n",
                       width / 100.0, height / 100.0);
  throw std::invalid_argument("plot file: its suffix must be .png, .svg or .pdf, not '" + suffix + "'");
}

void run_gnuplot(std::string script, const std::filesystem::path& out, bool durable) {
  if (!gnuplot_found())
    throw std::runtime_error(
        "plots are drawn by gnuplot, which is not on PATH; install it: apt-get install gnuplot-nox");
  const auto part = temporary_name(out);
  const auto place = script.find("{out}");
  script.replace(place, 5, gnuplot_text(part.string()));
  const auto file = part.string() + ".gp", log = part.string() + ".log";
  std::ofstream(file) << script;
  const int status = run_program({"gnuplot", file}, log);
  const std::string words = content(log);
  std::error_code ignored;
  std::filesystem::remove(log, ignored);
  if (status != 0 || !std::filesystem::exists(part)) {
    std::filesystem::remove(part, ignored);
    throw std::runtime_error(
        fmt::format("gnuplot could not draw {} (script left in {}):\n{}", out.string(), file, words));
  }
  std::filesystem::remove(file, ignored);
  put_in_place(out, durable);
}

}  // namespace subsoil::sim
