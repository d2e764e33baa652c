#include "libsim/studies/calibrate/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libmbd/base/dense.hpp"
#include "libsim/studies/calibrate/store.hpp"
#include "libsim/studies/calibrate/surrogate.hpp"
#include "libsim/studies/laboratory/tests.hpp"

namespace subsoil::sim {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double same_place = 0.01;    // of the ranges: a search that leads so near to a known point is done
constexpr long other_packings = 1000;  // seeds of a truth lie so far from those of the calibration
constexpr double two_sided_95 = 1.959963984540054;

/// Radical inverse of i, one coordinate of a Halton point.
double halton(long i, int base) {
  double f = 1, sum = 0;
  for (; i > 0; i /= base) f /= base, sum += f * static_cast<double>(i % base);
  return sum;
}
constexpr int primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29};

/// Four digits: a set that can be typed again.
double rounded(double value) { return std::stod(fmt::format("{:.4g}", value)); }

class Calibrator {
 public:
  Calibrator(const Plan& plan, const std::filesystem::path& file, int threads, const CalibrationProgress& progress)
      : plan_(plan), store_(file, plan), threads_(threads), progress_(progress) {
    if (plan.parameters.size() > std::size(primes))
      throw std::invalid_argument(fmt::format("a calibration takes {} parameters at most", std::size(primes)));
    out_.targets = plan.targets;
  }

  Calibrated run() {
    require_scatter();
    find_truth();
    for (long i = 0; i < *plan_.design; ++i) evaluate(Evaluation::Why::design, values_of(design_point(i)));
    for (;;) {
      build_surrogates();
      out_.u = minimise(count(), [this](const Eigen::VectorXd& u) { return misfit(u); });
      take_nearest();
      out_.converged = out_.distance < same_place;
      if (out_.converged || static_cast<long>(out_.evaluations.size()) >= plan_.evaluations) break;
      evaluate(Evaluation::Why::search, values_of(out_.u));
    }
    find_intervals();
    return std::move(out_);
  }

 private:
  int count() const { return static_cast<int>(plan_.parameters.size()); }

  Eigen::VectorXd design_point(long i) const {
    Eigen::VectorXd u(count());
    for (int k = 0; k < count(); ++k) u[k] = halton(1 + i + 100 * (plan_.seed - 1), primes[k]);
    return u;
  }
  std::vector<double> values_of(const Eigen::VectorXd& u) const {
    std::vector<double> values;
    for (int k = 0; k < count(); ++k)
      values.push_back(rounded(plan_.parameters[static_cast<std::size_t>(k)].value(u[k])));
    return values;
  }
  Eigen::VectorXd place_of(const std::vector<double>& values) const {
    Eigen::VectorXd u(count());
    for (int k = 0; k < count(); ++k)
      u[k] = plan_.parameters[static_cast<std::size_t>(k)].place(values[static_cast<std::size_t>(k)]);
    return u;
  }

  /// The intervals come from the scatter of packings.
  void require_scatter() const {
    const LoadedTests tests = load_tests(plan_.scenario, plan_.sets(values_of(design_point(0))));
    if (tests.tests.sample.packings < 2)
      throw ScenarioError(tests.loaded.where("test.packings") +
                          " = 1: one packing does not show how far packings scatter, which the intervals of the "
                          "parameters come from; give 2 or more");
  }

  /// Puts a set through all tests, or finds it in the store.
  Evaluation result_of(Evaluation::Why why, const std::vector<double>& values) {
    if (const auto known = store_.find(why, values)) return *known;
    std::vector<std::string> sets = plan_.sets(values);
    Evaluation e{why, values, std::vector<double>(plan_.targets.size(), unknown), {}, {}};
    e.error = e.found;
    LoadedTests tests = load_tests(plan_.scenario, sets);
    if (why == Evaluation::Why::truth) tests.tests.sample.seed += other_packings;
    for (const std::string& word : plan_.tests()) {
      try {
        const Findings found = run_test(tests, word, threads_);
        for (std::size_t k = 0; k < plan_.targets.size(); ++k) {
          if (plan_.targets[k].test != word) continue;
          const Replicates over = found.number(plan_.targets[k].number).replicates();
          e.found[k] = over.mean;
          e.error[k] = over.count < 2 ? 0 : over.standard_error();
        }
      } catch (const std::runtime_error& error) {
        e.failure = error.what();
      }
    }
    store_.add(e);
    return e;
  }

  void evaluate(Evaluation::Why why, const std::vector<double>& values) {
    out_.evaluations.push_back(result_of(why, values));
    if (progress_) progress_(out_.evaluations.back(), out_.evaluations.size());
  }

  /// Values of targets that have none.
  void find_truth() {
    if (std::none_of(out_.targets.begin(), out_.targets.end(), [](const auto& t) { return std::isnan(t.value); }))
      return;
    std::vector<double> truth;
    for (const PlanParameter& p : plan_.parameters) truth.push_back(*p.truth);
    const Evaluation e = result_of(Evaluation::Why::truth, truth);
    if (!e.complete()) throw std::runtime_error("the tests give nothing at the parameters' truth: " + e.failure);
    for (std::size_t k = 0; k < out_.targets.size(); ++k) {
      PlanTarget& target = out_.targets[k];
      if (!std::isnan(target.value)) continue;
      // A mean over packings itself, which nobody knows better than it does.
      target.value = e.found[k], target.tolerance = std::hypot(target.tolerance, e.error[k]);
    }
  }

  void build_surrogates() {
    std::vector<const Evaluation*> good;
    for (const Evaluation& e : out_.evaluations)
      if (e.complete()) good.push_back(&e);
    if (good.size() < static_cast<std::size_t>(count()) + 2)
      throw std::runtime_error(
          fmt::format("only {} of {} points of the design give numbers, the last failure: {}; narrower ranges, or more "
                      "points",
                      good.size(), out_.evaluations.size(), last_failure()));
    const auto n = static_cast<Eigen::Index>(good.size());
    Eigen::MatrixXd points(n, count());
    for (Eigen::Index i = 0; i < n; ++i)
      points.row(i) = place_of(good[static_cast<std::size_t>(i)]->parameters).transpose();
    surrogates_.clear(), deviations_.clear();
    for (std::size_t k = 0; k < out_.targets.size(); ++k) {
      Eigen::VectorXd values(n);
      double noise = 0;
      for (Eigen::Index i = 0; i < n; ++i) {
        const Evaluation& e = *good[static_cast<std::size_t>(i)];
        values[i] = e.found[k], noise += e.error[k] * e.error[k] / static_cast<double>(n);
      }
      surrogates_.emplace_back(points, values, noise);
      deviations_.push_back(std::hypot(out_.targets[k].tolerance, std::sqrt(noise)));
    }
  }

  std::string last_failure() const {
    std::string text = "none";
    for (const Evaluation& e : out_.evaluations)
      if (!e.complete()) text = e.failure;
    return text;
  }

  /// Squares of what the targets are off, in deviations; `doubted`: these count the surrogates' own errors.
  double misfit(const Eigen::VectorXd& u, bool doubted = false) const {
    double sum = 0;
    for (std::size_t k = 0; k < surrogates_.size(); ++k) {
      const double error = doubted ? surrogates_[k].error(u) : 0;
      const double off = (surrogates_[k].value(u) - out_.targets[k].value) / std::hypot(deviations_[k], error);
      sum += off * off;
    }
    return sum;
  }

  void take_nearest() {
    out_.distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < out_.evaluations.size(); ++i) {
      const double d = (place_of(out_.evaluations[i].parameters) - out_.u).cwiseAbs().maxCoeff();
      if (out_.evaluations[i].complete() && d < out_.distance) out_.distance = d, out_.nearest = i;
    }
  }

  /// 95 % interval of a parameter, as a place in its range: where the best that the others can do is worse than the set
  /// by 1.96^2 at most (profile likelihood; Venzon & Moolgavkar, Applied Statistics 37, 1988, 87). So a parameter that
  /// another makes up for, along however bent a line, has the interval of that line.
  std::pair<double, double> profile(int parameter) const {
    constexpr int places = 40;
    const auto with = [&](const Eigen::VectorXd& others, double place) {
      Eigen::VectorXd u(count());
      for (int k = 0, from = 0; k < count(); ++k) u[k] = k == parameter ? place : others[from++];
      return u;
    };
    std::vector<double> least(places + 1);
    double best = misfit(out_.u, true);
    for (int i = 0; i <= places; ++i) {
      const double place = static_cast<double>(i) / places;
      const auto off = [&](const Eigen::VectorXd& others) { return misfit(with(others, place), true); };
      double& here = least[static_cast<std::size_t>(i)];
      here = count() == 1 ? off({}) : off(minimise(count() - 1, off));
      best = std::min(best, here);
    }
    double low = out_.u[parameter], high = low;
    for (int i = 0; i <= places; ++i) {
      if (least[static_cast<std::size_t>(i)] > best + two_sided_95 * two_sided_95) continue;
      // One place farther: the end lies between the last place that fits and the next.
      low = std::min(low, std::max(0.0, (i - 1.0) / places)), high = std::max(high, std::min(1.0, (i + 1.0) / places));
    }
    return {low, high};
  }

  void find_intervals() {
    const auto targets = static_cast<Eigen::Index>(surrogates_.size());
    constexpr double h = 0.05;  // a range is told apart by tests to some hundredths
    out_.slopes.resize(targets, count());
    for (Eigen::Index j = 0; j < count(); ++j) {
      Eigen::VectorXd up = out_.u, down = out_.u;
      up[j] = std::min(1.0, up[j] + h), down[j] = std::max(0.0, down[j] - h);
      for (Eigen::Index k = 0; k < targets; ++k) {
        const Surrogate& s = surrogates_[static_cast<std::size_t>(k)];
        out_.slopes(k, j) =
            (s.value(up) - s.value(down)) / (up[j] - down[j]) / deviations_[static_cast<std::size_t>(k)];
      }
    }
    const mbd::SingularValues svd = mbd::singular_values(out_.slopes);
    out_.directions = svd.right;
    out_.strengths = Eigen::VectorXd::Zero(count());
    out_.strengths.head(svd.values.size()) = svd.values;
    for (int j = 0; j < count(); ++j) {
      const PlanParameter& p = plan_.parameters[static_cast<std::size_t>(j)];
      const auto [low, high] = profile(j);
      out_.values.push_back(p.value(out_.u[j]));
      out_.low.push_back(p.value(low)), out_.high.push_back(p.value(high));
    }
    for (const Surrogate& s : surrogates_) out_.predicted.push_back(s.value(out_.u));
  }

  const Plan& plan_;
  EvaluationStore store_;
  int threads_;
  const CalibrationProgress& progress_;
  Calibrated out_;
  std::vector<Surrogate> surrogates_;
  std::vector<double> deviations_;
};

}  // namespace

Calibrated calibrate(const Plan& plan, const std::filesystem::path& store, int threads,
                     const CalibrationProgress& progress) {
  return Calibrator(plan, store, threads, progress).run();
}

}  // namespace subsoil::sim
