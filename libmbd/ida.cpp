#include "libmbd/ida.hpp"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <stdexcept>

namespace subsoil::mbd {

namespace {

/// The one place where return codes of SUNDIALS are looked at.
void check(int code, const char* call) {
  if (code >= 0) return;
  char* name = IDAGetReturnFlagName(code);
  const std::string text = std::string("SUNDIALS ") + call + " failed: " + (name ? name : "unknown code");
  std::free(name);
  throw std::runtime_error(text);
}
template <class Pointer>
Pointer* check(Pointer* pointer, const char* call) {
  if (!pointer) throw std::runtime_error(std::string("SUNDIALS ") + call + " failed: no memory");
  return pointer;
}

using Map = Eigen::Map<Eigen::VectorXd>;

}  // namespace

struct Ida::Solver {
  System& system;
  std::vector<int> rows;
  Eigen::Index n, r, e;
  SUNContext context = nullptr;
  void* memory = nullptr;
  N_Vector y = nullptr, dy = nullptr, tolerance = nullptr, id = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  Constraints c;
  Eigen::VectorXd q, w, load, lambda, mu, correction;
  std::exception_ptr thrown;
  long steps_before = 0;

  Solver(System& s, const std::vector<int>& used_rows, Eigen::Index rates)
      : system(s),
        rows(used_rows),
        n(s.coordinates()),
        r(static_cast<Eigen::Index>(used_rows.size())),
        e(rates),
        q(n),
        w(n),
        load(n),
        lambda(s.equations()),
        mu(s.equations()),
        correction(n) {}
  ~Solver() {
    if (memory) IDAFree(&memory);
    if (linear) SUNLinSolFree(linear);
    if (matrix) SUNMatDestroy(matrix);
    for (N_Vector v : {y, dy, tolerance, id})
      if (v) N_VDestroy(v);
    if (context) SUNContext_Free(&context);
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  Eigen::Index size() const { return 2 * n + 2 * r + e; }
  static double* data(N_Vector v) { return N_VGetArrayPointer(v); }

  void set_weights(const IdaOptions& o) const {
    Map weight(data(tolerance), size()), kind(data(id), size());
    weight.head(2 * n).setConstant(o.atol);
    // lambda and mu stand outside the error test, and outside Newton's too: rounding e of q and w returns in them as
    // e M/h and e/h, without bound as a step is cut short by a stop time. q, w and e in the same iteration decide. The
    // residual is linear in both, so the large increments that IDA's differences take from here lose nothing.
    weight.segment(2 * n, 2 * r).setConstant(1e12);
    weight.tail(e).setConstant(1e2 * o.atol);
    kind.setOnes();
    kind.segment(2 * n, 2 * r).setZero();
  }

  int residual(double t, const double* yy, const double* yp, double* out) {
    const Eigen::Map<const Eigen::VectorXd> y_all(yy, size()), dy_all(yp, size());
    Map res(out, size());
    q = y_all.head(n), w = y_all.segment(n, n);
    system.set_state(t, q, w);
    system.constraints(c);
    lambda.setZero(), mu.setZero();
    for (Eigen::Index i = 0; i < r; ++i) {
      const int row = rows[static_cast<std::size_t>(i)];
      lambda[row] = y_all[2 * n + i], mu[row] = y_all[2 * n + r + i];
      res[2 * n + i] = c.phi[row];
      res[2 * n + r + i] = c.jacobian.row(row).dot(w) + c.phi_t[row];
    }
    system.set_multipliers(lambda);  // of which friction is made
    system.loads(load);
    correction.noalias() = c.jacobian.transpose() * mu;
    res.head(n) = dy_all.head(n) - w + correction;
    correction.noalias() = c.jacobian.transpose() * lambda;
    res.segment(n, n) = dy_all.segment(n, n) + (correction - load).cwiseQuotient(system.mass());
    const auto forces = static_cast<Eigen::Index>(system.model().forces.size());
    for (Eigen::Index i = 0; i < e; ++i) {
      double power = 0;
      if (i < forces) {
        power = system.powers()[static_cast<std::size_t>(i)].lost;
      } else if (i < 2 * forces) {
        power = system.powers()[static_cast<std::size_t>(i - forces)].work;
      } else {
        const int row = system.row_of_driver(static_cast<std::size_t>(i - 2 * forces));
        power = lambda[row] * c.phi_t[row];
      }
      res[2 * n + 2 * r + i] = dy_all[2 * n + 2 * r + i] - power;
    }
    return 0;
  }

  static int call_residual(realtype t, N_Vector yy, N_Vector yp, N_Vector out, void* self) {
    auto& solver = *static_cast<Solver*>(self);
    try {  // no exception may cross C
      return solver.residual(t, data(yy), data(yp), data(out));
    } catch (...) {
      solver.thrown = std::current_exception();
      return -1;
    }
  }
};

Ida::Ida(System& system, const IdaOptions& options) : Integrator(system), options_(options) {
  if (!(options.rtol > 0) || !(options.atol > 0))
    throw std::invalid_argument("ida: rtol and atol must be above 0; 1e-8 and 1e-10 are usual");
}

Ida::~Ida() = default;

void Ida::on_start() {
  solver_ = std::make_unique<Solver>(system_, partition_.used_rows(), now_.rates.size());
  auto& s = *solver_;
  check(SUNContext_Create(nullptr, &s.context), "SUNContext_Create");
  for (N_Vector* v : {&s.y, &s.dy, &s.tolerance, &s.id})
    *v = check(N_VNew_Serial(s.size(), s.context), "N_VNew_Serial");
  s.set_weights(options_);
  s.memory = check(IDACreate(s.context), "IDACreate");
  Map(Solver::data(s.y), s.size()).setZero();
  Map(Solver::data(s.dy), s.size()).setZero();
  check(IDAInit(s.memory, Solver::call_residual, now_.t, s.y, s.dy), "IDAInit");
  check(IDASVtolerances(s.memory, options_.rtol, s.tolerance), "IDASVtolerances");
  check(IDASetUserData(s.memory, &s), "IDASetUserData");
  check(IDASetId(s.memory, s.id), "IDASetId");
  check(IDASetSuppressAlg(s.memory, SUNTRUE), "IDASetSuppressAlg");
  check(IDASetMaxNumSteps(s.memory, 5'000'000), "IDASetMaxNumSteps");
  s.matrix = check(SUNDenseMatrix(s.size(), s.size(), s.context), "SUNDenseMatrix");
  s.linear = check(SUNLinSol_Dense(s.y, s.matrix, s.context), "SUNLinSol_Dense");
  check(IDASetLinearSolver(s.memory, s.linear, s.matrix), "IDASetLinearSolver");
  reinitialise();
}

void Ida::reinitialise() {
  auto& s = *solver_;
  s.steps_before = steps();
  wrench_changes_ = system_.wrench_changes();
  partition_.evaluate(now_);
  Map y(Solver::data(s.y), s.size()), dy(Solver::data(s.dy), s.size());
  y.setZero(), dy.setZero();
  y.head(s.n) = now_.q, y.segment(s.n, s.n) = now_.velocity;
  dy.head(s.n) = now_.velocity, dy.segment(s.n, s.n) = now_.acceleration;
  for (Eigen::Index i = 0; i < s.r; ++i) y[2 * s.n + i] = now_.lambda[s.rows[static_cast<std::size_t>(i)]];
  y.tail(s.e) = flows_.of_elements, dy.tail(s.e) = now_.rates;
  check(IDAReInit(s.memory, now_.t, s.y, s.dy), "IDAReInit");
  fresh_ = true;
}

void Ida::on_restore(const double*&, const double*) { on_start(); }

long Ida::steps() const {
  long count = 0;
  if (solver_ && solver_->memory) check(IDAGetNumSteps(solver_->memory, &count), "IDAGetNumSteps");
  return count + (solver_ ? solver_->steps_before : 0);
}

void Ida::on_advance(double h) {
  auto& s = *solver_;
  if (s.rows != partition_.used_rows()) {  // redundant constraints, and other equations carry the multipliers now
    const long before = steps();
    on_start();
    solver_->steps_before = before;
    return on_advance(h);
  }
  if (wrench_changes_ != system_.wrench_changes()) reinitialise();
  const double end = now_.t + h;
  if (fresh_) {
    // IDA's own first step follows from y'/weight and can fall to 1e-13 s, where rounding e/h of an index-2 system
    // is all that Newton sees. The first step of order 1 errs by q'' h^2/2: that is what it may be.
    const double first = std::sqrt(options_.atol / (1 + now_.acceleration.cwiseAbs().maxCoeff()));
    check(IDASetInitStep(s.memory, std::min(h, first)), "IDASetInitStep");
    fresh_ = false;
  }
  check(IDASetStopTime(s.memory, end), "IDASetStopTime");
  double reached = now_.t;
  s.thrown = nullptr;
  const int code = IDASolve(s.memory, end, &reached, s.y, s.dy, IDA_NORMAL);
  if (code < 0 && s.thrown) std::rethrow_exception(s.thrown);
  check(code, ("IDASolve at t = " + std::to_string(reached) + " s").c_str());
  const Map y(Solver::data(s.y), s.size());
  now_.t = end;
  now_.q = y.head(s.n), now_.velocity = y.segment(s.n, s.n);
  flows_.of_elements = y.tail(s.e);
  partition_.evaluate(now_);
  if (partition_.choose_again_if_needed(now_)) partition_.evaluate(now_);
}

}  // namespace subsoil::mbd
