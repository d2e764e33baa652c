#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

namespace subsoil::mbd {

/// What is requested of a signal, a number of a row, between two instants at which the row is known.
struct Request {
  enum class Kind {
    excursion,  ///< any time at which the signal is beyond the value, where it is not so at both ends
    root,       ///< such a time, or else the time at which it passes the value
    extremum,   ///< the time of the extremum itself
    integral,   ///< no time: whether both ends and the middle give its integral
  };
  std::size_t signal;
  double sign;   ///< +1: values below `value` are beyond it, and minima are requested; -1: above, and maxima
  double value;  ///< to be passed; the extremum or the integral so far
  Kind kind;
};

/// A short part of a motion, known at both ends and halfway; `at` gives the row at a time in it.
struct MotionPart {
  double from, until;
  std::span<const double> begin, middle, end;
  std::span<const double> rounding;  ///< what each signal may change by from rounding: not searched
  std::function<std::span<const double>(double)> at;
};

/// The first time strictly inside a part at which a signal meets a request: a minimum or maximum that passes its value
/// and comes back, a root, or a new extremum. Where the middle lies beyond both ends, the extremum lies between them.
/// Else there may be one in the half that leads up to the end beyond: if continuing as the other half could reach the
/// value requested, the slope at that end decides: if it points inward, the extremum lies there. Where the signal
/// follows the parabola through the three instants, to 2 % of its bend, the extremum is the vertex; else it is located
/// by golden section to 1e-6 of the part.
std::optional<double> find_first(std::span<const Request> requests, const MotionPart& part);

/// Whether a signal whose integral is requested is to be halved in a part: where Simpson's rule over its halves differs
/// from that over the whole by more than this share of the sizes in it and by more than 1e-6 of the integral so far. A
/// signal that changes by less between the three instants is not looked at.
bool needs_halving(std::span<const Request> requests, const MotionPart& part, double share_of_size);

}  // namespace subsoil::mbd
