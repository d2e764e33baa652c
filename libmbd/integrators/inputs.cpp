#include "libmbd/integrators/inputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <exception>
#include <limits>

#include "libmbd/base/dense.hpp"
#include "libmbd/base/quartic.hpp"
#include "libmbd/controllers.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/integrators/adams_weights.hpp"
#include "libmbd/system/given_functions.hpp"

namespace subsoil::mbd {

namespace {

/// A formula that ends before the window does is no error here: whoever integrates that far meets it.
double value_or_nan(const Function& f, double t) {
  try {
    return f.value(t);
  } catch (const std::exception&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

bool is_slow(const Function& f) {
  if (const auto* sum = f.get_if<SumFunction>()) return std::all_of(sum->terms.begin(), sum->terms.end(), is_slow);
  return !f.is_set() || f.get_if<ConstantFunction>() || f.get_if<PolynomialFunction>();
}

void add_coefficients(const Function& f, std::array<double, 6>& c) {
  if (const auto* sum = f.get_if<SumFunction>())
    for (const Function& term : sum->terms) add_coefficients(term, c);
  if (const auto* polynomial = f.get_if<PolynomialFunction>())
    for (std::size_t k = 0; k < c.size(); ++k) c[k] += polynomial->c[k];
}

/// The zeros of c1 + 2 c2 t + ... as eigenvalues of its companion matrix (Golub & Van Loan, Matrix Computations, 4th
/// ed., section 7.4.6), of complex ones the real part: a step may end there as well.
std::vector<double> turns_of(const std::array<double, 6>& c) {
  std::size_t degree = c.size() - 1;
  while (degree > 0 && c[degree] == 0) --degree;
  if (degree < 2) return {};
  const auto n = static_cast<Eigen::Index>(degree) - 1;
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  companion.bottomLeftCorner(n - 1, n - 1).setIdentity();
  for (Eigen::Index k = 0; k < n; ++k)
    companion(k, n - 1) =
        -(static_cast<double>(k) + 1) * c[static_cast<std::size_t>(k) + 1] / (static_cast<double>(degree) * c[degree]);
  if (!companion.allFinite()) return {};
  std::vector<double> turns;
  for (const std::complex<double>& zero : eigenvalues(companion)) turns.push_back(zero.real());
  return turns;
}

/// Of two corners; nearer ones are a jump, which no step resolves (s).
constexpr double least_distance = 1e-7;

struct Corners {
  std::vector<double> resolved, jumps;
};

/// Times in [from, until) where a higher derivative jumps, or the function itself.
void append_corners(const Function& f, double from, double until, Corners& out) {
  const auto take = [&](double t, bool apart) {
    if (t >= from && t < until) (apart ? out.resolved : out.jumps).push_back(t);
  };
  if (const auto* sum = f.get_if<SumFunction>()) {
    for (const Function& term : sum->terms) append_corners(term, from, until, out);
  } else if (const auto* ramp = f.get_if<RampFunction>()) {
    const bool apart = ramp->end - ramp->begin > least_distance;
    take(ramp->begin, apart), take(ramp->end, apart);
  } else if (const auto* table = f.get_if<TableFunction>()) {
    const double begin = table->times.front(), period = table->times.back() - begin;
    const double first = table->periodic ? std::floor((from - begin) / period) : 0;
    const double last = table->periodic ? std::floor((until - begin) / period) : 0;
    const std::vector<double>& times = table->times;
    const auto apart = [&](std::size_t i) { return times[i + 1] - times[i] > least_distance; };
    for (double n = first; n <= last; ++n)
      for (std::size_t i = 0; i < times.size(); ++i)
        take(times[i] + n * period, (i == 0 || apart(i - 1)) && (i + 1 == times.size() || apart(i)));
  }
}

/// Below this two times are one.
double least_step(double t) { return 1e-11 * std::max(1.0, std::abs(t)); }

}  // namespace

Inputs::Inputs(const Model& model) {
  const auto take_all = [this](const auto& e) { visit_given_functions(e, [this](const Function& f) { add(f); }); };
  for (const auto& force : model.forces) visit(take_all, force.element);
  for (const auto& driver : model.drivers) visit(take_all, driver.element);
  for (const auto& controller : model.controllers) visit(take_all, controller.element);
  std::sort(turns_.begin(), turns_.end());
  values_.resize(functions_.size()), largest_.resize(functions_.size());
}

void Inputs::add(const Function& f) {
  if (!is_slow(f)) return functions_.push_back(&f);
  std::array<double, 6> c{};
  add_coefficients(f, c);
  for (const double turn : turns_of(c)) turns_.push_back(turn);
}

double Inputs::next_turn(double t) const {
  const auto next = std::upper_bound(turns_.begin(), turns_.end(), t + least_step(t));
  return next == turns_.end() ? std::numeric_limits<double>::infinity() : *next;
}

double Inputs::stop(double t, double planned) {
  sample_around(t);
  sample_changed(t);
  const double least = least_step(t);
  double end = t + std::min(planned, window);
  bool shortened = planned > window;
  while (!resolves(t, end)) {
    shortened = true;
    // Halved, and then back to a sample: the first ones end at corners.
    const auto first = std::upper_bound(times_.begin(), times_.end(), t + least);
    const auto after = std::upper_bound(first, times_.end(), t + (end - t) / 2);
    end = after == first ? *first : *(after - 1);
  }
  // A stop beyond the step would still cut the one after it, before that is asked for.
  return shortened ? end : t + 2 * window;
}

/// By trapeziums over the quarters of the step and the samples in it.
double Inputs::mean(std::size_t i, double t, double end) const {
  const double least = least_step(t);
  auto sample = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), t + least) - times_.begin());
  double sum = 0, from = t, value = value_or_nan(*functions_[i], t);
  const auto take = [&](double until, double next) {
    sum += 0.5 * (until - from) * (value + next);
    from = until, value = next;
  };
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    const double node = t + share * (end - t);
    for (; sample < times_.size() && times_[sample] < node - least; ++sample) take(times_[sample], values_[i][sample]);
    take(node, value_or_nan(*functions_[i], node));
  }
  return sum / (end - t);
}

/// The mean that a multistep method takes of it.
double Inputs::taken(std::size_t i, double t, double step, std::span<const double> weights) const {
  double sum = 0;
  for (std::size_t j = 0; j < weights.size(); ++j)
    sum += weights[j] * value_or_nan(*functions_[i], t + step - static_cast<double>(j) * step);
  return sum;
}

bool Inputs::gives_means(double t, double step, std::span<const double> weights, double share) {
  if (!any()) return true;
  sample_around(t);
  sample_changed(t);
  for (std::size_t i = 0; i < functions_.size(); ++i)  // NaN: has no value there, and bounds no step
    if (std::abs(taken(i, t, step, weights) - mean(i, t, t + std::min(step, window))) > share * largest_[i])
      return false;
  return true;
}

void Inputs::add_missed(double t, double step, std::span<const double> weights, Missed& to) {
  if (!any()) return;
  sample_around(t);
  sample_changed(t);
  to.missed.resize(functions_.size()), to.all.resize(functions_.size());
  for (std::size_t i = 0; i < functions_.size(); ++i) {
    const double is = mean(i, t, t + std::min(step, window)), was = taken(i, t, step, weights);
    if (!std::isfinite(is) || !std::isfinite(was)) continue;
    to.missed[i] += step * std::abs(was - is), to.all[i] += step * std::abs(is);
  }
}

double Inputs::Missed::share() const {
  double worst = 0;
  for (std::size_t i = 0; i < missed.size(); ++i)
    if (all[i] > 0) worst = std::max(worst, missed[i] / all[i]);
  return worst;
}

void Inputs::sample_around(double t) {
  const double index = std::floor(t / window);
  if (sampled_ && index == index_) return;
  const bool next = sampled_ && index == index_ + 1;
  const auto kept = next ? std::lower_bound(times_.begin(), times_.end(), index * window) : times_.end();
  const auto dropped = kept - times_.begin();
  times_.erase(times_.begin(), kept);
  corners_.erase(corners_.begin(),
                 next ? std::lower_bound(corners_.begin(), corners_.end(), index * window) : corners_.end());
  for (auto& values : values_) values.erase(values.begin(), values.begin() + dropped);
  if (!next) append_window(index);
  append_window(index + 1);
  index_ = index, sampled_ = true;
  for (std::size_t i = 0; i < functions_.size(); ++i) find_largest(i);
}

// A function whose values come from outside was sampled as it was then. What a step ends by is a matter of the
// functions as they are: of two samples ahead, the next and the last, each is compared.
void Inputs::sample_changed(double t) {
  const auto next = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), t) - times_.begin());
  if (next == times_.size()) return;
  for (std::size_t i = 0; i < functions_.size(); ++i) {
    const auto holds = [&](std::size_t k) {
      const double is = value_or_nan(*functions_[i], times_[k]), was = values_[i][k];
      return is == was || (std::isnan(is) && std::isnan(was));
    };
    if (holds(next) && holds(times_.size() - 1)) continue;
    for (std::size_t k = next; k < times_.size(); ++k) values_[i][k] = value_or_nan(*functions_[i], times_[k]);
    find_largest(i);
  }
}

void Inputs::find_largest(std::size_t i) {
  largest_[i] = 0;
  for (const double value : values_[i]) largest_[i] = std::max(largest_[i], std::isnan(value) ? 0 : std::abs(value));
}

void Inputs::append_window(double index) {
  const double begin = index * window;
  std::vector<double> times;
  for (double k = 0; k * spacing < window; ++k) times.push_back(begin + k * spacing);
  Corners corners;
  for (const Function* f : functions_) append_corners(*f, begin, begin + window, corners);
  std::sort(corners.resolved.begin(), corners.resolved.end());
  corners_.insert(corners_.end(), corners.resolved.begin(), corners.resolved.end());
  times.insert(times.end(), corners.resolved.begin(), corners.resolved.end());
  // A step that begins on a jump, or a power of two before it, shortens until it sees the jump's inside.
  for (const double jump : corners.jumps) {
    std::erase_if(times, [&](double t) { return std::abs(t - jump) < spacing; });
    times.push_back(jump - 0.382 * spacing);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  for (std::size_t i = 0; i < functions_.size(); ++i)
    for (const double t : times) values_[i].push_back(value_or_nan(*functions_[i], t));
  times_.insert(times_.end(), times.begin(), times.end());
}

bool Inputs::is_corner(double t) const {
  const auto next = std::lower_bound(corners_.begin(), corners_.end(), t - least_step(t));
  return next != corners_.end() && *next <= t + least_step(t);
}

Inputs::Inside Inputs::inside(double t, double stop) const {
  // The place in a table that repeats itself is known to rounding of the time.
  const auto apart = [](double at) { return 4 * std::numeric_limits<double>::epsilon() * std::abs(at); };
  Inside out;
  if (is_corner(t)) out.from = t + apart(t);
  if (std::isfinite(stop) && stop > t && is_corner(stop)) out.until = stop - apart(stop);
  return out;
}

double Inputs::next_corner(double t, double until) const {
  Corners corners;
  for (const Function* f : functions_) append_corners(*f, t, until, corners);
  corners.resolved.insert(corners.resolved.end(), corners.jumps.begin(), corners.jumps.end());
  double next = until;
  for (const double corner : corners.resolved)
    if (corner > t + least_step(t) && corner < until - least_step(until)) next = std::min(next, corner);
  return next;
}

bool Inputs::resolves(double t, double end) const {
  const double least = least_step(t);
  const auto begin = std::upper_bound(times_.begin(), times_.end(), t + least);
  const auto from = static_cast<std::size_t>(begin - times_.begin());
  const auto until = static_cast<std::size_t>(std::lower_bound(begin, times_.end(), end - least) - times_.begin());
  if (from == until) return true;
  constexpr double share_of_bend = 5e-4, share_of_largest = 1e-8;
  for (std::size_t i = 0; i < functions_.size(); ++i) {
    std::array<double, 5> nodes{};
    const auto at = [&](double share) { return value_or_nan(*functions_[i], t + share * (end - t)); };
    for (std::size_t k = 0; k < 5; ++k) nodes[k] = at(static_cast<double>(k) / 4);
    const Quartic quartic(nodes);
    double bend = 0, off = 0;
    const auto compare = [&](double share, double value) {
      bend = std::max(bend, std::abs(value - (nodes[0] + share * (nodes[4] - nodes[0]))));
      off = std::max(off, std::abs(value - quartic.at(share)));
    };
    for (std::size_t k = from; k < until; ++k) compare((times_[k] - t) / (end - t), values_[i][k]);
    for (const double share : {0.125, 0.375, 0.625, 0.875}) compare(share, at(share));  // corners may lie on nodes
    if (off > share_of_bend * bend + share_of_largest * largest_[i]) return false;
    // What is the same at both ends as before, and bends in between, is seen by no method.
    constexpr double blind = 0.25;
    const double missed = std::abs(taken(i, t, end - t, moulton_weights(4)) - mean(i, t, end));
    if (missed > blind * bend + share_of_largest * largest_[i]) return false;
  }
  return true;
}

}  // namespace subsoil::mbd
