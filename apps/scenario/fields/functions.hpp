#pragma once
#include "apps/scenario/known_keys.hpp"

namespace subsoil::app {

/// The forms of functions of time and of characteristics, once for all keys that take one.
void list_function_forms(std::vector<KnownKey>& keys);

}  // namespace subsoil::app
