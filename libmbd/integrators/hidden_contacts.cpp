#include "libmbd/integrators/hidden_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace subsoil::mbd {

namespace {

constexpr double least_way = 1e-4;  // of a piece, over the machine's length
constexpr int most_levels = 10;
// Speeds are looked at where samples are: between them they may be higher by some.
constexpr double faster_between = 1.5;

struct Search {
  const Switches& switches;
  double least;  // way of a piece, m
  const std::function<void(GapSample&)>& look;

  bool may_close(const GapSample& a, const GapSample& b) const {
    for (std::size_t i = 0; i < a.gaps.size(); ++i) {
      if (!(a.gaps[i] >= 0 && b.gaps[i] >= 0) || switches.side(i) < 0) continue;
      const double way = faster_between * std::max(a.speeds[i], b.speeds[i]) * (b.t - a.t);
      if (way > least && a.gaps[i] + b.gaps[i] < way) return true;
    }
    return false;
  }

  std::optional<HiddenContact> between(const GapSample& a, const GapSample& b, int level) const {
    if (level == most_levels || !may_close(a, b)) return {};
    GapSample middle{.t = 0.5 * (a.t + b.t)};
    look(middle);
    if (const auto earlier = between(a, middle, level + 1)) return earlier;
    for (std::size_t i = 0; i < a.gaps.size(); ++i)
      if (switches.side(i) > 0 && middle.speeds[i] > 0 && a.gaps[i] > 0 && middle.gaps[i] < 0 && b.gaps[i] >= 0)
        return HiddenContact{i, a.t, middle.t};
    return between(middle, b, level + 1);
  }
};

}  // namespace

std::optional<HiddenContact> find_hidden_contact(const Switches& switches, double length_scale, const GapSample& begin,
                                                 const GapSample& end, const std::function<void(GapSample&)>& look) {
  return Search{switches, least_way * length_scale, look}.between(begin, end, 0);
}

Minimum find_minimum(const std::function<double(double)>& g, double low, double high, double width, double enough) {
  constexpr double golden = 0.6180339887498949;
  double left = high - golden * (high - low), right = low + golden * (high - low);
  double at_left = g(left), at_right = g(right);
  // Of a short bracket late in a motion times say no more than their rounding.
  const double least =
      std::max(width, 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(low), std::abs(high)));
  while (!(std::min(at_left, at_right) < enough) && high - low > least) {
    if (at_left < at_right) {
      high = right, right = left, at_right = at_left;
      left = high - golden * (high - low), at_left = g(left);
    } else {
      low = left, left = right, at_left = at_right;
      right = low + golden * (high - low), at_right = g(right);
    }
  }
  return at_left < at_right ? Minimum{left, at_left} : Minimum{right, at_right};
}

std::vector<double> event_times(double begin, double h, double turn) {
  constexpr double apart = 0.25, beside = 1e-3;  // rad; share of the step
  const auto pieces = static_cast<long>(std::clamp(std::ceil(turn / apart), 4.0, 1e6));
  std::vector<double> out{begin, begin + beside * h / static_cast<double>(pieces / 4)};
  for (long k = 1; k < pieces; ++k) out.push_back(begin + h * static_cast<double>(k) / static_cast<double>(pieces));
  out.push_back(begin + h - beside * h / static_cast<double>(pieces / 4)), out.push_back(begin + h);
  return out;
}

double largest_turn(const Eigen::VectorXd& q_before, const Eigen::VectorXd& q) {
  double out = 0;
  for (Eigen::Index i = 2; i < q.size(); i += 3) out = std::max(out, std::abs(q[i] - q_before[i]));
  return out;
}

namespace {
bool leads_to_zero(const TimedValue& before, const TimedValue& here, const TimedValue& after) {
  const double falls = before.value - here.value, rises = after.value - here.value;
  const double left = here.t - before.t, right = after.t - here.t;
  const double reach = std::max(falls / left, rises / right) * std::max(left, right);
  return falls >= 0 && rises >= 0 && here.value < reach;
}
}  // namespace

bool may_dip(std::span<const TimedValue> samples) {
  if (samples.size() < 3 || !(samples.front().value > 0)) return false;
  for (std::size_t k = 1; k + 1 < samples.size(); ++k)
    if (samples[k].value < 0 || leads_to_zero(samples[k - 1], samples[k], samples[k + 1])) return true;
  return false;
}

std::optional<HiddenPassage> find_hidden_dip(std::span<const TimedValue> samples,
                                             const std::function<double(double)>& g) {
  if (samples.size() < 3 || !(samples.front().value > 0)) return {};
  for (std::size_t k = 1; k + 1 < samples.size(); ++k) {
    const TimedValue &before = samples[k - 1], &here = samples[k], &after = samples[k + 1];
    if (here.value < 0) return HiddenPassage{before.t, here.t};
    if (!leads_to_zero(before, here, after)) continue;
    const double width = 1e-8 * (after.t - before.t);  // a minimum is flat over sqrt(epsilon)
    const Minimum least = find_minimum(g, before.t, after.t, width, 0);
    if (least.value < 0) return HiddenPassage{before.t, least.at};
  }
  return {};
}

}  // namespace subsoil::mbd
