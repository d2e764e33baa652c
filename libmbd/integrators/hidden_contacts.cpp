#include "libmbd/integrators/hidden_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace subsoil::mbd {

namespace {

constexpr std::size_t most_looks = 1024, isolated = 8;
// Speeds are looked at where samples are: between them they may be higher by some.
constexpr double faster_between = 1.5;

struct Piece {
  GapSample begin, end;
};

/// Up to which way the bodies move against each other in a piece in which a contact may close; 0: none may.
double way_to_close(const Switches& switches, const Piece& p) {
  double out = 0;
  for (std::size_t i = 0; i < p.begin.gaps.size(); ++i) {
    const double a = p.begin.gaps[i], b = p.end.gaps[i];
    if (!(a >= 0 && b >= 0) || switches.side(i) < 0) continue;
    const double way = faster_between * std::max(p.begin.speeds[i], p.end.speeds[i]) * (p.end.t - p.begin.t);
    if (a + b < way) out = std::max(out, way);
  }
  return out;
}

std::optional<HiddenContact> closed_in(const Switches& switches, const Piece& p, const GapSample& middle) {
  for (std::size_t i = 0; i < middle.gaps.size(); ++i)
    if (switches.side(i) > 0 && middle.speeds[i] > 0 && p.begin.gaps[i] > 0 && middle.gaps[i] < 0 && p.end.gaps[i] >= 0)
      return HiddenContact{i, p.begin.t, middle.t};
  return {};
}

}  // namespace

std::optional<HiddenContact> find_hidden_contact(const Switches& switches, const WaysOfPieces& ways,
                                                 const GapSample& begin, const GapSample& end,
                                                 const std::function<void(GapSample&)>& look) {
  std::vector<Piece> pieces{{begin, end}}, halves;
  for (std::size_t looks = 0;; looks += pieces.size()) {
    double widest = 0;
    std::erase_if(pieces, [&](const Piece& p) {
      const double way = way_to_close(switches, p);
      widest = std::max(widest, way);
      const double middle = 0.5 * (p.begin.t + p.end.t);
      return !(way > ways.finest && p.begin.t < middle && middle < p.end.t);
    });
    const bool goes_on = pieces.size() <= isolated || (looks < most_looks && widest > ways.minimum);
    if (pieces.empty() || !goes_on) return {};
    halves.clear();
    for (Piece& p : pieces) {
      GapSample middle{.t = 0.5 * (p.begin.t + p.end.t)};
      look(middle);
      if (const auto found = closed_in(switches, p, middle)) return found;
      halves.push_back({std::move(p.begin), middle});
      halves.push_back({std::move(middle), std::move(p.end)});
    }
    pieces.swap(halves);
  }
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
