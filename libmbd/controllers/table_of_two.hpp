#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/controllers/controller.hpp"

namespace subsoil::mbd {

/// A table over two measures: u = f(y_1, y_2), bilinear between the points of a grid, constant beyond its edges.
/// Continuous; its slopes jump across the grid's lines. Valid for measures of the motion, as a formula.
struct TableOfTwo {
  static constexpr ControllerMembers has{};
  std::string measures{};  ///< two columns of measures, as a scenario has them
  std::string first_unit = "1", second_unit = "1", output_unit = "1";
  std::vector<double> first{}, second{};  ///< places of the grid, increasing
  std::vector<double> values{};           ///< f(first_i, second_j), i by i
  std::vector<std::shared_ptr<ControllerInput>> inputs{};
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("table of two", "a table over two measures");
    v.joined_text("table of two", measures, "the two measures, columns of machine.measures: [speed, depth]");
    v.text("first in", first_unit, "SI unit of the first measure");
    v.text("second in", second_unit, "SI unit of the second measure");
    v.text("output in", output_unit, "SI unit of what it drives: N, N m, V, or 1 for a valve");
    v.quantities("first", first, "1", "(-inf, inf)", "places of the first measure, increasing, in its SI unit: 0 1 3");
    v.quantities("second", second, "1", "(-inf, inf)", "places of the second measure, increasing, in its SI unit");
    v.quantities("values", values, "1", "(-inf, inf)",
                 "output at the places, in its SI unit: for the first place of the first measure all of the second, "
                 "and so on");
  }

  void check() const {
    const auto rises = [](const std::vector<double>& x) {
      return x.size() > 1 &&
             std::adjacent_find(x.begin(), x.end(), [](double a, double b) { return !(b > a); }) == x.end();
    };
    if (!rises(first) || !rises(second))
      throw std::invalid_argument("table of two: both measures need two places or more, increasing");
    if (values.size() != first.size() * second.size())
      throw std::invalid_argument(
          "table of two: " + std::to_string(first.size()) + " by " + std::to_string(second.size()) + " places need " +
          std::to_string(first.size() * second.size()) + " values, there are " + std::to_string(values.size()));
  }
  void check_inputs() const {
    if (inputs.size() != 2) throw std::invalid_argument("table of two: needs two measures");
  }
  ControllerInputs measured() const { return inputs; }
  std::size_t state_count() const { return 0; }
  bool direct() const { return true; }
  double output(double, const double* y, const double*) const {
    const Place a = place(first, y[0]), b = place(second, y[1]);
    const auto at = [&](std::size_t i, std::size_t j) { return values[i * second.size() + j]; };
    const auto along = [&](std::size_t i) { return at(i, b.index) + b.share * (at(i, b.index + 1) - at(i, b.index)); };
    return along(a.index) + a.share * (along(a.index + 1) - along(a.index));
  }
  void rates(double, const double*, const double*, double*) const {}
  void start(double, const double*, double*) const {}

 private:
  struct Place {
    std::size_t index;
    double share;
  };
  static Place place(const std::vector<double>& x, double at) {
    const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, at);
    const auto i = static_cast<std::size_t>(above - x.begin()) - 1;
    return {i, std::clamp((at - x[i]) / (x[i + 1] - x[i]), 0.0, 1.0)};
  }
};

}  // namespace subsoil::mbd
