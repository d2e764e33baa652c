#pragma once

#include <Eigen/Core>
#include <functional>

namespace subsoil::mbd {

/// A vector function of one number.
using Curve1 = std::function<Eigen::VectorXd(double)>;

/// Derivative of a function at 0, and an estimate of the error of each component.
struct Slope {
  Eigen::VectorXd value, error;
};

/// Derivative of f at 0 by differences of both sides at the steps h_k = far/4^k, extrapolated:
///   D_k = (f(h_k) - f(-h_k))/(2 h_k),   R_k,c = R_k,c-1 + (R_k,c-1 - R_k-1,c-1)/(16^c - 1),  R_k,0 = D_k
/// A law that changes at some distance of 0 (a contact ends, a stop begins) spoils the differences of longer steps and
/// leaves those of shorter ones. Longer ones are recognised by two signs: the R differ, and the bend
/// (f(h) + f(-h) - 2 f(0))/h does not fall with h. Each component takes the R whose estimated error is the smallest.
/// Where f has a corner at 0 itself the value is the mean of both sides, and the error is half their difference.
/// An error is at least what the last two corners and the rounding of f and of its argument leave of it, so that two
/// differences that agree by chance do not count, nor those of a step that the argument does not feel.
/// Components are taken to be of comparable size: one is settled where its error is 1e-10 of it, or where rounding
/// grows in it and it is below 1e-6 of the maximum.
/// Source: Ridders 1982, Adv. Eng. Software 4, 75; the bend is ours.
/// @param resolution rounding of the argument: 2^-52 of the size of what is shifted; no step is below 1e4 of it
Slope slope_at_zero(const Curve1& f, double far, double resolution);

/// The same to a few digits for Newton's method: one difference of both sides at `step`, shortened by tens while the
/// derivatives of the two sides differ by more than a tenth. `f_0` is f(0).
Eigen::VectorXd rough_slope(const Curve1& f, const Eigen::VectorXd& f_0, double step);

}  // namespace subsoil::mbd
