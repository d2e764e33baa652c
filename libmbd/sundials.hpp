#pragma once

// What both users of SUNDIALS share: the one place where its return codes are looked at, and owners of its objects.
// Private to libmbd's sources: no other header includes it.

#include <nvector/nvector_serial.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>

namespace subsoil::mbd::sundials {

using Map = Eigen::Map<Eigen::VectorXd>;
using ConstMap = Eigen::Map<const Eigen::VectorXd>;
using NameOfCode = char* (*)(long int);

/// Throws for a negative return code with the call and SUNDIALS' own name of the code.
inline void check(int code, const std::string& call, NameOfCode name_of = nullptr) {
  if (code >= 0) return;
  char* name = name_of ? name_of(code) : nullptr;
  const std::string text =
      "SUNDIALS " + call + " failed: " + (name ? std::string(name) : "code " + std::to_string(code));
  std::free(name);
  throw std::runtime_error(text);
}
template <class Pointer>
Pointer* check(Pointer* pointer, const char* call) {
  if (!pointer) throw std::runtime_error(std::string("SUNDIALS ") + call + " failed: no memory");
  return pointer;
}

class Context {
 public:
  Context() { check(SUNContext_Create(nullptr, &context_), "SUNContext_Create"); }
  ~Context() { SUNContext_Free(&context_); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  operator SUNContext() const { return context_; }

 private:
  SUNContext context_ = nullptr;
};

/// A serial vector, zero at first.
class Vector {
 public:
  Vector(Eigen::Index size, const Context& context) : vector_(check(N_VNew_Serial(size, context), "N_VNew_Serial")) {
    N_VConst(0, vector_);
  }
  ~Vector() { N_VDestroy(vector_); }
  Vector(const Vector&) = delete;
  Vector& operator=(const Vector&) = delete;
  operator N_Vector() const { return vector_; }
  Map map() const { return {N_VGetArrayPointer(vector_), N_VGetLength(vector_)}; }

 private:
  N_Vector vector_;
};

/// SUNDIALS' own lines on stderr are left out: what matters of them stands in the message of the exception.
inline void silence(int, const char*, const char*, char*, void*) {}

/// Calls back into C++ where no exception may cross C: it is kept for the caller and `code` tells SUNDIALS.
template <class Call>
int guarded(std::exception_ptr& thrown, int code, Call call) {
  try {
    call();
    return 0;
  } catch (...) {
    thrown = std::current_exception();
    return code;
  }
}

}  // namespace subsoil::mbd::sundials
