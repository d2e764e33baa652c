#include "libmbd/integrators/between.hpp"

#include <algorithm>
#include <cmath>

namespace subsoil::mbd {

void interpolate(const MotionState& a, const MotionState& b, double t, MotionState& out) {
  const double h = b.t - a.t, s = (t - a.t) / h;
  const double s2 = s * s, s3 = s2 * s;
  // Of what b lies off the parabola of a: p(1), p'(1), p''(1) as powers of s from 3 on.
  for (Eigen::Index i = 0; i < a.q.size(); ++i) {
    const double v = h * a.velocity[i], w = h * h * a.acceleration[i];
    const double dp = h * b.velocity[i] - v - w, ddp = h * h * b.acceleration[i] - w;
    // Positions that say no more than their rounding, over a short step, would make velocities of it.
    const double way = b.q[i] - a.q[i] - v - w / 2, of_velocities = dp / 2 - ddp / 12;
    const double p = std::abs(way - of_velocities) > 1e-13 * std::max(1.0, std::abs(b.q[i])) ? way : of_velocities;
    const double c3 = 10 * p - 4 * dp + ddp / 2, c4 = -15 * p + 7 * dp - ddp, c5 = 6 * p - 3 * dp + ddp / 2;
    out.q[i] = a.q[i] + s * v + s2 * w / 2 + s3 * (c3 + s * (c4 + s * c5));
    out.velocity[i] = (v + s * w + s2 * (3 * c3 + s * (4 * c4 + s * 5 * c5))) / h;
    out.acceleration[i] = (w + s * (6 * c3 + s * (12 * c4 + s * 20 * c5))) / (h * h);
  }
  out.t = t;
  out.lambda = (1 - s) * a.lambda + s * b.lambda;
  out.rates = (1 - s) * a.rates + s * b.rates;
  const auto states = a.states.size();
  out.states = a.states + s * s * (3 - 2 * s) * (b.states - a.states) +
               h * s * (1 - s) * ((1 - s) * a.rates.tail(states) - s * b.rates.tail(states));
}

void interpolate_flows(const MotionState& a, const MotionState& b, const Eigen::VectorXd& flows_a,
                       const Eigen::VectorXd& flows_b, double t, Eigen::VectorXd& out) {
  const double h = b.t - a.t, s = (t - a.t) / h;
  out = flows_a + s * s * (3 - 2 * s) * (flows_b - flows_a) + h * s * (1 - s) * ((1 - s) * a.rates - s * b.rates);
}

void Polynomial::read(double t, const MotionState& near, MotionState& out, Eigen::VectorXd& flows) const {
  const double s = (t - centre) / scale, dt = t - near.t;
  Eigen::VectorXd value = powers.rightCols<1>(), rate = Eigen::VectorXd::Zero(value.size());
  for (Eigen::Index k = powers.cols() - 1; k-- > 0;) {
    rate = rate * s + value;
    value = value * s + powers.col(k);
  }
  out.t = t;
  out.q = near.q + dt * (near.velocity + 0.5 * dt * near.acceleration);
  out.velocity = near.velocity + dt * near.acceleration;
  out.acceleration = near.acceleration;
  const auto f = static_cast<Eigen::Index>(set.size());
  for (Eigen::Index i = 0; i < f; ++i) {
    const int coordinate = set[static_cast<std::size_t>(i)];
    out.q[coordinate] = value[i], out.velocity[coordinate] = value[f + i];
    out.acceleration[coordinate] = rate[f + i] / scale;
  }
  flows = value.tail(value.size() - 2 * f);
  out.rates = rate.tail(flows.size()) / scale;
  out.states = flows.tail(out.states.size());
}

}  // namespace subsoil::mbd
