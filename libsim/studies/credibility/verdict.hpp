#pragma once
#include <string>
#include <vector>

#include "libsim/base/json.hpp"
#include "libsim/studies/credibility/axes.hpp"

namespace subsoil::sim {

/// What a change did to a number.
struct Verdict {
  enum class Kind { converged, not_converged, not_told, failed, scatter };
  std::size_t axis = 0, number = 0;
  double base = 0, changed = 0;
  double change = 0;       ///< (changed - base) / |base|
  double uncertainty = 0;  ///< of the change, share of |base|
  Kind kind = Kind::failed;
  std::string cause;  ///< of a failed run
};

struct Credibility {
  std::vector<Verdict> verdicts;        ///< number by number, axis by axis, packings left out
  std::vector<double> packing_scatter;  ///< standard deviation over the packings, per number; NaN of fewer than two
  std::vector<double> tolerance;        ///< share, per number
  std::vector<std::string> warnings;    ///< of the runs, each once with the runs that gave it
};

/// Change delta = (changed - base)/|base|, its uncertainty U = sqrt(2) t s/|base| with the standard deviation s over
/// n packings (Student's t of 95 % with n - 1 degrees of freedom, both runs scatter alike); fewer than two packings: U
/// = sqrt(h_b^2 + h_c^2)/|base| with the half widths of the 95 % intervals of both means. Converged where |delta| + U
/// <= tolerance, not converged where |delta| - U > tolerance, else inconclusive.
Credibility judge(const Axes& axes, const Study& study, const std::vector<PointResult>& results, double tolerance);

/// "draft 1402, +- 52 packing, +0.6 % step, +44 % stiffness: not converged in stiffness", a line per number, and the
/// grid convergence index 3 |delta| of the refinements (Roache 1994: two grids, ratio 2, first order, safety factor 3).
std::vector<std::string> credibility_lines(const Axes& axes, const Study& study, const Credibility& c);
/// The table for page, terminal and CSV.
Json credibility_json(const Axes& axes, const Study& study, const Credibility& c);

}  // namespace subsoil::sim
