#pragma once

#include <vector>

namespace subsoil::mbd {

/// The bodies that an element names, whichever way it does.
template <class Element>
std::vector<int> bodies_of(const Element& e) {
  if constexpr (requires { e.body_a(); }) {
    return {e.body_a(), e.body_b()};
  } else if constexpr (requires { e.body_c; }) {
    return {e.body_a, e.body_b, e.body_c};
  } else if constexpr (requires { e.body_a; }) {
    return {e.body_a, e.body_b};
  } else {
    return {e.body};
  }
}

}  // namespace subsoil::mbd
