#pragma once

// What both users of SUNDIALS share: the one place where its return codes are looked at, and owners of its objects.
// Only sources of libmbd include it; SUNDIALS' own headers stay in sources, so its handles are declared here.

#include <Eigen/Core>
#include <exception>
#include <string>

typedef struct _SUNContext* SUNContext;
typedef struct _generic_N_Vector* N_Vector;

namespace subsoil::mbd::sundials {

using Map = Eigen::Map<Eigen::VectorXd>;
using ConstMap = Eigen::Map<const Eigen::VectorXd>;
using NameOfCode = char* (*)(long int);

/// Throws for a negative return code with the call and SUNDIALS' own name of the code.
void check(int code, const std::string& call, NameOfCode name_of = nullptr);
/// The same for a step from t: states in words what the code means for a machine.
void check_step(int code, double t, NameOfCode name_of);
[[noreturn]] void refuse_null(const char* call);
template <class Pointer>
Pointer* check(Pointer* pointer, const char* call) {
  if (!pointer) refuse_null(call);
  return pointer;
}

class Context {
 public:
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  operator SUNContext() const { return context_; }

 private:
  SUNContext context_ = nullptr;
};

/// A serial vector, zero at first.
class Vector {
 public:
  Vector(Eigen::Index size, const Context& context);
  ~Vector();
  Vector(const Vector&) = delete;
  Vector& operator=(const Vector&) = delete;
  operator N_Vector() const { return vector_; }
  Map map() const;

 private:
  N_Vector vector_;
};

/// SUNDIALS' own lines on stderr are left out: what matters of them stands in the message of the exception.
inline void silence(int, const char*, const char*, char*, void*) {}

/// Powers of a polynomial from its derivatives at its centre: derivative(k, into) returns below 0 beyond its order.
template <class Out, class Derivative>
void take_powers(const Vector& into, Eigen::Index rows, Out& out, Derivative derivative) {
  constexpr int most = 13;  // of Adams' order 12
  out.powers.resize(rows, most);
  double factor = 1;
  int k = 0;
  for (; k < most && derivative(k, into) >= 0; ++k) {
    out.powers.col(k) = factor * into.map().head(rows);
    factor *= out.scale / (k + 1);
  }
  out.powers.conservativeResize(rows, k);
}

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
