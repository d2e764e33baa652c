#pragma once

#include "libmbd/assembly/partition.hpp"

namespace subsoil::mbd {

/// A state between two others, a.t <= t <= b.t, by Hermite interpolation: each coordinate on the quintic through q, q',
/// q'' of both ends, whose error is h^6 q^(6)/46080 with h = b.t - a.t, of a step of Adams-Moulton of order 5; lambda
/// and rates on a line. It lies off Phi = 0 by that error.
/// Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.6.
void interpolate(const MotionState& a, const MotionState& b, double t, MotionState& out);

/// Integrals of rates between the same two states, on the cubic through their values and rates of both ends.
void interpolate_flows(const MotionState& a, const MotionState& b, const Eigen::VectorXd& flows_a,
                       const Eigen::VectorXd& flows_b, double t, Eigen::VectorXd& out);

/// Dense output of a step by the method's own polynomial, of the coordinates that the method integrates.
struct Polynomial {
  std::vector<int> set;    ///< coordinates
  Eigen::MatrixXd powers;  ///< rows: q of the set, q' of the set, flows and states; column k: of ((t - centre)/scale)^k
  double centre = 0, scale = 1;  ///< s
  bool empty() const { return powers.cols() == 0; }
  /// Everything else by Taylor's series from `near`, a guess.
  void read(double t, const MotionState& near, MotionState& out, Eigen::VectorXd& flows) const;
};

}  // namespace subsoil::mbd
