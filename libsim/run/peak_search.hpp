#pragma once
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace subsoil::sim {

/// A value of a column that is worth looking for between instants at which a motion is known.
struct Sought {
  enum class Kind {
    dip,       ///< any time at which the column is beyond the value, where it is not so at both ends
    passage,   ///< such a time, or else the time at which it passes the value
    extreme,   ///< the time of the peak itself
    integral,  ///< nothing of it: whether both ends and the middle give its integral
  };
  std::size_t column;
  double sign;    ///< +1: values below `beyond` are, -1: above
  double beyond;  ///< the value to be passed, the extreme or the integral so far
  Kind kind;
};

/// A short part of a motion, known at both ends and halfway; `at` gives the columns at a time in it.
struct PartOfMotion {
  double from, until;
  std::span<const double> begin, middle, end;
  std::span<const double> rounding;  ///< what each column may change by from rounding: not searched
  std::function<std::span<const double>(double)> at;
};

/// The first time strictly inside a part at which a column has a requested peak: a minimum or maximum that passes
/// its value and comes back, or a new extreme. Where the middle lies beyond both ends, the peak lies between them. Else
/// there may be one in the half that leads up to the end beyond: if continuing as the other half could reach the
/// value requested, the slope at that end decides: if it points inward, the peak lies there. Where the column
/// follows the parabola through the three instants, to 2 % of its bend, the peak is the vertex; else it is located by
/// golden section to 1e-6 of the part.
std::optional<double> find_peak(std::span<const Sought> sought, const PartOfMotion& part);

/// Whether a column whose integral is requested is to be halved in a part: where Simpson's rule over its halves differs
/// from that over the whole by more than this share of the sizes in it and by more than 1e-6 of the integral so far. A
/// column that changes by less between the three instants is not looked at.
bool needs_halving(std::span<const Sought> sought, const PartOfMotion& part, double share_of_size);

}  // namespace subsoil::sim
