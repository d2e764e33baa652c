#include "libsim/document/expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "libsim/document/formula.hpp"

namespace subsoil::sim {
namespace {

// ---- integrals -----------------------------------------------------------------------------------------------------

using Evaluate = std::function<double(double)>;

/// Integral of f over [a, b], and that of (b - s) f(s).
struct Area {
  double once = 0, twice = 0;
};

/// Both over [a, b] by 15-point Gauss-Kronrod sums of the same values of f, halving until that and the 7-point Gauss
/// sum agree to 4e-15 of the integral of |f|, or to what rounding of s itself leaves of f: its variation times b times
/// the precision, which is also all that is known of where a jump lies. So has what the polynomial through the nodes
/// misses of f at the ends to agree, between which and the last nodes a jump would stay unseen. The number of sums ends
/// what no halving helps.
class Quadrature {
 public:
  explicit Quadrature(const Evaluate& f) : f_(f) {}
  Area operator()(double a, double b) {
    if (!(b > a)) return {};
    const Piece all = sum(a, b);
    take_size(all.absolute, b - a);
    return refine(all, a, b, 40);
  }

 private:
  struct Piece {
    Area area;
    double error, at_ends, absolute, rounding;
  };
  void take_size(double absolute, double length) {
    allowed_ = 4e-15 * absolute, whole_ = absolute, mean_ = absolute / length;
  }
  Piece sum(double a, double b) {
    using Kronrod = boost::math::quadrature::gauss_kronrod<double, 15>;
    using Gauss = boost::math::quadrature::gauss<double, 7>;
    static const auto& x = Kronrod::abscissa();
    static const auto& w = Kronrod::weights();
    static const auto& w_gauss = Gauss::weights();  // its nodes are every other one, from the middle on
    --sums_left_;
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a), f_middle = f_(middle);
    double once = w[0] * f_middle, lever = 0, gauss = w_gauss[0] * f_middle, absolute = w[0] * std::abs(f_middle);
    double least = f_middle, most = f_middle;
    std::array<double, 15> values{f_middle};  // then below and above by pairs, from the middle on
    for (std::size_t i = 1; i < x.size(); ++i) {
      const double below = f_(middle - half * x[i]), above = f_(middle + half * x[i]);
      values[2 * i - 1] = below, values[2 * i] = above;
      once += w[i] * (below + above), lever += w[i] * x[i] * (below - above);
      absolute += w[i] * (std::abs(below) + std::abs(above));
      if (i % 2 == 0) gauss += w_gauss[i / 2] * (below + above);
      least = std::min({least, below, above}), most = std::max({most, below, above});
    }
    constexpr double precision = std::numeric_limits<double>::epsilon();
    const double beyond = half * (1 - x.back());  // of the last node, up to the end
    return {{half * once, half * half * (once + lever)},
            half * std::abs(once - gauss),
            beyond * missed_at_ends(a, b, values),
            half * absolute,
            2 * precision * b * (most - least)};
  }
  /// By how much f at either end is off the polynomial through its values at the nodes; a pole there has no value.
  double missed_at_ends(double a, double b, const std::array<double, 15>& values) const {
    static const std::array<double, 15> share = shares_at_end();
    double below = 0, above = 0;
    for (std::size_t i = 0; i < share.size(); ++i) {
      const std::size_t mirrored = i == 0 ? 0 : i % 2 == 1 ? i + 1 : i - 1;
      above += share[i] * values[i], below += share[mirrored] * values[i];
    }
    try {
      return std::max(std::abs(f_(a) - below), std::abs(f_(b) - above));
    } catch (const std::runtime_error&) {
      return 0;
    }
  }
  /// Lagrange's polynomials of the nodes at the upper end.
  static std::array<double, 15> shares_at_end() {
    std::array<double, 15> node{}, share{};
    const auto& x = boost::math::quadrature::gauss_kronrod<double, 15>::abscissa();
    for (std::size_t i = 1; i < x.size(); ++i) node[2 * i - 1] = -x[i], node[2 * i] = x[i];
    for (std::size_t i = 0; i < node.size(); ++i) {
      share[i] = 1;
      for (std::size_t k = 0; k < node.size(); ++k)
        if (k != i) share[i] *= (1 - node[k]) / (node[i] - node[k]);
    }
    return share;
  }
  Area refine(const Piece& piece, double a, double b, int halvings) {
    if (std::max(piece.error, piece.at_ends) <= std::max(allowed_, piece.rounding)) return piece.area;
    if (halvings == 0 || sums_left_ <= 0) {
      // A jump has left 1e-12 of its error here, a root's pole 1e-6, and 1/t all of it.
      if (piece.error > 1e-3 * whole_ && piece.absolute > 1e3 * mean_ * (b - a))
        throw std::runtime_error(
            fmt::format("a formula has no integral over t = {:.6g} s: it grows without bound there", a));
      return piece.area;
    }
    const double middle = 0.5 * (a + b);
    const Piece first = sum(a, middle), second = sum(middle, b);
    if (whole_ == 0) take_size(first.absolute + second.absolute, b - a);
    const Area left = refine(first, a, middle, halvings - 1), right = refine(second, middle, b, halvings - 1);
    return {left.once + right.once, left.twice + left.once * (b - middle) + right.twice};
  }
  const Evaluate& f_;
  double allowed_ = 0, whole_ = 0, mean_ = 0;  // of |f| over all: its integral and its mean
  int sums_left_ = 300;
};

/// Integral and double integral of f from 0 to t >= 0. They are sums over panels whose ends are the same whatever t
/// is, kept and in the order of the panels, so that a value does not depend on what was asked before. The nodes of a
/// panel lie 0.21 ms apart at most: a pulse that is longer is met by one of them, and halving does the rest.
class Sums {
 public:
  explicit Sums(Evaluate f) : f_(std::move(f)) {}
  double once(double t) { return to(t).once; }
  double twice(double t) { return to(t).twice; }

 private:
  static constexpr double panel = 2e-3;         // s
  static constexpr std::size_t in_block = 256;  // panels

  struct Block {
    std::size_t index = 0;
    std::vector<Area> sums{};  ///< up to the begin of each of its panels, as far as they were asked for
  };
  Area to(double t) {
    const double count = std::floor(t / panel), begin = count * panel;
    if (count > 1e9) throw std::runtime_error("a formula is integrated up to 2e6 s from t = 0 and no farther");
    return joined(before(static_cast<std::size_t>(count)), Quadrature(f_)(begin, t), t - begin);
  }
  static Area joined(const Area& before, const Area& next, double length) {
    return {before.once + next.once, before.twice + before.once * length + next.twice};
  }
  /// Up to the begin of a panel. Of all blocks the sums before them are kept, of the last two all.
  Area before(std::size_t index) {
    const std::size_t block = index / in_block;
    while (starts_.size() <= block) starts_.push_back(up_to(kept(starts_.size() - 1), in_block));
    return up_to(kept(block), index % in_block);
  }
  Block& kept(std::size_t block) {
    for (Block& b : kept_)
      if (b.index == block && !b.sums.empty()) return b;
    std::swap(kept_[0], kept_[1]);
    return kept_[1] = {block, {starts_[block]}};
  }
  const Area& up_to(Block& block, std::size_t count) const {
    while (block.sums.size() <= count) {
      const auto index = static_cast<double>(block.index * in_block + block.sums.size() - 1);
      const double begin = index * panel, end = (index + 1) * panel;
      block.sums.push_back(joined(block.sums.back(), Quadrature(f_)(begin, end), end - begin));
    }
    return block.sums[count];
  }

  Evaluate f_;
  std::array<Block, 2> kept_;
  std::vector<Area> starts_{Area{}};
};

}  // namespace

mbd::ExpressionFunction make_expression(const std::string& text, const std::string& unit, double size) {
  static const std::string t = "t";
  const auto formula = std::make_shared<const Formula>(text, std::span(&t, 1));
  const auto finite = [text](double value, const char* what, double at) {
    if (!std::isfinite(value))
      throw std::runtime_error(fmt::format("the formula `{}` has no finite {} at t = {:.6g} s", text, what, at));
    return value;
  };
  mbd::ExpressionFunction f;
  f.text = text, f.unit = unit;
  f.value_ = [formula, finite, size](double at) { return finite(size * (*formula)(&at), "value", at); };
  f.first_ = [formula, finite, size](double at) {
    const Jet<1> time{{at, 1}, true};
    return finite(size * (*formula)(&time).c[1], "first derivative", at);
  };
  f.second_ = [formula, finite, size](double at) {
    const Jet<2> time{{at, 1, 0}, true};
    return finite(size * (*formula)(&time).c[2], "second derivative", at);
  };
  const auto after = std::make_shared<Sums>(f.value_);
  const auto before = std::make_shared<Sums>([forward = f.value_](double s) { return forward(-s); });
  f.integral_ = [after, before](double at) { return at >= 0 ? after->once(at) : -before->once(-at); };
  f.double_integral_ = [after, before](double at) { return at >= 0 ? after->twice(at) : before->twice(-at); };
  return f;
}

std::function<double(double, double, double)> make_formula(const std::string& text,
                                                           const std::array<const char*, 3>& names) {
  return [formula = make_formula_of(text, {names.begin(), names.end()}), text, names](double a, double b, double c) {
    const double at[] = {a, b, c};
    const double result = formula(at);
    if (!std::isfinite(result))
      throw std::runtime_error(fmt::format("the formula `{}` has no finite value at {} = {}, {} = {}, {} = {}", text,
                                           names[0], a, names[1], b, names[2], c));
    return result;
  };
}

std::function<double(const double*)> make_formula_of(const std::string& text, const std::vector<std::string>& names) {
  return [formula = std::make_shared<const Formula>(text, names)](const double* at) { return (*formula)(at); };
}

}  // namespace subsoil::sim
