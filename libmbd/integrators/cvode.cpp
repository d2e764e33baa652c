#include "libmbd/integrators/cvode.hpp"

#include <cvode/cvode.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "libmbd/assembly/shared_reactions.hpp"
#include "libmbd/base/dense.hpp"
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
  double rtol = 0;
  void* memory = nullptr;
  SUNNonlinearSolver iteration = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  bool implicit;
  MotionState trial, good;  // good: last one whose joints closed, from which guesses are carried on
  MotionState begin;        // the same as the step began: trials of a step that failed are no guide to a shorter one
  Eigen::VectorXd expected;
  std::vector<double> values;  // of the switching functions, as they were evaluated last
  std::exception_ptr thrown;
  long steps_before = 0, evaluations_before = 0, of_jacobians = 0;
  bool stopped = false;  // by the stop time
  Inputs::Inside inside;
  std::unique_ptr<Partition> of_spectrum;
  Eigen::MatrixXd jacobian;  // of v', v'' and the rates of the states by v, v' and the states
  Eigen::VectorXd shifted, at_state;

  Solver(System& s, Partition& p, const Switches& w, const MotionState& at, bool by_newton)
      : system(s),
        partition(p),
        switches(w),
        f(p.freedom()),
        e(at.rates.size()),
        set(p.independent()),
        y(size(), context),
        dense(size(), context),
        tolerance(size(), context),
        implicit(by_newton),
        trial(at),
        good(at),
        begin(at) {}
  ~Solver() {
    if (memory) CVodeFree(&memory);
    if (iteration) SUNNonlinSolFree(iteration);
    if (linear) SUNLinSolFree(linear);
    if (matrix) SUNMatDestroy(matrix);
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
  /// Functional iteration, or Newton's.
  void choose_iteration() {
    if (!implicit) {
      iteration = check_cvode(SUNNonlinSol_FixedPoint(y, 0, context), "SUNNonlinSol_FixedPoint");
      return check_cvode(CVodeSetNonlinearSolver(memory, iteration), "CVodeSetNonlinearSolver");
    }
    matrix = check_cvode(SUNDenseMatrix(size(), size(), context), "SUNDenseMatrix");
    linear = check_cvode(SUNLinSol_Dense(y, matrix, context), "SUNLinSol_Dense");
    check_cvode(CVodeSetLinearSolver(memory, linear, matrix), "CVodeSetLinearSolver");
    check_cvode(CVodeSetJacFn(memory, Solver::newton_matrix), "CVodeSetJacFn");
  }
  /// No tolerance is below what rounding of q makes of the motion: a position known to delta, whose rounding changes
  /// its acceleration by a, swings by rounding at sqrt(a/delta) and with the velocity sqrt(a delta).
  void set_tolerances(const CvodeOptions& options, const MotionState& now) {
    rtol = local_tolerance(options.rtol, 1e-14);
    const double atol = local_tolerance(options.atol, 1e-15);
    Map weight = tolerance.map();
    weight.setConstant(atol);
    // J; of a machine without freedom energies alone decide the steps, and a small one's are small: of one length of
    // the machine in a second.
    const double of_machine = system.model().mass() * system.length_scale() * system.length_scale();
    weight.segment(2 * f, e).setConstant(1e2 * atol * (f > 0 ? 1 : std::min(1.0, of_machine)));
    const std::vector<double>& scales = system.state_scales();
    for (std::size_t i = 0; i < scales.size(); ++i)
      weight[2 * f + system.flow_count() + static_cast<Eigen::Index>(i)] = atol * scales[i];
    raise_to_rounding(now, weight);
  }
  /// CVODE's own vector of tolerances is that of the start alone.
  static int weights(N_Vector of, N_Vector out, void* self) {
    auto& s = *static_cast<Solver*>(self);
    const ConstMap at(N_VGetArrayPointer(of), s.size());
    Map(N_VGetArrayPointer(out), s.size()) = (s.rtol * at.cwiseAbs() + s.tolerance.map()).cwiseInverse();
    return 0;
  }
  /// Rounding grows as a structure leaves its straight pose, where only its axial forces show any: stiff steps would
  /// shrink to it.
  void measure_rounding(const CvodeOptions& options) {
    double t = 0;
    check_cvode(CVodeGetCurrentTime(memory, &t), "CVodeGetCurrentTime");
    MotionState now = good;
    unpack(t, y.map().data(), now);
    try {
      partition.evaluate(now);
    } catch (const std::runtime_error&) {  // beside the end of what can be evaluated nothing is measured
      return;
    }
    set_tolerances(options, now);
  }
  void raise_to_rounding(const MotionState& now, Map& weight) {
    // Nearer to the origin rounding is that of the machine's own lengths, which the tolerances are made for; where
    // nothing moves fast, as behind a fast decay, stiff forces still make more of it.
    constexpr double far_away = 100;
    double farthest = 0;
    for (Eigen::Index i = 0; i < now.q.size(); ++i)
      if (i % 3 != 2) farthest = std::max(farthest, std::abs(now.q[i]));
    if (!implicit && !(farthest > far_away * system.length_scale())) return;
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
  Eigen::Index states() const { return good.states.size(); }
  /// Place in y of an unknown that the motion depends on: v, v', states. The flows are integrals beside it.
  Eigen::Index place(Eigen::Index unknown) const { return unknown < 2 * f ? unknown : unknown + e - states(); }
  /// Its size of 1 in the machine: a length, a radian, one of these in a second, the scale of the state.
  double scale(Eigen::Index unknown) const {
    if (unknown >= 2 * f) return system.state_scales()[static_cast<std::size_t>(unknown - 2 * f)];
    return set[static_cast<std::size_t>(unknown % f)] % 3 == 2 ? 1 : system.length_scale();
  }
  /// Rates of v, v', all of e at a state near the good one.
  void rates(Partition& by, double t, const double* from, double* out) {
    unpack(t, from, trial);
    by.evaluate(trial);
    take_rates(out);
  }
  void take_rates(double* out) const {
    out[size() - 1] = 0;
    for (Eigen::Index i = 0; i < f; ++i) {
      out[i] = trial.velocity[set[static_cast<std::size_t>(i)]];
      out[f + i] = trial.acceleration[set[static_cast<std::size_t>(i)]];
    }
    for (Eigen::Index i = 0; i < e; ++i) out[2 * f + i] = trial.rates[i];
  }
  /// The columns of `jacobian` by differences, all rows of y'. The increment balances the rounding of what the unknown
  /// is known to against the curvature over its scale. Ends at the state itself.
  void differentiate(Partition& by, double t, const double* from) {
    const Eigen::Index n = 2 * f + states();
    jacobian.resize(size(), n), shifted.resize(size()), at_state.resize(size());
    const ConstMap at(from, size());
    rates(by, t, from, at_state.data());
    for (Eigen::Index j = 0; j < n; ++j) {
      const double unit = scale(j), value = std::abs(at[place(j)]);
      shifted = at;
      shifted[place(j)] += std::sqrt(std::numeric_limits<double>::epsilon() * std::max(value, unit) * unit);
      const double increment = shifted[place(j)] - at[place(j)];
      rates(by, t, shifted.data(), jacobian.col(j).data());
      jacobian.col(j) = (jacobian.col(j) - at_state) / increment;
    }
    rates(by, t, from, at_state.data());
    of_jacobians += n + 2;
  }
  static int newton_matrix(realtype t, N_Vector from, N_Vector, SUNMatrix into, void* self, N_Vector, N_Vector,
                           N_Vector) {
    auto& s = *static_cast<Solver*>(self);
    return sundials::guarded(s.thrown, 1, [&] {
      s.differentiate(s.partition, t, N_VGetArrayPointer(from));
      for (Eigen::Index j = 0; j < s.jacobian.cols(); ++j)
        Map(SUNDenseMatrix_Column(into, s.place(j)), s.size()) = s.jacobian.col(j);
    });
  }
  /// At the end of a step, by a partition of its own: what is measured changes no bit of the motion.
  StiffnessMonitor::Spectrum spectrum() {
    double t = 0;
    check_cvode(CVodeGetCurrentTime(memory, &t), "CVodeGetCurrentTime");
    if (!of_spectrum) of_spectrum = std::make_unique<Partition>(system);
    StiffnessMonitor::Spectrum out;
    try {
      of_spectrum->adopt(partition.choice());
      differentiate(*of_spectrum, t, y.map().data());
    } catch (const std::runtime_error&) {  // beside the end of what can be evaluated nothing is measured
      return out;
    }
    const Eigen::Index n = jacobian.cols();
    Eigen::MatrixXd scaled(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) scaled(i, j) = jacobian(place(i), j) * scale(j) / scale(i);
    if (n == 0 || !scaled.allFinite()) return out;
    const Eigen::VectorXcd values = eigenvalues(scaled);
    for (const std::complex<double>& value : values) {
      const double size = std::abs(value);
      out.radius = std::max(out.radius, size);
      if (-value.real() > StiffnessMonitor::damping_ratio * size) out.decay = std::max(out.decay, size);
    }
    return out;
  }
  long count(int (*of)(void*, long*), const char* call) const {
    long n = 0;
    if (memory) check_cvode(of(memory, &n), call);
    return n;
  }
  long right_sides() const { return of_jacobians + count(CVodeGetNumRhsEvals, "CVodeGetNumRhsEvals"); }
  void evaluate(double t, N_Vector from) {
    unpack(inside.time(t), N_VGetArrayPointer(from), trial);
    expected = trial.q;
    try {
      partition.evaluate(trial);
      if (distance_of(system, trial.q, expected) > branch_limit(system))
        throw MotionFault(t, "the pose jumps; the motion leads through a dead centre or a lock-up");
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
      s.take_rates(N_VGetArrayPointer(dy));
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
      s.values.assign(out, out + s.switches.count());
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
  solver_ = std::make_unique<Solver>(system_, partition_, switches_, now_, stiffness_.implicit());
  auto& s = *solver_;
  s.steps_before = steps_before, s.evaluations_before = evaluations_before;
  s.memory = check_cvode(CVodeCreate(s.implicit ? CV_BDF : CV_ADAMS, s.context), "CVodeCreate");
  check_cvode(CVodeSetErrHandlerFn(s.memory, sundials::silence, nullptr), "CVodeSetErrHandlerFn");
  check_cvode(CVodeInit(s.memory, Solver::right_side, now_.t, s.y), "CVodeInit");
  check_cvode(CVodeSetUserData(s.memory, &s), "CVodeSetUserData");
  check_cvode(CVodeWFtolerances(s.memory, Solver::weights), "CVodeWFtolerances");
  s.choose_iteration();
  check_cvode(CVodeSetMaxErrTestFails(s.memory, most_failures_of_a_step), "CVodeSetMaxErrTestFails");
  check_cvode(CVodeSetMaxConvFails(s.memory, most_failures_of_a_step), "CVodeSetMaxConvFails");
  if (!watches_switches()) return;
  check_cvode(CVodeRootInit(s.memory, static_cast<int>(switches_.count()), Solver::roots), "CVodeRootInit");
  check_cvode(CVodeSetNoInactiveRootWarn(s.memory), "CVodeSetNoInactiveRootWarn");
}

void Cvode::on_start() {
  stiffness_ = {};
  Adaptive::on_start();
}

void Cvode::begin() {
  if (solver_->implicit != stiffness_.implicit()) build();
  stiffness_.begun();
  auto& s = *solver_;
  s.steps_before = steps(), s.evaluations_before = evaluations();
  s.of_jacobians = 0;
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
  return solver_ ? solver_->steps_before + solver_->count(CVodeGetNumSteps, "CVodeGetNumSteps") : 0;
}

long Cvode::evaluations() const { return solver_ ? solver_->evaluations_before + solver_->right_sides() : 0; }

bool Cvode::wants_restart() {
  if (stiffness_.asks_for_spectrum()) {
    stiffness_.see(solver_->spectrum());
    if (solver_->implicit && !stiffness_.wants_change()) solver_->measure_rounding(options_);
  }
  return stiffness_.wants_change();
}

Adaptive::Reached Cvode::take_step(double stop, const Inputs::Inside& inside) {
  auto& s = *solver_;
  s.inside = inside;
  if (std::isfinite(stop)) check_cvode(CVodeSetStopTime(s.memory, stop), "CVodeSetStopTime");
  double t = s.good.t, taken = 0;
  const long evaluations_before = s.right_sides();
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
  check_cvode(CVodeGetLastStep(s.memory, &taken), "CVodeGetLastStep");
  stiffness_.count(taken, s.right_sides() - evaluations_before, 2 * s.f + s.states());
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

void Cvode::dense(double t, StepSegment& out) {
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

const std::vector<double>& Cvode::end_values() const { return solver_->values; }

void Cvode::root_directions(std::vector<int>& out) {
  check_cvode(CVodeGetRootInfo(solver_->memory, out.data()), "CVodeGetRootInfo");
}

}  // namespace subsoil::mbd
