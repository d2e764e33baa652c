#include "libsim/keys/former_keys.hpp"

#include <algorithm>
#include <array>

namespace subsoil::sim {
namespace {

struct FormerName {
  std::string_view former, present;
};
constexpr std::array names{
    FormerName{"lever", "moment arm"},
    FormerName{"lever at surfaces", "moment arm at surfaces"},
    FormerName{"slip lever", "slip moment arm"},
    FormerName{"by-lever", "by-moment-arm"},
    FormerName{"least", "minimum"},
    FormerName{"largest", "maximum"},
    FormerName{"largest restitution", "maximum restitution"},
    FormerName{"stiffness in turn", "rotational stiffness"},
    FormerName{"damping in turn", "rotational damping"},
    FormerName{"preload in turn", "rotational preload"},
    FormerName{"linear in turn", "linear rotational"},
    FormerName{"quadratic in turn", "quadratic rotational"},
    FormerName{"spin", "angular velocity"},
    FormerName{"watch", "monitor"},
};

std::string_view other_name(std::string_view name, std::string_view FormerName::*from,
                            std::string_view FormerName::*to) {
  const auto found = std::find_if(names.begin(), names.end(), [&](const FormerName& n) { return n.*from == name; });
  return found == names.end() ? std::string_view{} : (*found).*to;
}

}  // namespace

std::string_view former_of(std::string_view present) {
  return other_name(present, &FormerName::present, &FormerName::former);
}
std::string_view present_of(std::string_view former) {
  return other_name(former, &FormerName::former, &FormerName::present);
}

}  // namespace subsoil::sim
