#pragma once
#include <cmath>

#include "libdem/laws/contact.hpp"

/// One contact led along a prescribed overlap: force, energies and memory at every step, without an engine.
namespace subsoil::dem::test {

class ContactPath {
 public:
  explicit ContactPath(const Law& law, double r_eff = 5e-3, double m_eff = 1e-3)
      : law_(law), r_eff_(r_eff), root_m_(std::sqrt(m_eff)) {
    last_ = evaluate(0, 0, 0);
    stored_at_first_ = last_.stored;  // adhesion that begins at the touch holds energy there
  }

  /// To an overlap in equal steps of `dt`; what the rate damps belongs to `damped`.
  void to(double overlap, int steps, double dt = 1) {
    const double from = at_, step = (overlap - from) / steps;
    for (int k = 1; k <= steps; ++k) {
      at_ = from + k * step;
      const NormalForce<double> now = evaluate(at_, step / dt, dt);
      work += 0.5 * (last_.force + now.force) * step;
      damped += 0.5 * (last_.damping + now.damping) * step;
      lost += now.lost;
      least_loss = std::fmin(least_loss, now.lost);
      last_ = now;
    }
  }

  double overlap() const { return at_; }
  double force() const { return last_.force; }
  double stored() const { return last_.stored; }
  const NormalForce<double>& now() const { return last_; }
  const double* memory() const { return memory_; }
  /// Work that is neither stored nor lost.
  double gap() const { return work - (stored() - stored_at_first_) - lost - damped; }

  double work = 0, damped = 0, lost = 0, least_loss = 0;

 private:
  NormalForce<double> evaluate(double overlap, double rate, double dt) {
    return law_->normal({overlap, rate, root_m_, r_eff_, dt}, memory_);
  }

  Law law_;
  double r_eff_, root_m_, at_ = 0, stored_at_first_ = 0;
  double memory_[kOwnMemory] = {};
  NormalForce<double> last_;
};

}  // namespace subsoil::dem::test
