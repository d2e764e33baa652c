#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <string_view>

namespace subsoil::sim {

/// Okabe and Ito's colours: distinguishable by colour-blind readers and in grey print.
inline constexpr std::array plot_colours{"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"};

/// Runs a gnuplot script whose output file is `out`, named in it as {out}. The picture is put in place when it is
/// complete; with `durable` it is on the disk then. Throws std::runtime_error with gnuplot's own words when it fails,
/// and with the cure when it is not installed.
void run_gnuplot(std::string script, const std::filesystem::path& out, bool durable = true);

/// The `set terminal` line for a picture of this size in pixels; `suffix` .png, .svg or .pdf tells its kind. Throws
/// std::runtime_error for another one.
std::string gnuplot_terminal(const std::string& suffix, int width, int height);

/// Text as a gnuplot string: nothing inside is read as markup or escape.
std::string gnuplot_text(std::string_view text);

}  // namespace subsoil::sim
