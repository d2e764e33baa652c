#pragma once
#include <stdexcept>

namespace subsoil::dem {

/// A contact, sphere or state that no longer makes sense: the run stops, reports where and keeps what it has.
struct BedFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace subsoil::dem
