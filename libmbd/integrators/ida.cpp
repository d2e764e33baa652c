#include "libmbd/integrators/ida.hpp"

#include <ida/ida.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/shared_reactions.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/integrators/sundials.hpp"

namespace subsoil::mbd {

namespace {

using sundials::ConstMap;
using sundials::Map;

void check_ida(int code, const char* call) { sundials::check(code, call, IDAGetReturnFlagName); }
template <class Pointer>
Pointer* check_ida(Pointer* pointer, const char* call) {
  return sundials::check(pointer, call);
}

/// The bodies that beams join, each once, from 0.
std::vector<Eigen::Index> nodes_of_beams(const Model& model) {
  std::vector<Eigen::Index> out;
  for (const auto& f : model.forces)
    if (const BeamElement* beam = f.element.get_if<BeamElement>())
      for (const int body : {beam->body_a, beam->body_b})
        if (body != ground) out.push_back(body - 1);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace

struct Ida::Solver {
  System& system;
  Partition& partition;
  const Switches& switches;
  double rtol, asked;  // of a step; how many times that the tolerance asked for is
  bool index_1;
  std::vector<int> rows;
  std::vector<Eigen::Index> nodes;  // of beams
  Eigen::Index n, r, e;             // coordinates, equations used, energy flows
  sundials::Context context;
  sundials::Vector y, dy, dense, tolerance, id;
  void* memory = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  Constraints c;
  Eigen::VectorXd q, w, load, lambda, mu, correction, states, acceleration;
  bool reactions_decide;       // an event of a joint, or friction that sticks
  MotionState solution;        // for these
  std::vector<double> values;  // of the switching functions, as they were evaluated last
  std::exception_ptr thrown;
  long steps_before = 0, evaluations_before = 0, of_jacobians = 0;
  bool fresh = true;  // no step since the last beginning

  Solver(System& s, Partition& p, const Switches& g, bool accelerations, const MotionState& at,
         double relative_tolerance, double asked_of_it)
      : system(s),
        partition(p),
        switches(g),
        rtol(relative_tolerance),
        asked(asked_of_it),
        index_1(accelerations),
        rows(p.used_rows()),
        nodes(nodes_of_beams(s.model())),
        n(s.coordinates()),
        r(static_cast<Eigen::Index>(rows.size())),
        e(at.rates.size()),
        y(size(), context),
        dy(size(), context),
        dense(size(), context),
        tolerance(size(), context),
        id(size(), context),
        q(n),
        w(n),
        load(n),
        lambda(s.equations()),
        mu(s.equations()),
        correction(n),
        reactions_decide(events_read_reactions(s)),
        solution(at) {
    for (std::size_t i = 0; i < g.count() && !s.friction_rows().empty(); ++i)
      reactions_decide = reactions_decide || g.of_friction(i);
  }
  ~Solver() {
    if (memory) IDAFree(&memory);
    if (linear) SUNLinSolFree(linear);
    if (matrix) SUNMatDestroy(matrix);
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  Eigen::Index multipliers() const { return index_1 ? r : 2 * r; }
  Eigen::Index size() const { return 2 * n + multipliers() + e; }

  void set_weights(double atol) const {
    Map weight = tolerance.map(), kind = id.map();
    weight.head(2 * n).setConstant(atol);
    // lambda and mu stand outside the error test, and outside Newton's too: rounding e of q and w returns in them as
    // e M/h and e/h, without bound as a step is cut short by a stop time. q, w and e in the same iteration decide. The
    // residual is linear in both, so the large increments that IDA's differences take from here lose nothing; with
    // friction it is not (differences()).
    weight.segment(2 * n, multipliers()).setConstant(1e12);
    weight.tail(e).setConstant(1e2 * atol);
    const std::vector<double>& scales = system.state_scales();
    for (std::size_t i = 0; i < scales.size(); ++i)
      weight[size() - static_cast<Eigen::Index>(scales.size() - i)] = atol * scales[i];
    kind.setOnes();
    kind.segment(2 * n, multipliers()).setZero();
  }

  void set_state(double t, const ConstMap& yy) {
    q = yy.head(n), w = yy.segment(n, n);
    system.set_state(t, q, w);
    states = yy.tail(static_cast<Eigen::Index>(system.state_count()));
    system.set_element_states(states);
  }

  void residual(double t, const ConstMap& yy, const ConstMap& yp, Map res) {
    set_state(t, yy);
    system.constraints(c);
    lambda.setZero(), mu.setZero();
    for (Eigen::Index i = 0; i < r; ++i) {
      const int row = rows[static_cast<std::size_t>(i)];
      lambda[row] = yy[2 * n + i];
      if (index_1) {
        res[2 * n + i] = c.jacobian.row(row).dot(yp.segment(n, n)) - c.gamma[row];
        continue;
      }
      mu[row] = yy[2 * n + r + i];
      res[2 * n + i] = c.phi[row];
      res[2 * n + r + i] = c.jacobian.row(row).dot(w) + c.phi_t[row];
    }
    system.set_multipliers(lambda);  // of which friction is made
    system.loads(load);
    res.head(n) = yp.head(n) - w;
    if (!index_1) {
      correction.noalias() = c.jacobian.transpose() * mu;
      res.head(n) += correction;
    }
    correction.noalias() = c.jacobian.transpose() * lambda;
    res.segment(n, n) = yp.segment(n, n) + (correction - load).cwiseQuotient(system.mass());
    energy_residual(yp, res);
  }

  void energy_residual(const ConstMap& yp, Map& res) {
    const auto forces = static_cast<Eigen::Index>(system.model().forces.size());
    const Eigen::Index first = 2 * n + multipliers(), flows = system.flow_count();
    for (Eigen::Index i = 0; i < flows; ++i) {
      double power = 0;
      if (i < forces) {
        power = system.powers()[static_cast<std::size_t>(i)].lost;
      } else if (i < 2 * forces) {
        power = system.powers()[static_cast<std::size_t>(i - forces)].work;
      } else {
        const int row = system.row_of_driver(static_cast<std::size_t>(i - 2 * forces));
        power = lambda[row] * c.phi_t[row];
      }
      res[first + i] = yp[first + i] - power;
    }
    if (e == flows) return;
    acceleration = yp.segment(n, n);
    const SharedReactions reactions(system, rows.size(), lambda, controllers_read_reactions(system));
    const std::vector<double>& rates = system.take_state_rates(acceleration, reactions.lambda());
    for (Eigen::Index i = flows; i < e; ++i)
      res[first + i] = yp[first + i] - rates[static_cast<std::size_t>(i - flows)];
  }

  /// m, of the farthest place, and of the pitch circle that has turned most, as gears know places by angles: where it
  /// is more than that of the machine's own lengths, which the tolerances are made for; else 0.
  double rounding_of_places(const ConstMap& y) const {
    constexpr double far_away = 10;
    double farthest = 0;
    for (Eigen::Index i = 0; i < n; ++i) farthest = std::max(farthest, arm(i) * std::abs(y[i]));
    return farthest > far_away * system.length_scale() ? std::numeric_limits<double>::epsilon() * farthest : 0;
  }
  double arm(Eigen::Index i) const { return i % 3 == 2 ? system.body_size(static_cast<int>(i / 3) + 1) : 1; }

  /// 1/(rtol |y| + atol), with the length of a body's x and y for either: a component that passes zero as its body
  /// turns would ask for more digits there than rounding of the pose, divided by a step, leaves. Where rounding is
  /// large that is all that is known of velocities: a tolerance below would shorten the step, and so be farther below.
  /// Velocities of the nodes of beams are one field, of which one may pass zero while the others move. Where a step is
  /// long for the stiff, damped motions of a node it follows the others as by a constraint, and its velocity errs by an
  /// order more than its place: it may err in a step by the tolerance that is asked for the motion as a whole.
  /// Source: C. Lubich, Integration of stiff mechanical systems by Runge-Kutta methods, ZAMP 44 (1993) 1022.
  static int call_weights(N_Vector yy, N_Vector out, void* self) {
    const auto& s = *static_cast<Solver*>(self);
    const ConstMap y(N_VGetArrayPointer(yy), s.size());
    Map weight(N_VGetArrayPointer(out), s.size());
    weight = y.cwiseAbs();
    for (Eigen::Index i = 0; i < 2 * s.n; i += 3) weight.segment(i, 2).setConstant(y.segment(i, 2).norm());
    double speed = 0, turning = 0;
    for (const Eigen::Index node : s.nodes) {
      speed = std::max(speed, weight[s.n + 3 * node]);
      turning = std::max(turning, weight[s.n + 3 * node + 2]);
    }
    for (const Eigen::Index node : s.nodes) {
      weight.segment(s.n + 3 * node, 2).setConstant(speed);
      weight[s.n + 3 * node + 2] = turning;
    }
    weight = s.rtol * weight + s.tolerance.map();
    for (const Eigen::Index node : s.nodes) weight.segment(s.n + 3 * node, 3) *= s.asked;
    double h = 0;
    if (IDAGetCurrentStep(s.memory, &h) == IDA_SUCCESS && h > 0) {
      const double rounding = s.rounding_of_places(y);
      for (Eigen::Index i = 0; i < s.n; ++i) {
        weight[i] = std::max(weight[i], rounding / s.arm(i));
        weight[s.n + i] = std::max(weight[s.n + i], rounding / (s.arm(i) * h));
      }
    }
    weight = weight.cwiseInverse();
    return 0;
  }

  static int call_residual(realtype t, N_Vector yy, N_Vector yp, N_Vector out, void* self) {
    auto& s = *static_cast<Solver*>(self);
    return sundials::guarded(s.thrown, -1, [&] {
      s.residual(t, {N_VGetArrayPointer(yy), s.size()}, {N_VGetArrayPointer(yp), s.size()},
                 {N_VGetArrayPointer(out), s.size()});
    });
  }
  /// J = dF/dy + cj dF/dy' by differences as IDA makes them, but for lambda and mu, whose increments are of the forces'
  /// size: friction is made of |lambda|.
  void differences(double t, double cj, Map yy, Map yp, const ConstMap& at, SUNMatrix jacobian, Map work) {
    constexpr double share = 1.4901161193847656e-08;  // sqrt(epsilon)
    double h = 0;
    IDAGetCurrentStep(memory, &h);
    IDAGetErrWeights(memory, dense);
    const double force = std::max(yy.segment(2 * n, multipliers()).cwiseAbs().maxCoeff(),
                                  system.mass().maxCoeff() * system.length_scale());
    for (Eigen::Index j = 0; j < size(); ++j) {
      const double y = yy[j], rate = yp[j];
      double step = share * force;
      if (j < 2 * n || j >= 2 * n + multipliers())
        step = std::max(share * std::max(std::abs(y), std::abs(h * rate)), 1 / dense.map()[j]);
      step = (y + (h * rate < 0 ? -step : step)) - y;
      yy[j] += step, yp[j] += cj * step;
      residual(t, ConstMap(yy.data(), size()), ConstMap(yp.data(), size()), work);
      yy[j] = y, yp[j] = rate;
      Map(SUNDenseMatrix_Column(jacobian, j), size()) = (work - at) / step;
    }
    of_jacobians += size();
  }

  static int call_jacobian(realtype t, realtype cj, N_Vector yy, N_Vector yp, N_Vector at, SUNMatrix jacobian,
                           void* self, N_Vector work, N_Vector, N_Vector) {
    auto& s = *static_cast<Solver*>(self);
    return sundials::guarded(s.thrown, -1, [&] {
      const auto map = [&](N_Vector v) { return Map(N_VGetArrayPointer(v), s.size()); };
      s.differences(t, cj, map(yy), map(yp), {N_VGetArrayPointer(at), s.size()}, jacobian, map(work));
    });
  }
  /// lambda and q'' at the state that was set. The method's own lambda stands outside its error test and Newton's, and
  /// is no value to decide by: at rest, where steps are long, it errs by percents inside them.
  void take_solution(double t, const ConstMap& yy, const ConstMap& yp) {
    lambda.setZero();
    for (Eigen::Index i = 0; i < r; ++i) lambda[rows[static_cast<std::size_t>(i)]] = yy[2 * n + i];
    acceleration = yp.segment(n, n);
    if (!reactions_decide) return;
    solution.t = t, solution.q = q, solution.velocity = w, solution.states = states, solution.lambda = lambda;
    try {
      partition.accelerate_as_it_is(solution);
      lambda = solution.lambda, acceleration = solution.acceleration;
    } catch (const std::runtime_error&) {  // beside a singular pose nothing is known better
    }
    set_state(t, yy);
  }

  static int call_roots(realtype t, N_Vector yy, N_Vector yp, realtype* out, void* self) {
    auto& s = *static_cast<Solver*>(self);
    return sundials::guarded(s.thrown, -1, [&] {
      const ConstMap at(N_VGetArrayPointer(yy), s.size());
      s.set_state(t, at);
      s.take_solution(t, at, {N_VGetArrayPointer(yp), s.size()});
      s.system.set_multipliers(s.lambda);
      const SharedReactions reactions(s.system, s.rows.size(), s.lambda, events_read_reactions(s.system));
      s.switches.gaps({out, s.switches.count()}, &s.acceleration, &reactions.lambda());
      s.values.assign(out, out + s.switches.count());
    });
  }
};

Ida::Ida(System& system, const IdaOptions& options)
    : Adaptive(system),
      options_(options),
      rtol_(local_tolerance(options.rtol, 1e-12)),
      atol_(local_tolerance(options.atol, 1e-13)) {
  if (!(options.rtol > 0) || !(options.atol > 0))
    throw std::invalid_argument("ida: rtol and atol must be above 0; 1e-8 and 1e-10 are usual");
  drift_limit_ = options.formulation == IdaFormulation::index_1
                     ? options.atol + options.rtol * system.length_scale()
                     : std::numeric_limits<double>::infinity();  // holds its constraints to Newton's tolerance
}

Ida::~Ida() = default;

void Ida::build() {
  const long steps_before = steps(), evaluations_before = evaluations();
  solver_ = std::make_unique<Solver>(system_, partition_, switches_, options_.formulation == IdaFormulation::index_1,
                                     now_, rtol_, options_.rtol / rtol_);
  auto& s = *solver_;
  s.steps_before = steps_before, s.evaluations_before = evaluations_before;
  s.set_weights(atol_);
  s.memory = check_ida(IDACreate(s.context), "IDACreate");
  check_ida(IDASetErrHandlerFn(s.memory, sundials::silence, nullptr), "IDASetErrHandlerFn");
  check_ida(IDAInit(s.memory, Solver::call_residual, now_.t, s.y, s.dy), "IDAInit");
  check_ida(IDAWFtolerances(s.memory, Solver::call_weights), "IDAWFtolerances");
  check_ida(IDASetUserData(s.memory, &s), "IDASetUserData");
  check_ida(IDASetId(s.memory, s.id), "IDASetId");
  check_ida(IDASetSuppressAlg(s.memory, SUNTRUE), "IDASetSuppressAlg");
  s.matrix = check_ida(SUNDenseMatrix(s.size(), s.size(), s.context), "SUNDenseMatrix");
  s.linear = check_ida(SUNLinSol_Dense(s.y, s.matrix, s.context), "SUNLinSol_Dense");
  check_ida(IDASetLinearSolver(s.memory, s.linear, s.matrix), "IDASetLinearSolver");
  if (!system_.friction_rows().empty()) check_ida(IDASetJacFn(s.memory, Solver::call_jacobian), "IDASetJacFn");
  check_ida(IDASetMaxErrTestFails(s.memory, most_failures_of_a_step), "IDASetMaxErrTestFails");
  check_ida(IDASetMaxConvFails(s.memory, most_failures_of_a_step), "IDASetMaxConvFails");
  if (!watches_switches()) return;
  check_ida(IDARootInit(s.memory, static_cast<int>(switches_.count()), Solver::call_roots), "IDARootInit");
  check_ida(IDASetNoInactiveRootWarn(s.memory), "IDASetNoInactiveRootWarn");
}

void Ida::begin() {
  auto& s = *solver_;
  s.steps_before = steps(), s.evaluations_before = evaluations();
  s.of_jacobians = 0;
  Map y = s.y.map(), dy = s.dy.map();
  y.setZero(), dy.setZero();
  y.head(s.n) = now_.q, y.segment(s.n, s.n) = now_.velocity;
  dy.head(s.n) = now_.velocity, dy.segment(s.n, s.n) = now_.acceleration;
  for (Eigen::Index i = 0; i < s.r; ++i) y[2 * s.n + i] = now_.lambda[s.rows[static_cast<std::size_t>(i)]];
  y.tail(s.e) = flows_.of_elements, dy.tail(s.e) = now_.rates;
  check_ida(IDAReInit(s.memory, now_.t, s.y, s.dy), "IDAReInit");
  s.fresh = true;
}

long Ida::steps() const {
  if (!solver_ || !solver_->memory) return 0;
  long count = 0;
  check_ida(IDAGetNumSteps(solver_->memory, &count), "IDAGetNumSteps");
  return solver_->steps_before + count;
}

long Ida::evaluations() const {
  if (!solver_ || !solver_->memory) return 0;
  long count = 0, of_jacobians = 0;
  check_ida(IDAGetNumResEvals(solver_->memory, &count), "IDAGetNumResEvals");
  check_ida(IDAGetNumLinResEvals(solver_->memory, &of_jacobians), "IDAGetNumLinResEvals");
  return solver_->evaluations_before + count + of_jacobians + solver_->of_jacobians;
}

Adaptive::Reached Ida::take_step(double stop, const Inputs::Inside&) {
  auto& s = *solver_;
  if (s.fresh) {
    // IDA's own first step follows from y'/weight and can fall to 1e-13 s, where rounding e/h of an index-2 system
    // is all that Newton sees. The first step of order 1 errs by q'' h^2/2: that is what it may be, of the pose as a
    // whole, whose largest coordinate makes the rounding.
    const double allowed = atol_ + rtol_ * now_.q.cwiseAbs().maxCoeff();
    const double first = std::sqrt(allowed / (1 + now_.acceleration.cwiseAbs().maxCoeff()));
    check_ida(IDASetInitStep(s.memory, std::min(first, std::max(stop - now_.t, 1e-12))), "IDASetInitStep");
    s.fresh = false;
  }
  if (std::isfinite(stop)) check_ida(IDASetStopTime(s.memory, stop), "IDASetStopTime");
  double t = now_.t;
  s.thrown = nullptr;
  const int code = IDASolve(s.memory, t + 1, &t, s.y, s.dy, IDA_ONE_STEP);  // single steps, whatever the end is
  if (s.thrown) failure_ = s.thrown;
  if (code < 0 && s.thrown) std::rethrow_exception(s.thrown);
  sundials::check_step(code, t, IDAGetReturnFlagName);
  return {t, code == IDA_ROOT_RETURN};
}

double Ida::planned_step() const {
  const auto& s = *solver_;
  if (s.fresh) return 1e-3;  // above any first step
  double next = 0;
  check_ida(IDAGetCurrentStep(s.memory, &next), "IDAGetCurrentStep");
  return next;
}

void Ida::read(double t) {
  auto& s = *solver_;
  check_ida(IDAGetDky(s.memory, t, 0, s.dense), "IDAGetDky");
  const Map y = s.dense.map();
  now_.q = y.head(s.n), now_.velocity = y.segment(s.n, s.n);
  flows_.of_elements = y.tail(s.e);
  now_.states = y.tail(now_.states.size());
  if (!s.index_1 || s.r == 0) return;
  system_.set_position(t, now_.q);
  system_.constraints(s.c);
  drift_ = row_scale(system_).cwiseProduct(s.c.phi).cwiseAbs().maxCoeff();
}

void Ida::dense(double t, StepSegment& out) {
  auto& s = *solver_;
  double last = 0;
  check_ida(IDAGetCurrentTime(s.memory, &last), "IDAGetCurrentTime");
  check_ida(IDAGetLastStep(s.memory, &out.polynomial.scale), "IDAGetLastStep");
  check_ida(IDAGetDky(s.memory, t, 0, s.dense), "IDAGetDky");
  const Map y = s.dense.map();
  out.end.q = y.head(s.n), out.end.velocity = y.segment(s.n, s.n);
  out.end.states = y.tail(out.end.states.size());
  out.polynomial.centre = last;
  out.polynomial.set.resize(static_cast<std::size_t>(s.n));
  std::iota(out.polynomial.set.begin(), out.polynomial.set.end(), 0);
  sundials::take_powers(s.dense, s.size(), out.polynomial,
                        [&](int k, N_Vector into) { return IDAGetDky(s.memory, last, k, into); });
  const Eigen::MatrixXd all = std::exchange(out.polynomial.powers, {});
  out.polynomial.powers.resize(2 * s.n + s.e, all.cols());
  out.polynomial.powers << all.topRows(2 * s.n), all.bottomRows(s.e);
}

const std::vector<double>& Ida::end_values() const { return solver_->values; }

void Ida::root_directions(std::vector<int>& out) {
  check_ida(IDAGetRootInfo(solver_->memory, out.data()), "IDAGetRootInfo");
}

}  // namespace subsoil::mbd
