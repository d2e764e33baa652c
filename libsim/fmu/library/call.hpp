#pragma once
#include <exception>

#include "libsim/fmu/library/instance.hpp"

namespace subsoil::sim {

/// Runs a call of an importer; a fault is logged and becomes `error`.
template <class Status, class Body>
Status call(void* instance, Status error, Body body) {
  if (instance == nullptr) return error;
  FmuInstance& self = *static_cast<FmuInstance*>(instance);
  const LogScope scope(self);
  try {
    return body(self);
  } catch (const std::exception& fault) {
    self.log(FmuInstance::Level::error, fault.what());
  } catch (...) {
    self.log(FmuInstance::Level::error, "a fault without a description");
  }
  return error;
}

/// A state that an importer holds.
using HeldState = std::shared_ptr<FmuInstance::State>;

}  // namespace subsoil::sim
