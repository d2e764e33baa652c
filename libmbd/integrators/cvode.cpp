#include "libmbd/integrators/cvode.hpp"

#include <cvode/cvode.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "libmbd/assembly/shared_reactions.hpp"
#include "libmbd/integrators/kinematic.hpp"
#include "libmbd/integrators/sundials.hpp"

namespace subsoil::mbd {

namespace {

using sundials::ConstMap;
using sundials::Map;

// rad; there the constraints may be met on another branch.
constexpr double beside_singular = 0.5;

// Of a motion whose forces do not say how fast they change, as at rest (s).
constexpr double longest_first_step = 0.01;

void check_cvode(int code, const char* call) { sundials::check(code, call, CVodeGetReturnFlagName); }
template <class Pointer>
Pointer* check_cvode(Pointer* pointer, const char* call) {
  return sundials::check(pointer, call);
}

}  // namespace

struct Cvode::Solver {
  System& system;
  Partition& partition;
  const Switches& switches;
  Eigen::Index f, e;
  std::vector<int> set;  // independent coordinates that y holds
  sundials::Context context;
  sundials::Vector y, dense, tolerance;
  void* memory = nullptr;
  SUNNonlinearSolver iteration = nullptr;
  MotionState trial, good;  // good: last one whose joints closed, from which guesses are carried on
  MotionState begin;        // the same as the step began: trials of a step that failed are no guide to a shorter one
  Eigen::VectorXd expected;
  std::exception_ptr thrown;
  long steps_before = 0, evaluations_before = 0;
  bool stopped = false;  // by the stop time

  Solver(System& s, Partition& p, const Switches& w, const MotionState& at)
      : system(s),
        partition(p),
        switches(w),
        f(p.freedom()),
        e(at.rates.size()),
        set(p.independent()),
        y(size(), context),
        dense(size(), context),
        tolerance(size(), context),
        trial(at),
        good(at),
        begin(at) {}
  ~Solver() {
    if (memory) CVodeFree(&memory);
    if (iteration) SUNNonlinSolFree(iteration);
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  /// A machine that nothing moves has no unknowns, and CVODE no use for a vector of none: one that stays 0.
  Eigen::Index size() const { return std::max<Eigen::Index>(2 * f + e, 1); }

  /// v and v' from y, the rest carried on from the last good state.
  void unpack(double t, const double* from, MotionState& out) const {
    out.t = t;
    const double dt = t - good.t;
    out.q = good.q + dt * good.velocity + 0.5 * dt * dt * good.acceleration;
    out.velocity = good.velocity + dt * good.acceleration;
    for (Eigen::Index i = 0; i < f; ++i) {
      out.q[set[static_cast<std::size_t>(i)]] = from[i];
      out.velocity[set[static_cast<std::size_t>(i)]] = from[f + i];
    }
    out.states = ConstMap(from + 2 * f + e - good.states.size(), good.states.size());
  }
  /// No tolerance is below what rounding of q makes of the motion: a position known to delta, whose rounding changes
  /// its acceleration by a, swings by rounding at sqrt(a/delta) and with the velocity sqrt(a delta).
  void set_tolerances(const CvodeOptions& options, const MotionState& now) {
    const double rtol = local_tolerance(options.rtol, 1e-14), atol = local_tolerance(options.atol, 1e-15);
    Map weight = tolerance.map();
    weight.setConstant(atol);
    weight.segment(2 * f, e).setConstant(1e2 * atol);
    const std::vector<double>& scales = system.state_scales();
    for (std::size_t i = 0; i < scales.size(); ++i)
      weight[2 * f + system.flow_count() + static_cast<Eigen::Index>(i)] = atol * scales[i];
    raise_to_rounding(now, weight);
    check_cvode(CVodeSVtolerances(memory, rtol, tolerance), "CVodeSVtolerances");
  }
  void raise_to_rounding(const MotionState& now, Map& weight) {
    // Nearer to the origin rounding is that of the machine's own lengths, which the tolerances are made for.
    constexpr double far_away = 100;
    double farthest = 0;
    for (Eigen::Index i = 0; i < now.q.size(); ++i)
      if (i % 3 != 2) farthest = std::max(farthest, std::abs(now.q[i]));
    if (!(farthest > far_away * system.length_scale())) return;
    try {
      raise(now, weight);
    } catch (const std::runtime_error&) {  // so near the end of what can be evaluated nothing is measured
    }
    partition.evaluate(trial = now);
  }
  void raise(const MotionState& now, Map& weight) {
    double ulp = 0;
    for (const int i : set) ulp = std::max(ulp, std::abs(now.q[i]));
    ulp *= std::numeric_limits<double>::epsilon();
    if (!(ulp > 0)) return;
    for (const int other : {1, -1}) {  // all one way, and neighbours against each other
      trial = now;
      int sign = 1;
      for (const int i : set)
        trial.q[i] += sign * std::numeric_limits<double>::epsilon() * std::abs(now.q[i]), sign *= other;
      partition.evaluate(trial);
      double fastest = 0;
      for (Eigen::Index i = 0; i < f; ++i) {
        const int k = set[static_cast<std::size_t>(i)];
        const double speed = std::sqrt(std::abs(trial.acceleration[k] - now.acceleration[k]) * ulp);
        weight[f + i] = std::max(weight[f + i], speed);
        fastest = std::max(fastest, speed);
      }
      const Eigen::Index flows = system.flow_count();
      if (!(fastest > 0)) continue;
      for (Eigen::Index i = 0; i < flows; ++i)
        weight[2 * f + i] = std::max(weight[2 * f + i], std::abs(trial.rates[i] - now.rates[i]) * ulp / fastest);
    }
  }
  void evaluate(double t, N_Vector from) {
    unpack(t, N_VGetArrayPointer(from), trial);
    expected = trial.q;
    try {
      partition.evaluate(trial);
      if (distance_of(system, trial.q, expected) > branch_limit(system))
        throw std::runtime_error("t = " + std::to_string(t) +
                                 " s: the pose jumps; the motion leads through a dead point or a lock-up");
      if (partition.distance_from_singular() < beside_singular) partition.refuse_other_branch(trial);
    } catch (const std::runtime_error&) {
      carry_on_from(begin);
      throw;
    }
    carry_on_from(trial);
  }
  void carry_on_from(const MotionState& m) {
    good.t = m.t, good.q = m.q, good.velocity = m.velocity, good.acceleration = m.acceleration;
    good.lambda = m.lambda;
  }

  static int right_side(realtype t, N_Vector y, N_Vector dy, void* self) {
    auto& s = *static_cast<Solver*>(self);
    return sundials::guarded(s.thrown, 1, [&] {  // 1: a shorter step may do
      s.evaluate(t, y);
      double* out = N_VGetArrayPointer(dy);
      out[s.size() - 1] = 0;
      for (Eigen::Index i = 0; i < s.f; ++i) {
        out[i] = s.trial.velocity[s.set[static_cast<std::size_t>(i)]];
        out[s.f + i] = s.trial.acceleration[s.set[static_cast<std::size_t>(i)]];
      }
      for (Eigen::Index i = 0; i < s.e; ++i) out[2 * s.f + i] = s.trial.rates[i];
    });
  }
  static int roots(realtype t, N_Vector y, realtype* out, void* self) {
    auto& s = *static_cast<Solver*>(self);
    return sundials::guarded(s.thrown, -1, [&] {
      s.evaluate(t, y);
      s.system.set_multipliers(s.trial.lambda);
      const SharedReactions reactions(s.system, s.partition.used_rows().size(), s.trial.lambda,
                                      events_read_reactions(s.system));
      s.switches.gaps({out, s.switches.count()}, &s.trial.acceleration, &reactions.lambda());
    });
  }
};

Cvode::Cvode(System& system, const CvodeOptions& options) : Adaptive(system), options_(options) {
  if (!(options.rtol > 0) || !(options.atol > 0))
    throw std::invalid_argument("cvode: rtol and atol must be above 0; 1e-8 and 1e-10 are usual");
}

Cvode::~Cvode() = default;

void Cvode::build() {
  const long steps_before = steps(), evaluations_before = evaluations();
  solver_ = std::make_unique<Solver>(system_, partition_, switches_, now_);
  auto& s = *solver_;
  s.steps_before = steps_before, s.evaluations_before = evaluations_before;
  s.memory = check_cvode(CVodeCreate(CV_ADAMS, s.context), "CVodeCreate");
  check_cvode(CVodeSetErrHandlerFn(s.memory, sundials::silence, nullptr), "CVodeSetErrHandlerFn");
  check_cvode(CVodeInit(s.memory, Solver::right_side, now_.t, s.y), "CVodeInit");
  check_cvode(CVodeSetUserData(s.memory, &s), "CVodeSetUserData");
  s.iteration = check_cvode(SUNNonlinSol_FixedPoint(s.y, 0, s.context), "SUNNonlinSol_FixedPoint");
  check_cvode(CVodeSetNonlinearSolver(s.memory, s.iteration), "CVodeSetNonlinearSolver");
  check_cvode(CVodeSetMaxErrTestFails(s.memory, most_failures_of_a_step), "CVodeSetMaxErrTestFails");
  check_cvode(CVodeSetMaxConvFails(s.memory, most_failures_of_a_step), "CVodeSetMaxConvFails");
  if (!watches_switches()) return;
  check_cvode(CVodeRootInit(s.memory, static_cast<int>(switches_.count()), Solver::roots), "CVodeRootInit");
  check_cvode(CVodeSetNoInactiveRootWarn(s.memory), "CVodeSetNoInactiveRootWarn");
}

void Cvode::begin() {
  auto& s = *solver_;
  s.steps_before = steps(), s.evaluations_before = evaluations();
  s.set = partition_.independent();
  s.trial = s.good = s.begin = now_;
  Map y = s.y.map();
  y.setZero();
  for (Eigen::Index i = 0; i < s.f; ++i) {
    y[i] = now_.q[s.set[static_cast<std::size_t>(i)]];
    y[s.f + i] = now_.velocity[s.set[static_cast<std::size_t>(i)]];
  }
  y.segment(2 * s.f, s.e) = flows_.of_elements;
  check_cvode(CVodeReInit(s.memory, now_.t, s.y), "CVodeReInit");
  s.set_tolerances(options_, now_);
}

long Cvode::steps() const {
  if (!solver_ || !solver_->memory) return 0;
  long count = 0;
  check_cvode(CVodeGetNumSteps(solver_->memory, &count), "CVodeGetNumSteps");
  return solver_->steps_before + count;
}

long Cvode::evaluations() const {
  if (!solver_ || !solver_->memory) return 0;
  long count = 0;
  check_cvode(CVodeGetNumRhsEvals(solver_->memory, &count), "CVodeGetNumRhsEvals");
  return solver_->evaluations_before + count;
}

Adaptive::Reached Cvode::take_step(double stop) {
  auto& s = *solver_;
  if (std::isfinite(stop)) check_cvode(CVodeSetStopTime(s.memory, stop), "CVodeSetStopTime");
  double t = s.good.t;
  s.begin = s.good;
  s.thrown = nullptr;
  // With single steps the end only bounds the first one, to a tenth.
  const int code = CVode(s.memory, t + 10 * longest_first_step, s.y, &t, CV_ONE_STEP);
  if (s.thrown) failure_ = s.thrown;
  const bool joints = code == CV_FIRST_RHSFUNC_ERR || code == CV_REPTD_RHSFUNC_ERR || code == CV_UNREC_RHSFUNC_ERR ||
                      code == CV_RTFUNC_FAIL;
  if (joints && s.thrown) std::rethrow_exception(s.thrown);
  sundials::check_step(code, t, CVodeGetReturnFlagName);
  s.stopped = code == CV_TSTOP_RETURN;
  return {t, code == CV_ROOT_RETURN};
}

double Cvode::planned_step() const {
  const auto& s = *solver_;
  double next = 0;
  // Steps are at most tenfold the one before. What CVODE plans it does not say after a stop.
  if (steps() == s.steps_before) return longest_first_step;
  check_cvode(s.stopped ? CVodeGetLastStep(s.memory, &next) : CVodeGetCurrentStep(s.memory, &next),
              "CVodeGetCurrentStep");
  return s.stopped ? 10 * next : next;
}

void Cvode::read(double t) {
  auto& s = *solver_;
  check_cvode(CVodeGetDky(s.memory, t, 0, s.dense), "CVodeGetDky");
  s.unpack(t, s.dense.map().data(), now_);
  flows_.of_elements = s.dense.map().segment(2 * s.f, s.e);
}

void Cvode::dense(double t, Piece& out) {
  auto& s = *solver_;
  double last = 0;
  check_cvode(CVodeGetCurrentTime(s.memory, &last), "CVodeGetCurrentTime");
  check_cvode(CVodeGetLastStep(s.memory, &out.polynomial.scale), "CVodeGetLastStep");
  check_cvode(CVodeGetDky(s.memory, t, 0, s.dense), "CVodeGetDky");
  s.unpack(t, s.dense.map().data(), out.end);
  out.end.acceleration = s.good.acceleration, out.end.lambda = s.good.lambda;
  out.polynomial.centre = last;
  out.polynomial.set = s.set;
  sundials::take_powers(s.dense, 2 * s.f + s.e, out.polynomial,
                        [&](int k, N_Vector into) { return CVodeGetDky(s.memory, last, k, into); });
}

void Cvode::root_directions(std::vector<int>& out) {
  check_cvode(CVodeGetRootInfo(solver_->memory, out.data()), "CVodeGetRootInfo");
}

}  // namespace subsoil::mbd
