#pragma once
#include <string>
#include <vector>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/friction.hpp"
#include "libdem/laws/law.hpp"

namespace subsoil::dem::test {

struct NamedLaw {
  std::string name;
  Law law;
};

/// Every law of libdem/laws/list.cmake with its example(), alone and with cohesion and bonds where it has them, and
/// settings that take other branches: a property test runs over all.
std::vector<NamedLaw> every_law();

}  // namespace subsoil::dem::test
