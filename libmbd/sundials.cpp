#include "libmbd/sundials.hpp"

#include <nvector/nvector_serial.h>

#include <cstdlib>
#include <stdexcept>

namespace subsoil::mbd::sundials {

void check(int code, const std::string& call, NameOfCode name_of) {
  if (code >= 0) return;
  char* name = name_of ? name_of(code) : nullptr;
  const std::string text =
      "SUNDIALS " + call + " failed: " + (name ? std::string(name) : "code " + std::to_string(code));
  std::free(name);
  throw std::runtime_error(text);
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
