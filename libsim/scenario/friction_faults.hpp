#pragma once
#include <string>
#include <vector>

/// What keys of friction, each in its own range, get wrong together.
namespace subsoil::sim {

class GivenLaw;

struct FrictionFault {
  const char* key;  ///< of the law: "mu_d"
  double value;     ///< as given
  std::string rule;
  bool idle = false;  ///< the value is in order, but has no effect: refused only where the file has the key
};
std::vector<FrictionFault> friction_faults(const GivenLaw& law);

}  // namespace subsoil::sim
