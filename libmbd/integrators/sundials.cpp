#include "libmbd/integrators/sundials.hpp"

#include <nvector/nvector_serial.h>

#include <cstdlib>
#include <stdexcept>

#include "libmbd/base/fault.hpp"

namespace subsoil::mbd::sundials {

namespace {

std::string name_of_code(int code, NameOfCode name_of) {
  char* const name = name_of ? name_of(code) : nullptr;
  const std::string text = name ? std::string(name) : "code " + std::to_string(code);
  std::free(name);
  return text;
}

std::string cause(const std::string& name) {
  const auto has = [&](const char* part) { return name.find(part) != std::string::npos; };
  if (has("ERR_FAIL"))
    return "no step is short enough for the tolerance: a force jumps there or grows without bound, or the tolerance is "
           "near rounding; make the force continuous or widen rtol and atol";
  if (has("CONV_FAIL"))
    return "the equations of a step have no solution near by, however short it is: the machine locks up, or a force "
           "jumps there";
  if (has("LSETUP") || has("LSOLVE"))
    return "the equations of a step are singular: constraints lose their rank there, a lock-up or a dead centre";
  if (has("TOO_MUCH_ACC")) return "the tolerance asks for more digits than there are; widen rtol and atol";
  return "the solver gave up";
}

}  // namespace

void check(int code, const std::string& call, NameOfCode name_of) {
  if (code >= 0) return;
  throw std::runtime_error("SUNDIALS " + call + " failed: " + name_of_code(code, name_of));
}

void check_step(int code, double t, NameOfCode name_of) {
  if (code >= 0) return;
  const std::string name = name_of_code(code, name_of);
  throw MotionFault(t, cause(name) + " (SUNDIALS " + name + ")");
}

void refuse_null(const char* call) { throw std::runtime_error(std::string("SUNDIALS ") + call + " failed: no memory"); }

Context::Context() { check(SUNContext_Create(nullptr, &context_), "SUNContext_Create"); }
Context::~Context() { SUNContext_Free(&context_); }

Vector::Vector(Eigen::Index size, const Context& context)
    : vector_(check(N_VNew_Serial(size, context), "N_VNew_Serial")) {
  N_VConst(0, vector_);
}
Vector::~Vector() { N_VDestroy(vector_); }
Map Vector::map() const { return {N_VGetArrayPointer(vector_), N_VGetLength(vector_)}; }

}  // namespace subsoil::mbd::sundials
