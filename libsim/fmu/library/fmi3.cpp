#include <cstring>

#include "libsim/fmu/library/call.hpp"
#include "libsim/fmu/vendor/fmi3Functions.h"

using subsoil::sim::call;
using subsoil::sim::FmuInstance;
using subsoil::sim::HeldState;

namespace {

/// The callbacks for intermediate values, beside the instance.
struct Component : FmuInstance {
  using FmuInstance::FmuInstance;
  fmi3InstanceEnvironment environment = nullptr;
  fmi3IntermediateUpdateCallback update = nullptr;
  bool early_return = false;
};

fmi3Status refuse(fmi3Instance c, const char* what) {
  return call(c, fmi3Error, [&](FmuInstance& self) {
    self.log(FmuInstance::Level::error, std::string(what) + ": is not provided, as the model description states");
    return fmi3Error;
  });
}

/// A folder's path; some importers hand over its URI.
std::filesystem::path path_of(const std::string& text) { return text.rfind("file://", 0) == 0 ? text.substr(7) : text; }

}  // namespace

extern "C" {

const char* fmi3GetVersion() { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t, const fmi3String[]) {
  return call(c, fmi3Error, [&](FmuInstance& self) { return self.logs_all = on, fmi3OK; });
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String, fmi3String token, fmi3String resources, fmi3Boolean,
                                         fmi3Boolean logging, fmi3Boolean, fmi3Boolean early_return,
                                         const fmi3ValueReference[], size_t, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update) {
  const FmuInstance::Log log = [=](FmuInstance::Level level, const std::string& text) {
    if (logger == nullptr) return;
    const bool error = level == FmuInstance::Level::error, warning = level == FmuInstance::Level::warning;
    logger(environment,
           error     ? fmi3Error
           : warning ? fmi3Warning
                     : fmi3OK,
           error     ? "logStatusError"
           : warning ? "logStatusWarning"
                     : "logAll",
           text.c_str());
  };
  try {
    if (resources == nullptr) throw std::invalid_argument("resource path: is missing");
    auto* const out = new Component(path_of(resources), token, log);
    out->logs_all = logging;
    out->environment = environment, out->update = update, out->early_return = early_return;
    return static_cast<FmuInstance*>(out);
  } catch (const std::exception& fault) {
    log(FmuInstance::Level::error, fault.what());
    return nullptr;
  }
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
  if (logger != nullptr) logger(environment, fmi3Error, "logStatusError", "the FMU is for co-simulation only");
  return nullptr;
}
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                               fmi3UnlockPreemptionCallback) {
  if (logger != nullptr) logger(environment, fmi3Error, "logStatusError", "the FMU is for co-simulation only");
  return nullptr;
}
void fmi3FreeInstance(fmi3Instance c) { delete static_cast<Component*>(static_cast<FmuInstance*>(c)); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean, fmi3Float64, fmi3Float64 start, fmi3Boolean stops,
                                       fmi3Float64 stop) {
  return call(c, fmi3Error, [&](FmuInstance& self) {
    self.start_at(start, stops ? std::optional(stop) : std::nullopt);
    return self.enter_initialization(), fmi3OK;
  });
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
  return call(c, fmi3Error, [](FmuInstance& self) { return self.exit_initialization(), fmi3OK; });
}
fmi3Status fmi3EnterStepMode(fmi3Instance) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance) { return fmi3OK; }
fmi3Status fmi3Reset(fmi3Instance c) {
  return call(c, fmi3Error, [](FmuInstance& self) { return self.reset(), fmi3OK; });
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[], size_t m) {
  return call(c, fmi3Error, [&](FmuInstance& self) {
    if (m != n) throw std::invalid_argument("fmi3GetFloat64: all variables are scalars, one value each");
    for (size_t k = 0; k < n; ++k) values[k] = self.get(vr[k]);
    return fmi3OK;
  });
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                          size_t m) {
  return call(c, fmi3Error, [&](FmuInstance& self) {
    if (m != n) throw std::invalid_argument("fmi3SetFloat64: all variables are scalars, one value each");
    for (size_t k = 0; k < n; ++k) self.set(vr[k], values[k]);
    return fmi3OK;
  });
}

// All variables are of type Float64.
#define NO_VARIABLES(TYPE)                                                                                     \
  fmi3Status fmi3Get##TYPE(fmi3Instance c, const fmi3ValueReference[], size_t n, fmi3##TYPE[], size_t) {       \
    return n == 0 ? fmi3OK : refuse(c, "fmi3Get" #TYPE);                                                       \
  }                                                                                                            \
  fmi3Status fmi3Set##TYPE(fmi3Instance c, const fmi3ValueReference[], size_t n, const fmi3##TYPE[], size_t) { \
    return n == 0 ? fmi3OK : refuse(c, "fmi3Set" #TYPE);                                                       \
  }
NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)
#undef NO_VARIABLES
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference[], size_t n, size_t[], fmi3Binary[], size_t) {
  return n == 0 ? fmi3OK : refuse(c, "fmi3GetBinary");
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference[], size_t n, const size_t[], const fmi3Binary[],
                         size_t) {
  return n == 0 ? fmi3OK : refuse(c, "fmi3SetBinary");
}
fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference[], size_t n, fmi3Clock[]) {
  return n == 0 ? fmi3OK : refuse(c, "fmi3GetClock");
}
fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference[], size_t n, const fmi3Clock[]) {
  return n == 0 ? fmi3OK : refuse(c, "fmi3SetClock");
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* state) {
  return call(c, fmi3Error, [&](FmuInstance& self) {
    auto saved = self.save();
    if (*state != nullptr)
      *static_cast<HeldState*>(*state) = std::move(saved);
    else
      *state = new HeldState(std::move(saved));
    return fmi3OK;
  });
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
  return call(c, fmi3Error, [&](FmuInstance& self) { return self.restore(**static_cast<HeldState*>(state)), fmi3OK; });
}
fmi3Status fmi3FreeFMUState(fmi3Instance, fmi3FMUState* state) {
  if (state == nullptr) return fmi3OK;
  delete static_cast<HeldState*>(*state);
  *state = nullptr;
  return fmi3OK;
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t* size) {
  return call(c, fmi3Error, [&](FmuInstance& self) {
    return *size = self.serialized(*static_cast<HeldState*>(state)).size(), fmi3OK;
  });
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte out[], size_t size) {
  return call(c, fmi3Error, [&](FmuInstance& self) {
    const auto& bytes = self.serialized(*static_cast<HeldState*>(state));
    if (size < bytes.size()) throw std::invalid_argument("serialized state: the buffer is too small");
    return std::memcpy(out, bytes.data(), bytes.size()), fmi3OK;
  });
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
  return call(c, fmi3Error, [&](FmuInstance&) {
    auto read = FmuInstance::state_of({reinterpret_cast<const std::byte*>(bytes), size});
    return *state = new HeldState(std::move(read)), fmi3OK;
  });
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 length, fmi3Boolean, fmi3Boolean* event,
                      fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* reached) {
  return call(c, fmi3Error, [&](FmuInstance& instance) {
    auto& self = static_cast<Component&>(instance);
    *event = *terminate = *early = false, *reached = time;
    FmuInstance::Intermediate update;
    if (self.update != nullptr)
      update = [&](double t) {
        fmi3Boolean asked = false;
        fmi3Float64 until = 0;
        self.update(self.environment, t, false, true, true, self.early_return, &asked, &until);
        return self.early_return && asked && t >= until;
      };
    *reached = self.step(time, length, update);
    *early = *reached < time + length;
    return fmi3OK;
  });
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference, size_t*) {
  return refuse(c, "fmi3GetNumberOfVariableDependencies");
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference, size_t[], fmi3ValueReference[], size_t[],
                                       fmi3DependencyKind[], size_t) {
  return refuse(c, "fmi3GetVariableDependencies");
}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference[], size_t, const fmi3ValueReference[],
                                        size_t, const fmi3Float64[], size_t, fmi3Float64[], size_t) {
  return refuse(c, "fmi3GetDirectionalDerivative");
}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference[], size_t, const fmi3ValueReference[],
                                    size_t, const fmi3Float64[], size_t, fmi3Float64[], size_t) {
  return refuse(c, "fmi3GetAdjointDerivative");
}
fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference[], size_t, const fmi3Int32[],
                                    fmi3Float64[], size_t) {
  return refuse(c, "fmi3GetOutputDerivatives");
}
fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference[], size_t, fmi3Float64[],
                                  fmi3IntervalQualifier[]) {
  return refuse(c, "fmi3GetIntervalDecimal");
}
fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[],
                                   fmi3IntervalQualifier[]) {
  return refuse(c, "fmi3GetIntervalFraction");
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference[], size_t, fmi3Float64[]) {
  return refuse(c, "fmi3GetShiftDecimal");
}
fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[]) {
  return refuse(c, "fmi3GetShiftFraction");
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference[], size_t, const fmi3Float64[]) {
  return refuse(c, "fmi3SetIntervalDecimal");
}
fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference[], size_t, const fmi3UInt64[],
                                   const fmi3UInt64[]) {
  return refuse(c, "fmi3SetIntervalFraction");
}
fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference[], size_t, const fmi3Float64[]) {
  return refuse(c, "fmi3SetShiftDecimal");
}
fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference[], size_t, const fmi3UInt64[],
                                const fmi3UInt64[]) {
  return refuse(c, "fmi3SetShiftFraction");
}
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64) { return refuse(c, "fmi3SetTime"); }
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64[], size_t) {
  return refuse(c, "fmi3SetContinuousStates");
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64[], size_t) {
  return refuse(c, "fmi3GetContinuousStateDerivatives");
}
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64[], size_t) { return refuse(c, "fmi3GetEventIndicators"); }
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64[], size_t) {
  return refuse(c, "fmi3GetContinuousStates");
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64[], size_t) {
  return refuse(c, "fmi3GetNominalsOfContinuousStates");
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t*) {
  return refuse(c, "fmi3GetNumberOfEventIndicators");
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t*) {
  return refuse(c, "fmi3GetNumberOfContinuousStates");
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean, fmi3Boolean*, fmi3Boolean*) {
  return refuse(c, "fmi3CompletedIntegratorStep");
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*,
                                    fmi3Boolean*, fmi3Float64*) {
  return refuse(c, "fmi3UpdateDiscreteStates");
}
fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference, fmi3Float64) {
  return refuse(c, "fmi3ActivateModelPartition");
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return refuse(c, "fmi3EnterEventMode"); }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return refuse(c, "fmi3EnterConfigurationMode"); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return refuse(c, "fmi3ExitConfigurationMode"); }
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return refuse(c, "fmi3EnterContinuousTimeMode"); }
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) { return refuse(c, "fmi3EvaluateDiscreteStates"); }

}  // extern "C"
