#pragma once

#include <vector>

#include "libmbd/assembly/partition.hpp"
#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// The profiles of a machine: the laws of its forces over a relative measure x, such as the Stribeck curve of a joint's
/// friction over its sliding speed, or a damper curve. An error test sees a law only at the ends of a step, and where
/// both ends lie beside a peak, the motion between them is a polynomial and passes. So x is looked at where the motion
/// will be after the planned step and half of it, if it continued with its present accelerations; the step may only
/// be as long as the quartic through five points of the law over that range of x agrees with it at its nodes and
/// between them: to 2e-3 of the bend in the range, or 1e-8 of its maximum value. In a range without nodes the law is
/// smooth.
class Profiles {
 public:
  explicit Profiles(System& system);
  bool any() const { return !list_.empty(); }
  /// Where a step from the state m that wants to be `planned` long (s) has to end at the latest; infinity: anywhere.
  double stop(const MotionState& m, double planned);

 private:
  struct Profile {
    std::size_t force, index;
    std::vector<double> looked_at;  // nodes and what lies midway
    std::vector<double> values;     // of the law there
    double largest = 0;
  };
  void arguments(const MotionState& m, double after, std::vector<double>& out);
  bool resolves(const Profile& p, double from, double to) const;
  double value(const Profile& p, double x) const;

  System& system_;
  std::vector<Profile> list_;
  std::vector<double> begin_, middle_, end_, work_;
  Eigen::VectorXd q_, velocity_;
};

}  // namespace subsoil::mbd
