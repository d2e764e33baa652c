#include "libsim/studies/design/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlopt.hpp>

#include "libsim/studies/calibrate/surrogate.hpp"
#include "libsim/studies/design/formulas.hpp"

namespace subsoil::sim {
namespace {

/// What all methods ask, with what they know already.
class Seeker {
 public:
  Seeker(const OptimisePlan& plan, const Ask& ask) : plan_(plan), ask_(ask), sign_(plan.minimise.empty() ? -1.0 : 1.0) {
    for (const std::string& c : plan.constraints) equations_.push_back(DesignConstraint::is_equation(c));
  }

  /// All of these at once; false when there are more than the plan allows.
  bool ask(std::vector<Design> places) {
    std::erase_if(places, [this](const Design& u) { return known_.contains(u); });
    if (asked_ + static_cast<long>(places.size()) > plan_.evaluations) return false;
    if (places.empty()) return true;
    const std::vector<Worth> worths = ask_(places);
    for (std::size_t i = 0; i < places.size(); ++i) take(places[i], worths[i]);
    asked_ += static_cast<long>(places.size());
    return true;
  }
  const Worth& at(const Design& u) {
    if (!known_.contains(u) && !ask({u})) throw nlopt::forced_stop();
    return known_.at(u);
  }

  /// What is minimised.
  double badness(const Design& u) {
    const Worth& w = at(u);
    return w.whole ? sign_ * w.objective / scale_ : worst_ + std::max(1.0, std::abs(worst_));
  }
  double excess(const Design& u, std::size_t c) {
    const Worth& w = at(u);
    return w.whole ? w.excess[c] / sizes_[c] : 0;
  }

  /// What a design misses a constraint by, as a share of its size; negative where it keeps an inequality.
  static double missed(const Worth& w, std::size_t c) { return w.size[c] > 0 ? w.excess[c] / w.size[c] : w.excess[c]; }
  bool keeps(const Worth& w, std::size_t c) const {
    const double off = missed(w, c);
    return (is_equation(c) ? std::abs(off) : off) <= plan_.constraint_tolerance;
  }
  bool is_feasible(const Worth& w) const {
    if (!w.whole) return false;
    for (std::size_t c = 0; c < constraints(); ++c)
      if (!keeps(w, c)) return false;
    return true;
  }

  const OptimisePlan& plan() const { return plan_; }
  bool is_equation(std::size_t c) const { return equations_[c]; }
  std::size_t constraints() const { return equations_.size(); }
  long asked() const { return asked_; }
  bool any_whole() const { return scaled_; }
  const std::map<Design, Worth>& known() const { return known_; }

 private:
  void take(const Design& u, const Worth& w) {
    known_.emplace(u, w);
    if (!w.whole) return;
    if (!scaled_) {
      scaled_ = true;
      if (w.objective != 0) scale_ = std::abs(w.objective);
      for (const double size : w.size) sizes_.push_back(size > 0 ? size : 1);
      worst_ = sign_ * w.objective / scale_;
    }
    worst_ = std::max(worst_, sign_ * w.objective / scale_);
  }

  const OptimisePlan& plan_;
  const Ask& ask_;
  double sign_, scale_ = 1, worst_ = 0;
  bool scaled_ = false;
  long asked_ = 0;
  std::vector<double> sizes_;
  std::vector<bool> equations_;
  std::map<Design, Worth> known_;
};

/// Ends of the difference in parameter k, inside the bounds.
std::pair<Design, Design> ends_about(const Design& u, std::size_t k) {
  constexpr double h = 1e-4;  // of the bounds: numbers are known to some 1e-10, and f'''h^2/6 stays below 1e-8 of f
  Design low = u, high = u;
  low[k] = std::max(0.0, u[k] - h), high[k] = std::min(1.0, u[k] + h);
  return {low, high};
}

template <class Function>
void differentiate(Seeker& seeker, const Design& u, std::vector<double>& gradient, Function value) {
  std::vector<Design> all;
  for (std::size_t k = 0; k < u.size(); ++k)
    all.push_back(ends_about(u, k).first), all.push_back(ends_about(u, k).second);
  if (!seeker.ask(all)) throw nlopt::forced_stop();
  for (std::size_t k = 0; k < u.size(); ++k) {
    const auto [low, high] = ends_about(u, k);
    gradient[k] = (value(high) - value(low)) / (high[k] - low[k]);
  }
}

double nlopt_objective(const Design& u, std::vector<double>& gradient, void* data) {
  Seeker& seeker = *static_cast<Seeker*>(data);
  if (!gradient.empty()) differentiate(seeker, u, gradient, [&](const Design& p) { return seeker.badness(p); });
  return seeker.badness(u);
}

struct ConstraintCall {
  Seeker* seeker;
  std::size_t index;
};

double nlopt_constraint(const Design& u, std::vector<double>& gradient, void* data) {
  const auto& [seeker, index] = *static_cast<ConstraintCall*>(data);
  if (!gradient.empty())
    differentiate(*seeker, u, gradient, [s = seeker, i = index](const Design& p) { return s->excess(p, i); });
  return seeker->excess(u, index);
}

nlopt::algorithm algorithm_of(SearchMethod method) {
  switch (method) {
    case SearchMethod::bobyqa:
      return nlopt::LN_BOBYQA;
    case SearchMethod::slsqp:
      return nlopt::LD_SLSQP;
    case SearchMethod::isres:
      return nlopt::GN_ISRES;
    default:
      return nlopt::LN_COBYLA;
  }
}

std::string by_nlopt(Seeker& seeker, SearchMethod method, Design u, std::uint64_t seed) {
  const OptimisePlan& plan = seeker.plan();
  nlopt::srand(static_cast<unsigned long>(seed));  // of this thread
  nlopt::opt opt(algorithm_of(method), static_cast<unsigned>(u.size()));
  opt.set_lower_bounds(0.0), opt.set_upper_bounds(1.0);
  opt.set_min_objective(nlopt_objective, &seeker);
  std::vector<ConstraintCall> calls;
  for (std::size_t c = 0; c < seeker.constraints(); ++c) calls.push_back({&seeker, c});
  for (ConstraintCall& call : calls)
    seeker.is_equation(call.index)
        ? opt.add_equality_constraint(nlopt_constraint, &call, 0.1 * plan.constraint_tolerance)
        : opt.add_inequality_constraint(nlopt_constraint, &call, 0.1 * plan.constraint_tolerance);
  constexpr double first_step = 0.15;  // of the bounds' distance
  opt.set_initial_step(first_step);
  opt.set_xtol_abs(plan.tolerance);
  opt.set_maxeval(static_cast<int>(100 * std::min(plan.evaluations, 1000000L)));  // the seeker counts runs
  double least = 0;
  try {
    switch (opt.optimize(u, least)) {
      case nlopt::XTOL_REACHED:
        return "converged";
      case nlopt::MAXEVAL_REACHED:
        return "moves between designs that it knows";
      default:
        return "converged by its own rule";
    }
  } catch (const nlopt::forced_stop&) {
    return "all its evaluations were used";
  } catch (const nlopt::roundoff_limited&) {
    return "ended by rounding";
  } catch (const std::invalid_argument& error) {
    return fmt::format("NLopt refused: {}", error.what());
  }
}

/// Kriging of what all known designs are worth.
class Models {
 public:
  explicit Models(const Seeker& seeker) : constraints_(seeker.constraints()) {
    std::vector<std::pair<const Design*, const Worth*>> good;
    for (const auto& [u, w] : seeker.known())
      if (w.whole) good.emplace_back(&u, &w);
    const auto n = static_cast<Eigen::Index>(good.size());
    if (n == 0) return;
    Eigen::MatrixXd points(n, static_cast<Eigen::Index>(good[0].first->size()));
    if (n < points.cols() + 2) return;
    Eigen::MatrixXd values(n, static_cast<Eigen::Index>(1 + constraints_));
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& [u, w] = good[static_cast<std::size_t>(i)];
      points.row(i) = Eigen::Map<const Eigen::RowVectorXd>(u->data(), points.cols());
      values(i, 0) = w->objective;
      for (std::size_t c = 0; c < constraints_; ++c) values(i, static_cast<Eigen::Index>(c + 1)) = w->excess[c];
    }
    for (Eigen::Index k = 0; k < values.cols(); ++k) {
      const double middle = values.col(k).mean();
      spreads_.push_back(std::sqrt((values.col(k).array() - middle).square().mean()));
      models_.emplace_back(points, values.col(k), 0.0);
    }
  }
  bool empty() const { return models_.empty(); }

  /// Objective in its spreads, with a steep price for what a constraint is missed by.
  /// @param margins by which each excess is to be less than its limit
  double badness(const Eigen::VectorXd& u, double sign, const Seeker& seeker,
                 const std::vector<double>& margins) const {
    constexpr double price = 1e3;
    double sum = sign * models_[0].value(u) / (spreads_[0] > 0 ? spreads_[0] : 1);
    for (std::size_t c = 0; c < constraints_; ++c) {
      const double off = (models_[c + 1].value(u) + margins[c]) / (spreads_[c + 1] > 0 ? spreads_[c + 1] : 1);
      const double missed = seeker.is_equation(c) ? off : std::max(0.0, off);
      sum += price * missed * missed;
    }
    return sum;
  }

 private:
  std::size_t constraints_;
  std::vector<Surrogate> models_;
  std::vector<double> spreads_;
};

std::string by_surrogate(Seeker& seeker, const Design& start, std::uint64_t seed) {
  const OptimisePlan& plan = seeker.plan();
  const auto p = static_cast<long>(start.size());
  std::vector<Design> design =
      latin_hypercube(std::min(5 * p + 3, plan.evaluations - 1), start.size(), static_cast<long>(seed));
  design.insert(design.begin(), start);
  if (!seeker.ask(design)) return "all its evaluations were used";
  const double sign = plan.minimise.empty() ? -1 : 1;
  // The price lets the models' optimum lie beyond a limit by a little, and so do their errors: where designs that miss
  // a constraint have been run there already, the next aims that much inside.
  std::vector<double> margins(seeker.constraints(), 0.0);
  constexpr int most_corrections =
      10;  // each is a run beside those before; where no design keeps the constraints, none helps
  int corrections = 0;
  for (;;) {
    const Models models(seeker);
    if (models.empty()) return "too few designs give numbers for a surrogate";
    const auto optimum = [&] {
      return minimise(static_cast<int>(p),
                      [&](const Eigen::VectorXd& at) { return models.badness(at, sign, seeker, margins); });
    };
    Eigen::VectorXd u = optimum();
    const Worth* nearest = nullptr;
    bool any_keeps = false;
    const double radius = std::max(plan.tolerance, 1e-3);
    double least = radius;
    for (const auto& [design, worth] : seeker.known()) {
      const double off = (Eigen::Map<const Eigen::VectorXd>(design.data(), p) - u).lpNorm<Eigen::Infinity>();
      any_keeps = any_keeps || (off < radius && seeker.is_feasible(worth));
      if (off < least) least = off, nearest = &worth;
    }
    if (nearest != nullptr) {
      if (any_keeps || !nearest->whole || corrections++ == most_corrections)
        return "the surrogate's optimum had been run";
      for (std::size_t c = 0; c < margins.size(); ++c)
        if (!seeker.keeps(*nearest, c)) margins[c] += nearest->excess[c];
      u = optimum();
    }
    if (!seeker.ask({Design(u.data(), u.data() + p)})) return "all its evaluations were used";
  }
}

}  // namespace

SearchMethod method_of(const OptimisePlan& plan) {
  if (plan.method != SearchMethod::automatic) return plan.method;
  // BOBYQA interpolates in two dimensions or more.
  return plan.constraints.empty() && plan.parameters.size() > 1 ? SearchMethod::bobyqa : SearchMethod::cobyla;
}

const char* word_of(SearchMethod method) {
  constexpr const char* words[] = {"auto", "bobyqa", "cobyla", "slsqp", "isres", "surrogate"};
  return words[static_cast<std::size_t>(method)];
}

SearchEnd search_optimum(const OptimisePlan& plan, const Design& start, std::uint64_t seed, const Ask& ask) {
  Seeker seeker(plan, ask);
  const SearchMethod method = method_of(plan);
  SearchEnd end;
  if (method == SearchMethod::surrogate) {
    end.words = by_surrogate(seeker, start, seed);
  } else {
    seeker.ask({start});
    end.words = seeker.any_whole() ? by_nlopt(seeker, method, start, seed) : "its first design gives no numbers";
  }
  end.evaluations = seeker.asked();
  return end;
}

}  // namespace subsoil::sim
