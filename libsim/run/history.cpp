#include "libsim/run/history.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace subsoil::sim {

double History::Piece::integral_from(double s) const {
  const auto up_to = [&](double x) { return x * (y + x * (a / 2 + x * b / 3)); };
  return dt * (up_to(1) - up_to(s));
}

// Peaks between have been looked for, and pieces end there: one that the parabola shows is none.
double History::Piece::largest(double s, double sign) const {
  const auto [low, high] = std::minmax({at(0), at(0.5), at(1)});
  const double most = std::max(sign * std::clamp(at(s), low, high), sign * at(1));
  return s < 0.5 ? std::max(most, sign * at(0.5)) : most;
}

History::Piece History::piece_to(double t, double y, double middle) const {
  Piece p{.t = t_, .dt = t - t_, .y = y_, .a = 0, .b = 0};
  // A derivative has no value at the start: there it lies on the line through those after.
  if (rule_.kind == Watch::Kind::integral && std::isnan(y_) && t_ == start_)
    p.y = std::isfinite(middle) && !rule_.held ? 2 * middle - y : y;
  if (rule_.held) return p;
  p.a = y - p.y;
  if (std::isfinite(middle)) p.a = -3 * p.y + 4 * middle - y, p.b = 2 * (p.y - 2 * middle + y);
  return p;
}

void History::add(double t, double y, double middle) {
  if (!begun_) {
    begun_ = true;
    start_ = t_ = t, y_ = y;
    if (rule_.kind == Watch::Kind::mean || rule_.kind == Watch::Kind::maximum || rule_.kind == Watch::Kind::minimum)
      value_ = y;
    if (rule_.kind == Watch::Kind::derivative) value_ = std::numeric_limits<double>::quiet_NaN();  // of one instant
    take_count(y);
    value_ = rule_.kind == Watch::Kind::count ? 0 : value_;
    return;
  }
  before_ = value_;
  if (!(t > t_) || (rule_.kind == Watch::Kind::derivative && t - t_ < rule_.shortest)) {
    last_ = {.t = t_, .dt = 0, .y = y, .a = 0, .b = 0};
    return take_jump(y);
  }
  const Piece p = piece_to(t, y, middle);
  last_ = p, t_ = t, y_ = y;
  switch (rule_.kind) {
    case Watch::Kind::integral:
      if (const double piece = p.integral_from(0); std::isfinite(piece)) value_ += piece;
      break;
    case Watch::Kind::derivative:
      value_ = rule_.held ? (y - p.y) / p.dt : (p.a + 2 * p.b) / p.dt;
      break;
    case Watch::Kind::mean:
      take_mean(p);
      break;
    case Watch::Kind::maximum:
    case Watch::Kind::minimum:
      take_extreme(p, rule_.kind == Watch::Kind::maximum ? 1 : -1);
      break;
    case Watch::Kind::count:
      take_count(y);
      break;
    default:
      take_time(p, rule_.kind == Watch::Kind::time_above ? 1 : -1);
  }
}

double History::at(double t) const {
  if (!(t < t_) || !(last_.dt > 0)) return value_;
  const double s = std::max(0.0, (t - last_.t) / last_.dt), rest = last_.integral_from(s);
  if (std::isfinite(rest)) {
    const double counted = counted_ - (1 - s) * last_.dt;
    if (rule_.kind == Watch::Kind::integral) return value_ - rest;
    if (rule_.kind == Watch::Kind::mean && t_ - rule_.within <= start_ && counted > 0) return (sum_ - rest) / counted;
  }
  return (1 - s) * before_ + s * value_;
}

void History::request(std::size_t column, std::vector<mbd::Request>& out) const {
  if (!begun_ || rule_.held || std::isnan(y_)) return;
  const auto value_to_pass = [&](mbd::Request::Kind kind) {
    out.push_back({column, y_ > rule_.level ? 1.0 : -1.0, rule_.level, kind});
  };
  const auto extreme = [&](double sign) {
    const bool of_all = !std::isfinite(rule_.within) && !std::isnan(value_);
    const double so_far = of_all ? value_ : sign * std::numeric_limits<double>::infinity();
    out.push_back({column, sign, so_far, mbd::Request::Kind::extremum});
  };
  switch (rule_.kind) {
    case Watch::Kind::count:
      return value_to_pass(mbd::Request::Kind::excursion);
    case Watch::Kind::time_above:
    case Watch::Kind::time_below:
      return value_to_pass(mbd::Request::Kind::root);
    case Watch::Kind::maximum:
      return extreme(-1);
    case Watch::Kind::minimum:
      return extreme(1);
    case Watch::Kind::integral:
      out.push_back({column, 1, value_, mbd::Request::Kind::integral});
      return;
    case Watch::Kind::mean:
      out.push_back({column, 1, value_ * std::min(rule_.within, t_ - start_), mbd::Request::Kind::integral});
      return;
    default:
      return;
  }
}

void History::take_jump(double y) {
  if (rule_.held || y == y_) return;
  y_ = y;
  const Piece at_once{.t = t_, .dt = 0, .y = y, .a = 0, .b = 0};
  if (rule_.kind == Watch::Kind::count) take_count(y);
  if (rule_.kind == Watch::Kind::maximum) take_extreme(at_once, 1);
  if (rule_.kind == Watch::Kind::minimum) take_extreme(at_once, -1);
}

void History::take_mean(const Piece& p) {
  if (std::isfinite(p.integral_from(0))) pieces_.push_back(p), sum_ += p.integral_from(0), counted_ += p.dt;
  const double from = std::max(t_ - rule_.within, start_);
  while (!pieces_.empty() && pieces_.front().t + pieces_.front().dt <= from) {
    sum_ -= pieces_.front().integral_from(0), counted_ -= pieces_.front().dt;
    pieces_.pop_front();
  }
  if (pieces_.empty()) {
    value_ = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const Piece& first = pieces_.front();
  const double s = std::max(0.0, (from - first.t) / first.dt);
  value_ = (sum_ - first.integral_from(0) + first.integral_from(s)) / (counted_ - s * first.dt);
}

void History::take_extreme(const Piece& p, double sign) {
  if (std::isnan(y_)) return;  // no value, as 0/0: no extreme
  const double now = std::fmax(p.largest(0, sign), sign * y_);
  if (!std::isfinite(rule_.within)) {
    value_ = sign * std::fmax(sign * value_, now);
    return;
  }
  while (!peaks_.empty() && peaks_.back().largest <= now) peaks_.pop_back();
  peaks_.push_back({p, now});
  const double from = t_ - rule_.within;
  while (peaks_.front().piece.t + peaks_.front().piece.dt < from) peaks_.pop_front();
  const Peak& first = peaks_.front();
  double most = first.largest;
  if (first.piece.t < from) {  // it began before: what of it lies within, and the next one
    const double part = first.piece.largest((from - first.piece.t) / first.piece.dt, sign);
    if (!std::isnan(part)) most = part;
    if (peaks_.size() > 1) most = std::max(most, peaks_[1].largest);
  }
  value_ = sign * most;
}

void History::take_count(double y) {
  const double above = y - rule_.level;
  if (!(std::abs(above) > rule_.noise)) return;  // on the value itself, or without one, it is still where it came from
  const int side = above > 0 ? 1 : -1;
  if (side_ != 0 && side != side_ && (side > 0 ? rule_.rising : rule_.falling)) ++value_;
  side_ = side;
}

void History::take_time(const Piece& p, double sign) {
  const double from = p.y - rule_.level, until = p.at(1) - rule_.level;
  // Where the middle is known passages have been sought: a piece then ends at them, but for the last of very many.
  const bool passes = from * until < 0 && std::min(std::abs(from), std::abs(until)) > 1e-9 * std::abs(from - until);
  if (p.b != 0 && !passes) {
    if (sign * (p.at(0.5) - rule_.level) > rule_.noise)
      value_ += p.dt;
    else if (rule_.unbroken)
      value_ = 0;
    return;
  }
  // The piece in parts on one side of the level.
  std::array<double, 4> cuts{0, 1, 1, 1};
  std::size_t count = 1;
  const double c = from, root = p.a * p.a - 4 * p.b * c;
  if (p.b == 0) {
    if (p.a != 0) cuts[count++] = -c / p.a;
  } else if (root > 0) {
    const double w = -0.5 * (p.a + std::copysign(std::sqrt(root), p.a));
    double first = w / p.b, second = w != 0 ? c / w : first;
    if (first > second) std::swap(first, second);
    cuts[count++] = first, cuts[count++] = second;
  }
  cuts[count] = 1;
  double before = 0;
  for (std::size_t i = 1; i <= count; ++i) {
    const double cut = std::clamp(cuts[i], before, 1.0);
    if (cut > before) {
      const bool beyond = sign * (p.at(0.5 * (before + cut)) - rule_.level) > rule_.noise;
      if (beyond) value_ += (cut - before) * p.dt;
      if (!beyond && rule_.unbroken) value_ = 0;
    }
    before = cut;
  }
}

void History::archive(Archive& a) {
  a("begun", begun_)("start", start_)("t", t_)("y", y_)("value", value_)("sum", sum_)("counted", counted_)("side",
                                                                                                           side_);
  a("pieces", pieces_)("peaks", peaks_)("last", last_)("before", before_);
}

std::string unit_times_second(const std::string& unit) {
  const auto ends = [&](const std::string& with) {
    return unit.size() > with.size() && unit.compare(unit.size() - with.size(), with.size(), with) == 0;
  };
  if (unit == "1") return "s";
  if (unit == "W") return "J";
  if (ends("/s")) return unit.substr(0, unit.size() - 2);
  if (ends("/s^2")) return unit.substr(0, unit.size() - 2);
  return unit + " s";
}

std::string unit_per_second(const std::string& unit) {
  const auto ends = [&](const std::string& with) {
    return unit.size() > with.size() && unit.compare(unit.size() - with.size(), with.size(), with) == 0;
  };
  if (unit == "1") return "1/s";
  if (unit == "s") return "1";
  if (unit == "J") return "W";
  if (ends(" s")) return unit.substr(0, unit.size() - 2);
  if (ends("/s")) return unit + "^2";
  if (ends("/s^2")) return unit.substr(0, unit.size() - 1) + "3";
  return unit + "/s";
}

}  // namespace subsoil::sim
