#pragma once
#include "libsim/keys/known_keys.hpp"

namespace subsoil::sim {

/// The forms of functions of time and of characteristics, once for all keys that take one.
void list_function_forms(std::vector<KnownKey>& keys);

}  // namespace subsoil::sim
