#include "libsim/plot/section_film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/plot/gnuplot.hpp"

namespace subsoil::sim {
namespace {

constexpr int kLeft = 16, kRight = 96, kAbove = 44, kBelow = 16;  // pixels around the scene
constexpr const char* kPalette = "defined (0 '#d8ccb6', 0.15 '#e0b27a', 0.45 '#d95f02', 1 '#5e0f4c')";

/// The numbers but for this share of them at either end.
std::pair<double, double> most_of(std::vector<double>& numbers, double left_out) {
  if (numbers.empty()) return {0, 1};
  const auto skip = static_cast<std::ptrdiff_t>(left_out * static_cast<double>(numbers.size() - 1));
  std::nth_element(numbers.begin(), numbers.begin() + skip, numbers.end());
  const double low = numbers[static_cast<std::size_t>(skip)];
  std::nth_element(numbers.begin(), numbers.end() - 1 - skip, numbers.end());
  return {low, *(numbers.end() - 1 - skip)};
}

}  // namespace

SectionFilm::SectionFilm(const FramesFile& file, std::vector<std::size_t> frames, std::string name, int width)
    : file_(file), frames_(std::move(frames)), name_(std::move(name)), width_(width) {
  find_middle();
  bound();
}

/// Middle of the moving surfaces that have triangles, else of the spheres.
void SectionFilm::find_middle() {
  std::vector<double> across;
  for (const FrameSurface& s : file_.surfaces())
    if (s.moves && !s.wall && !s.triangles.empty()) {
      const std::vector<float> v = vertices(frames_.front(), s);
      for (std::size_t i = 2; i < v.size(); i += 3) across.push_back(v[i]);
    }
  const FrameSpheres first = file_.spheres(frames_.front(), false);
  if (across.empty())
    for (std::size_t i = 2; i < first.position.size(); i += 3) across.push_back(first.position[i]);
  const auto [low, high] = most_of(across, 0);
  middle_ = 0.5 * (low + high);
  double sum = 0;
  for (const float r : file_.radius()) sum += r;
  half_ = file_.radius().empty() ? 0 : sum / static_cast<double>(file_.radius().size());
}

std::vector<SectionFilm::Cut> SectionFilm::cut(std::size_t frame) const {
  FrameSpheres s = file_.spheres(frame, true);
  file_.put_in_window(frame, s.position);
  const bool moving = s.velocity.size() == s.position.size();
  std::vector<Cut> out;
  for (std::size_t i = 0; i < s.index.size(); ++i) {
    const float *p = &s.position[3 * i], *v = moving ? &s.velocity[3 * i] : nullptr;
    if (std::abs(p[2] - middle_) > half_) continue;
    out.push_back({p[0], p[1], p[2], file_.radius()[s.index[i]], v ? std::hypot(v[0], v[1], v[2]) : 0.0F});
  }
  std::sort(out.begin(), out.end(), [](const Cut& a, const Cut& b) { return a.z < b.z; });  // the nearest last
  return out;
}

std::vector<float> SectionFilm::vertices(std::size_t frame, const FrameSurface& s) const {
  const std::vector<double> places = s.moves ? file_.surface(frame, s) : std::vector<double>{};
  std::vector<float> moved(places.begin(), places.end());
  file_.put_in_window(frame, moved);
  return moved.empty() ? s.vertices : moved;
}

void SectionFilm::bound() {
  Numbers x, y, speed;
  const std::size_t step = frames_.size() / 12 + 1;
  for (std::size_t k = 0; k < frames_.size(); k += step)
    for (const Cut& c : cut(frames_[k])) {
      x.insert(x.end(), {double(c.x) - c.r, double(c.x) + c.r});
      y.insert(y.end(), {double(c.y) - c.r, double(c.y) + c.r});
      speed.push_back(c.speed);
    }
  // What flies off or rolls away does not shrink the rest: all of the first frame, of all together 98 %.
  const auto [left, right] = most_of(x, 0.01);
  const auto [low, high] = most_of(y, 0.01);
  x_ = {left, right}, y_ = {low, high};
  for (const Cut& c : cut(frames_.front())) {
    x_.low = std::min(x_.low, double(c.x) - c.r), x_.high = std::max(x_.high, double(c.x) + c.r);
    y_.low = std::min(y_.low, double(c.y) - c.r), y_.high = std::max(y_.high, double(c.y) + c.r);
  }
  fastest_ = std::max(1e-6, most_of(speed, 5e-3).second);
  for (const FrameSurface& s : file_.surfaces()) {
    if (!s.moves || s.wall) continue;
    for (std::size_t k = 0; k < frames_.size(); k += step) {
      const std::vector<float> v = vertices(frames_[k], s);
      for (std::size_t i = 0; i + 2 < v.size(); i += 3) {
        x_.low = std::min(x_.low, double(v[i])), x_.high = std::max(x_.high, double(v[i]));
        y_.low = std::min(y_.low, double(v[i + 1])), y_.high = std::max(y_.high, double(v[i + 1]));
      }
    }
  }
  for (Side* side : {&x_, &y_}) {
    const double pad = 0.02 * (side->high - side->low) + 1e-6;
    side->low -= pad, side->high += pad;
  }
  // On one scale in x and y, no taller than it is wide.
  const int across = width_ - kLeft - kRight;
  const double scale = std::min(across / (x_.high - x_.low), width_ / (y_.high - y_.low));
  const double spare = across / scale - (x_.high - x_.low);
  x_.low -= 0.5 * spare, x_.high += 0.5 * spare;
  height_ = kAbove + kBelow + static_cast<int>(std::ceil(scale * (y_.high - y_.low)));
  height_ += height_ % 2;
}

/// Triangles as closed outlines, or lines between points; parted by empty lines.
std::string SectionFilm::surface_block(const std::string& block, std::size_t frame, const FrameSurface& s) const {
  const std::vector<float> v = vertices(frame, s);
  std::string text = '$' + block + " << EOD\n";
  const auto put = [&](int k) {
    text += fmt::format("{:.5g} {:.5g}\n", v[3 * static_cast<std::size_t>(k)], v[3 * static_cast<std::size_t>(k) + 1]);
  };
  for (const auto& t : s.triangles) {
    for (const int k : t) put(k);
    put(t[0]), text += '\n';
  }
  if (s.triangles.empty())
    for (const auto& e : s.segments) put(e[0]), put(e[1]), text += '\n';
  return text + "EOD\n";
}

std::string SectionFilm::script(std::size_t picture) const {
  const std::size_t frame = frames_.at(picture);
  std::string blocks = "$soil << EOD\n", plots, before;
  for (const Cut& c : cut(frame)) blocks += fmt::format("{:.5g} {:.5g} {:.4g} {:.3g}\n", c.x, c.y, c.r, c.speed);
  const bool soil = blocks.back() == '\n' && blocks.size() > 13;
  blocks += "EOD\n";
  int count = 0;
  for (const FrameSurface& s : file_.surfaces()) {
    if (s.wall || (s.triangles.empty() && s.segments.empty())) continue;
    const std::string block = fmt::format("s{}", count++);
    blocks += surface_block(block, frame, s);
    const std::string area =
        "$" + block + " using 1:2 with filledcurves closed fillstyle solid noborder fillcolor rgb ";
    if (s.triangles.empty())
      before += "$" + block + " using 1:2 with lines linewidth 2 linecolor rgb '#30343a', ";
    else if (s.moves)
      before += area + "'#40545b66', ";  // a quarter clear: what is behind it in the section shows
    else
      plots += area + "'#ececec', ";
  }
  if (soil) plots += "$soil using 1:2:3:4 with circles fillstyle solid noborder fillcolor palette, ";
  plots += before;
  if (plots.empty()) plots = "NaN, ";
  plots.erase(plots.size() - 2);
  const auto x = [&](int pixels) { return static_cast<double>(pixels) / width_; };
  const auto y = [&](int pixels) { return static_cast<double>(pixels) / height_; };
  return fmt::format(
      "set encoding utf8\n{}set output {{out}}\nunset border\nunset tics\nunset key\nset palette {}\n"
      "set cbrange [0:{:.3g}]\nset cbtics scale 0.4\nset cblabel 'speed [m/s]'\n{}"
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset bmargin at screen {:.5f}\n"
      "set tmargin at screen {:.5f}\nset colorbox user origin {:.5f},{:.5f} size {:.5f},{:.5f}\n"
      "set xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]\n"
      "set label 1 {} at screen {:.5f},{:.5f} left font ',13'\nset label 2 {} at screen {:.5f},{:.5f} right font "
      "',13'\n"
      "{}plot {}\nunset output\n",
      gnuplot_terminal(".png", width_, height_), kPalette, fastest_, soil ? "" : "unset colorbox\n", x(kLeft),
      x(width_ - kRight), y(kBelow), y(height_ - kAbove), x(width_ - kRight + 12), y(kBelow + 8), x(14),
      std::min(0.5, y(220)), x_.low, x_.high, y_.low, y_.high, gnuplot_text(name_), x(kLeft), y(height_ - 24),
      gnuplot_text(fmt::format("t = {:.3f} s", file_.times()[frame])), x(width_ - kRight), y(height_ - 24), blocks,
      plots);
}

}  // namespace subsoil::sim
