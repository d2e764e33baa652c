#include "libmbd/integrators/hidden_contacts.hpp"

#include <algorithm>

namespace subsoil::mbd {

namespace {
// Speeds are looked at where samples are: between them they may be higher by some.
constexpr double faster_between = 1.5;
}  // namespace

std::optional<HiddenContacts::Found> HiddenContacts::find(const Switches& switches, double length_scale,
                                                          const Sample& begin, const Sample& end, const Look& look) {
  switches_ = &switches, look_ = &look, least_ = least_way * length_scale;
  return search(begin, end, 0);
}

bool HiddenContacts::may_close(const Sample& a, const Sample& b) const {
  for (std::size_t i = 0; i < a.gaps.size(); ++i) {
    if (!(a.gaps[i] >= 0 && b.gaps[i] >= 0) || switches_->side(i) < 0) continue;
    const double way = faster_between * std::max(a.speeds[i], b.speeds[i]) * (b.t - a.t);
    if (way > least_ && a.gaps[i] + b.gaps[i] < way) return true;
  }
  return false;
}

std::optional<HiddenContacts::Found> HiddenContacts::search(const Sample& a, const Sample& b, int halvings) {
  if (halvings == most_halvings || !may_close(a, b)) return {};
  Sample middle{.t = 0.5 * (a.t + b.t)};
  (*look_)(middle);
  if (const auto earlier = search(a, middle, halvings + 1)) return earlier;
  for (std::size_t i = 0; i < a.gaps.size(); ++i)
    if (switches_->side(i) > 0 && middle.speeds[i] > 0 && a.gaps[i] > 0 && middle.gaps[i] < 0 && b.gaps[i] >= 0)
      return Found{i, a.t, middle.t};
  return search(middle, b, halvings + 1);
}

}  // namespace subsoil::mbd
