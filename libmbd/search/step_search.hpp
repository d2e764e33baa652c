#pragma once

#include <span>
#include <vector>

#include "libmbd/integrators/evaluation.hpp"
#include "libmbd/search/requests.hpp"

namespace subsoil::mbd {

/// A part of a step in which no request is met but at its ends. Rows may be completed by who receives it.
struct StepPart {
  double from, until;
  std::vector<double>&begin, &middle, &end;
  /// The row at a time in the part.
  const std::function<void(double t, std::vector<double>& row)>& sample;
};

/// Signals over the motion of a machine, what is requested of them, and who receives what is found.
class StepSignals {
 public:
  virtual ~StepSignals() = default;
  /// All signals at an instant; those that are not of the instant alone stay as they are in the row.
  virtual void sample(double t, const Instant& at, std::vector<double>& row) = 0;
  /// What each of them may change by from rounding alone.
  virtual void rounding(const Instant& at, std::span<const double> row, std::vector<double>& out) = 0;
  /// Adds what is requested of the part that ends at `until`.
  virtual void request(double until, std::vector<Request>& out) = 0;
  /// The instant behind a jump. True ends the search.
  virtual bool take_jump(double t, std::vector<double>& row) = 0;
  /// The next part in time. True ends the search.
  virtual bool take_part(const StepPart& part) = 0;
};

/// Takes signals through the dense output of steps, in parts that end where a request is met: at roots and extrema, at
/// jumps, and so often that the rows of both ends and the middle give the integrals requested.
class StepSearch {
 public:
  StepSearch(StepSignals& signals, Evaluation& evaluation) : signals_(signals), evaluation_(evaluation) {}

  /// From `from`, whose row is `row`, to `until`, whose row it becomes; each segment in `parts` or more. True
  /// where the search was ended; the row is then of that time.
  bool search(const DenseOutput& step, double from, double until, int parts, std::vector<double>& row);

 private:
  struct Splits {  ///< that a part may still take
    int at_requests, in_halves;
  };
  bool search_part(double from, double until, Splits left);
  void sample(double t, std::vector<double>& row);

  StepSignals& signals_;
  Evaluation& evaluation_;
  const DenseOutput* step_ = nullptr;
  std::size_t segment_ = 0;
  std::vector<double>* row_ = nullptr;
  std::vector<double> begin_, middle_, between_, rounding_;
  std::vector<Request> requests_;
};

}  // namespace subsoil::mbd
