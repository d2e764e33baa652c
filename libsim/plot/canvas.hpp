#pragma once
#include <string>
#include <vector>

namespace subsoil::sim {

/// A place in a picture: pixels, x to the right, y up from the lower left corner.
struct Spot {
  double x = 0, y = 0;
};
inline Spot operator+(Spot a, Spot b) { return {a.x + b.x, a.y + b.y}; }
inline Spot operator-(Spot a, Spot b) { return {a.x - b.x, a.y - b.y}; }
inline Spot operator*(double k, Spot a) { return {k * a.x, k * a.y}; }

struct Pen {
  std::string colour = "#222222";  ///< #rrggbb
  double width = 1;                ///< pixels
  bool dashed = false;
};

/// A drawing of lines, areas and words, in the order in which they come, that gnuplot turns into PNG, SVG or PDF.
class Canvas {
 public:
  enum class Align { left, centre, right };
  Canvas(int width, int height) : width_(width), height_(height) {}

  void line(const std::vector<Spot>& points, const Pen& pen, bool closed = false);
  /// `clear` 0: covers what is below, 1: nothing is seen of it.
  void area(const std::vector<Spot>& points, const std::string& colour, double clear = 0);
  void disk(Spot centre, double radius, const std::string& fill, const Pen& pen);
  /// Baseline about at `at`; words stand above all lines.
  void words(Spot at, const std::string& text, Align align = Align::left, int size = 11,
             const std::string& colour = "#222222");

  int width() const { return width_; }
  int height() const { return height_; }
  /// The script for run_gnuplot(); `suffix` as for gnuplot_terminal().
  std::string script(const std::string& suffix) const;

 private:
  void add(const std::vector<Spot>& points, bool closed, const std::string& style);

  int width_, height_;
  std::string blocks_, plots_, labels_, last_style_;
  int count_ = 0;
};

}  // namespace subsoil::sim
