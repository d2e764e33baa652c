#pragma once
#include <type_traits>

#include "apps/scenario/declarations.hpp"

namespace subsoil::app {

/// A type declares itself by a member (elements and laws of the libraries) or by a function (scenario structs).
template <class V, class T>
void declare(V& v, T& t) {
  if constexpr (requires { t.describe(v); }) {
    t.describe(v);
  } else {
    describe(v, t);
  }
}

/// Calls use(std::type_identity<T>) for every alternative of a variant or element of a tuple.
template <class List>
struct ForEach;
template <template <class...> class List, class... T>
struct ForEach<List<T...>> {
  template <class Use>
  static void call(Use use) {
    (use(std::type_identity<T>{}), ...);
  }
};

/// Of a machine's elements: every type of their list, which libmbd/elements.hpp or measures.hpp knows.
template <class Family>
struct ForEach<mbd::AnyElement<Family>> : ForEach<typename mbd::ListOf<Family>::type> {};

/// Words of `watch`, in the order of Watch::Kind.
inline constexpr std::array<const char*, 6> watch_words{"column", "driver",     "force",
                                                        "joint",  "soil force", "soil moment"};

}  // namespace subsoil::app
