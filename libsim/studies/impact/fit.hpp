#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "libsim/studies/impact/study.hpp"

/// Parameters of impact models from measurements, by least squares.
namespace subsoil::sim {

/// Measured impacts: a speed and any of the rest (NaN: not measured), SI.
struct Measured {
  double speed, restitution, peak_force, indentation, duration;
};

/// Reads `speed [m/s], restitution [1], peak force [N], indentation [m], duration [s]`: speed and at least one other,
/// any order, any unit of the dimension; an empty field is not measured. Throws ScenarioError with file:line.
std::vector<Measured> read_measured(const std::filesystem::path& file);

/// What `fit to` requires of the law at the study's speeds.
std::vector<Measured> measured_of(const LoadedStudy& loaded);

struct FittedParameter {
  std::string name, unit;
  double value = 0;
  double low = 0, high = 0;  ///< ends of the confidence interval; NaN without degrees of freedom
};
struct ImpactFit {
  ImpactModel model;  ///< with the values found
  std::vector<FittedParameter> parameters;
  double confidence = 0.95;
  double spread = 0;  ///< standard deviation of the relative residuals
  double worst = 0;   ///< maximum relative residual
  long points = 0;    ///< numbers fitted
  int freedoms = 0;   ///< points less parameters
};

/// Levenberg-Marquardt on relative residuals, each weighing the same; positive parameters by their logarithm. The
/// covariance is s^2 (J'J)^-1 at the solution, intervals take Student's t, of positive parameters for the logarithm.
/// `free`: names of the parameters that may move; empty: those that this kind of data can tell.
/// Throws ScenarioError when the data cannot tell the parameters apart, naming them.
ImpactFit fit_impact(const LoadedStudy& loaded, const std::vector<Measured>& data,
                     const std::vector<std::string>& free);

std::string fit_text(const ImpactFit& fit);

}  // namespace subsoil::sim
