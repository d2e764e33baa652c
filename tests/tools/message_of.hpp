#pragma once

#include <exception>
#include <string>

namespace subsoil::test {

/// What the exception of type E says that a call throws, or "accepted" when it throws nothing. Others pass through.
template <class E = std::exception, class Call>
std::string message_of(Call call) {
  try {
    call();
  } catch (const E& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace subsoil::test
