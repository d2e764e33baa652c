#include "libmbd/search/requests.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libmbd/integrators/hidden_contacts.hpp"

namespace subsoil::mbd {

namespace {

constexpr double beside_end = 1e-3;     // of a part, to see the slope at its end
constexpr double share_of_part = 1e-6;  // of a part, to which a peak is located
constexpr double share_of_bend = 0.02;  // what a parabola may be off by
constexpr double share_so_far = 1e-6;   // what a part may add to the error of an integral

/// One signal in a part, turned so that minima are requested.
struct SignalSearch {
  const Request& request;
  const MotionPart& part;
  double beyond = request.sign * request.value;
  double begin = of(part.begin), middle = of(part.middle), end = of(part.end);

  double of(std::span<const double> row) const { return request.sign * row[request.signal]; }
  bool extreme = request.kind == Request::Kind::extremum;
  double at(double t) const { return of(part.at(t)); }
  double time(double share) const { return part.from + share * (part.until - part.from); }

  /// Where a minimum that is requested may lie, or nothing.
  std::optional<std::pair<double, double>> bracket() const {
    if (!extreme && (begin <= beyond || end <= beyond)) return {};  // passed, as the ends show
    if (middle < begin && middle < end) {
      if (!(2 * middle - std::max(begin, end) < beyond)) return {};
      return std::pair(part.from, part.until);
    }
    const double way = std::max(std::abs(middle - begin), std::abs(end - middle));
    if (end < middle && end - way < beyond && at(time(1 - beside_end)) < end) return std::pair(time(0.5), part.until);
    if (begin < middle && begin - way < beyond && at(time(beside_end)) < begin) return std::pair(part.from, time(0.5));
    return {};
  }

  /// The vertex of the parabola through the three instants, where the column follows it; else nothing.
  std::optional<Minimum> vertex() const {
    const double a = -3 * begin + 4 * middle - end, b = 2 * (begin - 2 * middle + end);
    const auto follows = [&](double s) {
      return std::abs(at(time(s)) - (begin + s * (a + s * b))) <= share_of_bend * std::abs(b);
    };
    if (!(b > 0) || !follows(0.25) || !follows(0.75)) return {};
    const double share = std::clamp(-a / (2 * b), 0.0, 1.0);
    return Minimum{time(share), begin + share * (a + share * b) + (extreme ? 0 : -share_of_bend * b)};
  }

  std::optional<double> find() const {
    if (request.kind == Request::Kind::root && begin > beyond && end < beyond) {
      const auto gap = [&](double share) { return at(time(share)) - beyond; };
      return time(locate_crossing(gap, 1, begin - beyond, end - beyond));
    }
    if (request.kind == Request::Kind::integral) return {};
    if (std::max({begin, middle, end}) - std::min({begin, middle, end}) <= part.rounding[request.signal]) return {};
    const auto between = bracket();
    if (!between) return {};
    if (const auto smooth = vertex()) {
      if (!(smooth->value < beyond)) return {};
      if (extreme) return smooth->at;
    }
    const double enough = extreme ? -std::numeric_limits<double>::infinity() : beyond;
    const double width = share_of_part * (part.until - part.from);
    const Minimum least = find_minimum([&](double t) { return at(t); }, between->first, between->second, width, enough);
    return least.value < beyond ? std::optional(least.at) : std::nullopt;
  }
};

}  // namespace

std::optional<double> find_first(std::span<const Request> requests, const MotionPart& part) {
  const double width = share_of_part * (part.until - part.from);
  std::optional<double> first;
  for (const Request& s : requests) {
    const auto t = SignalSearch{s, part}.find();
    if (t && *t > part.from + 2 * width && *t < part.until - 2 * width && (!first || *t < *first)) first = t;
  }
  return first;
}

bool needs_halving(std::span<const Request> requests, const MotionPart& part, double share_of_size) {
  std::vector<double> quarter, three_quarters;
  return std::any_of(requests.begin(), requests.end(), [&](const Request& s) {
    if (s.kind != Request::Kind::integral) return false;
    const double begin = part.begin[s.signal], middle = part.middle[s.signal], end = part.end[s.signal];
    const double size = (std::abs(begin) + 4 * std::abs(middle) + std::abs(end)) / 6;
    const double length = part.until - part.from;
    const double allowed =
        std::max({share_of_size * size, share_so_far * std::abs(s.value) / length, part.rounding[s.signal]});
    if (std::max(std::abs(middle - begin), std::abs(end - middle)) <= allowed) return false;
    if (quarter.empty()) {
      const auto row = [&](double share) {
        const auto at = part.at(part.from + share * (part.until - part.from));
        return std::vector<double>(at.begin(), at.end());
      };
      quarter = row(0.25), three_quarters = row(0.75);
    }
    const double whole = (begin + 4 * middle + end) / 6;
    const double halves = (begin + 4 * quarter[s.signal] + 2 * middle + 4 * three_quarters[s.signal] + end) / 12;
    return std::abs(halves - whole) > allowed;
  });
}

}  // namespace subsoil::mbd
