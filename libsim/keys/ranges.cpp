#include "libsim/keys/ranges.hpp"

#include <cmath>

namespace subsoil::sim {

double value_in_range(Scale scale, double least, double largest, double u) {
  return scale == Scale::log ? least * std::pow(largest / least, u) : least + (largest - least) * u;
}

std::vector<std::string> split_at_semicolons(const std::string& text) {
  std::vector<std::string> out(1);
  for (const char c : text) {
    if (c == ';')
      out.emplace_back();
    else if (c != ' ' || !out.back().empty())
      out.back() += c;
  }
  for (std::string& s : out) s.erase(s.find_last_not_of(' ') + 1);
  std::erase(out, "");
  return out;
}

}  // namespace subsoil::sim
