#include "libmbd/integrator.hpp"

#include <algorithm>
#include <stdexcept>

#include "libmbd/adams_moulton.hpp"
#include "libmbd/ida.hpp"

namespace subsoil::mbd {

Integrator::Integrator(System& system) : system_(system), partition_(system) {
  const auto n = system.coordinates();
  now_.q.setZero(n), now_.velocity.setZero(n), now_.acceleration.setZero(n);
  now_.lambda.setZero(system.equations());
  const auto& model = system.model();
  now_.rates.setZero(static_cast<Eigen::Index>(2 * model.forces.size() + model.drivers.size()));
  flows_.of_elements = now_.rates;
  q_before_ = now_.q;
}

void Integrator::start(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity) {
  now_.t = t, now_.q = q, now_.velocity = velocity;
  flows_.of_elements.setZero();
  flows_.external_work = 0;
  system_.set_state(t, q, velocity);
  system_.restart_traces();
  partition_.choose(now_);
  partition_.evaluate(now_);
  on_start();
}

void Integrator::advance(double h) {
  if (!(h > 0)) throw std::invalid_argument("machine step = " + std::to_string(h) + " s: must be above 0");
  q_before_ = now_.q;
  on_advance(h);
  system_.set_state(now_.t, now_.q, now_.velocity);
  system_.commit();
  for (int i = 1; i < system_.bodies(); ++i)
    for (int k = 0; k < 3; ++k) {
      const auto c = 3 * (i - 1) + k;
      flows_.external_work += system_.external_wrench(i)[static_cast<std::size_t>(k)] * (now_.q[c] - q_before_[c]);
    }
}

double Integrator::take(const double*& from, const double* end) {
  if (from == end) throw std::runtime_error("machine restart data end too early; they belong to another machine");
  return *from++;
}

void Integrator::take(const double*& from, const double* end, Eigen::VectorXd& v) {
  if (end - from < v.size())
    throw std::runtime_error("machine restart data end too early; they belong to another machine");
  std::copy(from, from + v.size(), v.data());
  from += v.size();
}

void Integrator::save(std::vector<double>& out) const {
  out.push_back(now_.t);
  put(out, now_.q);
  put(out, now_.velocity);
  put(out, flows_.of_elements);
  out.push_back(flows_.external_work);
  system_.save(out);
  on_save(out);
}

void Integrator::restore(const double*& from, const double* end) {
  now_.t = take(from, end);
  take(from, end, now_.q);
  take(from, end, now_.velocity);
  take(from, end, flows_.of_elements);
  flows_.external_work = take(from, end);
  system_.restore(from, end);
  partition_.choose(now_);
  partition_.evaluate(now_);
  on_restore(from, end);
}

std::unique_ptr<Integrator> make_integrator(IntegratorKind kind, System& system, const AdamsMoultonOptions& adams,
                                            const IdaOptions& ida) {
  if (kind == IntegratorKind::ida) return std::make_unique<Ida>(system, ida);
  return std::make_unique<AdamsMoulton>(system, adams);
}

}  // namespace subsoil::mbd
