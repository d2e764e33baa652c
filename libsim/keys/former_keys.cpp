#include "libsim/keys/former_keys.hpp"

#include <algorithm>
#include <array>

namespace subsoil::sim {
namespace {

struct Names {
  std::string_view former, present;
};
constexpr std::array names{
    Names{"lever", "moment arm"},
    Names{"lever at surfaces", "moment arm at surfaces"},
    Names{"slip lever", "slip moment arm"},
    Names{"by-lever", "by-moment-arm"},
    Names{"least", "minimum"},
    Names{"largest", "maximum"},
    Names{"largest restitution", "maximum restitution"},
    Names{"stiffness in turn", "rotational stiffness"},
    Names{"damping in turn", "rotational damping"},
    Names{"preload in turn", "rotational preload"},
    Names{"linear in turn", "linear rotational"},
    Names{"quadratic in turn", "quadratic rotational"},
    Names{"spin", "angular velocity"},
    Names{"watch", "monitor"},
};

std::string_view other_name(std::string_view name, std::string_view Names::*from, std::string_view Names::*to) {
  const auto found = std::find_if(names.begin(), names.end(), [&](const Names& n) { return n.*from == name; });
  return found == names.end() ? std::string_view{} : (*found).*to;
}

}  // namespace

std::string_view former_of(std::string_view present) { return other_name(present, &Names::present, &Names::former); }
std::string_view present_of(std::string_view former) { return other_name(former, &Names::former, &Names::present); }

}  // namespace subsoil::sim
