#include <cstring>
#include <new>

#include "libsim/fmu/library/call.hpp"
#include "libsim/fmu/vendor/fmi2Functions.h"

using subsoil::sim::call;
using subsoil::sim::FmuInstance;
using subsoil::sim::HeldState;

namespace {

/// file:///tmp/a%20b/resources -> /tmp/a b/resources
std::filesystem::path path_of(std::string uri) {
  for (const std::string scheme : {"file://localhost", "file://", "file:"})
    if (uri.rfind(scheme, 0) == 0) {
      uri.erase(0, scheme.size());
      break;
    }
  std::string out;
  for (std::size_t k = 0; k < uri.size(); ++k)
    if (uri[k] == '%' && k + 2 < uri.size()) {
      out += static_cast<char>(std::stoi(uri.substr(k + 1, 2), nullptr, 16));
      k += 2;
    } else {
      out += uri[k];
    }
  return out;
}

fmi2Status refuse(fmi2Component c, const char* what) {
  return call(c, fmi2Error, [&](FmuInstance& self) {
    self.log(FmuInstance::Level::error, std::string(what) + ": is not provided, as the model description states");
    return fmi2Error;
  });
}

}  // namespace

extern "C" {

const char* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }
const char* fmi2GetVersion() { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t, const fmi2String*) {
  return call(c, fmi2Error, [&](FmuInstance& self) { return self.logs_all = on != fmi2False, fmi2OK; });
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions* functions, fmi2Boolean, fmi2Boolean logging) {
  const std::string instance_name = name;
  const auto logger = functions->logger;
  void* const environment = functions->componentEnvironment;
  const FmuInstance::Log log = [=](FmuInstance::Level level, const std::string& text) {
    if (logger == nullptr) return;
    const bool error = level == FmuInstance::Level::error, warning = level == FmuInstance::Level::warning;
    logger(environment, instance_name.c_str(),
           error     ? fmi2Error
           : warning ? fmi2Warning
                     : fmi2OK,
           error     ? "logStatusError"
           : warning ? "logStatusWarning"
                     : "logAll",
           "%s", text.c_str());
  };
  try {
    if (type != fmi2CoSimulation) throw std::invalid_argument("type: must be co-simulation");
    if (resources == nullptr) throw std::invalid_argument("resource location: is missing");
    auto* const out = new FmuInstance(path_of(resources), token, log);
    out->logs_all = logging != fmi2False;
    return out;
  } catch (const std::exception& fault) {
    log(FmuInstance::Level::error, fault.what());
    return nullptr;
  }
}

void fmi2FreeInstance(fmi2Component c) { delete static_cast<FmuInstance*>(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real start, fmi2Boolean stops,
                               fmi2Real stop) {
  return call(c, fmi2Error, [&](FmuInstance& self) {
    return self.start_at(start, stops ? std::optional(stop) : std::nullopt), fmi2OK;
  });
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return call(c, fmi2Error, [](FmuInstance& self) { return self.enter_initialization(), fmi2OK; });
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return call(c, fmi2Error, [](FmuInstance& self) { return self.exit_initialization(), fmi2OK; });
}
fmi2Status fmi2Terminate(fmi2Component) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) {
  return call(c, fmi2Error, [](FmuInstance& self) { return self.reset(), fmi2OK; });
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[]) {
  return call(c, fmi2Error, [&](FmuInstance& self) {
    for (size_t k = 0; k < n; ++k) values[k] = self.get(vr[k]);
    return fmi2OK;
  });
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[]) {
  return call(c, fmi2Error, [&](FmuInstance& self) {
    for (size_t k = 0; k < n; ++k) self.set(vr[k], values[k]);
    return fmi2OK;
  });
}

#define NO_VARIABLES(NAME, TYPE)                                                 \
  fmi2Status NAME(fmi2Component c, const fmi2ValueReference[], size_t n, TYPE) { \
    return n == 0 ? fmi2OK : refuse(c, #NAME);                                   \
  }
NO_VARIABLES(fmi2GetInteger, fmi2Integer[])
NO_VARIABLES(fmi2GetBoolean, fmi2Boolean[])
NO_VARIABLES(fmi2GetString, fmi2String[])
NO_VARIABLES(fmi2SetInteger, const fmi2Integer[])
NO_VARIABLES(fmi2SetBoolean, const fmi2Boolean[])
NO_VARIABLES(fmi2SetString, const fmi2String[])
#undef NO_VARIABLES

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return call(c, fmi2Error, [&](FmuInstance& self) {
    auto saved = self.save();
    if (*state != nullptr)
      *static_cast<HeldState*>(*state) = std::move(saved);
    else
      *state = new HeldState(std::move(saved));
    return fmi2OK;
  });
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return call(c, fmi2Error, [&](FmuInstance& self) { return self.restore(**static_cast<HeldState*>(state)), fmi2OK; });
}
fmi2Status fmi2FreeFMUstate(fmi2Component, fmi2FMUstate* state) {
  if (state == nullptr) return fmi2OK;
  delete static_cast<HeldState*>(*state);
  *state = nullptr;
  return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  return call(c, fmi2Error, [&](FmuInstance& self) {
    return *size = self.serialized(*static_cast<HeldState*>(state)).size(), fmi2OK;
  });
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte out[], size_t size) {
  return call(c, fmi2Error, [&](FmuInstance& self) {
    const auto& bytes = self.serialized(*static_cast<HeldState*>(state));
    if (size < bytes.size()) throw std::invalid_argument("serialized state: the buffer is too small");
    return std::memcpy(out, bytes.data(), bytes.size()), fmi2OK;
  });
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
  return call(c, fmi2Error, [&](FmuInstance&) {
    auto read = FmuInstance::state_of({reinterpret_cast<const std::byte*>(bytes), size});
    return *state = new HeldState(std::move(read)), fmi2OK;
  });
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2ValueReference[],
                                        size_t, const fmi2Real[], fmi2Real[]) {
  return refuse(c, "fmi2GetDirectionalDerivative");
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                       const fmi2Real[]) {
  return refuse(c, "fmi2SetRealInputDerivatives");
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                        fmi2Real[]) {
  return refuse(c, "fmi2GetRealOutputDerivatives");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real length, fmi2Boolean) {
  return call(c, fmi2Error, [&](FmuInstance& self) { return self.step(time, length), fmi2OK; });
}
fmi2Status fmi2CancelStep(fmi2Component c) { return refuse(c, "fmi2CancelStep"); }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind, fmi2Status*) { return refuse(c, "fmi2GetStatus"); }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
  if (kind != fmi2LastSuccessfulTime) return refuse(c, "fmi2GetRealStatus");
  return call(c, fmi2Error, [&](FmuInstance& self) { return *value = self.get(0), fmi2OK; });
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind, fmi2Integer*) {
  return refuse(c, "fmi2GetIntegerStatus");
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean* value) {
  if (kind != fmi2Terminated) return refuse(c, "fmi2GetBooleanStatus");
  return *value = fmi2False, fmi2OK;
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind, fmi2String*) {
  return refuse(c, "fmi2GetStringStatus");
}

}  // extern "C"
