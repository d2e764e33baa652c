#pragma once

#include <any>
#include <concepts>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace subsoil::mbd {

/// One element of a family (joints, drivers, forces, measures) without its type. Who builds a model includes the
/// headers of the elements that it names; the list of all of them (elements.hpp, measures.hpp) is known to the few
/// sources that go through every type. `Family::takes<E>` states what belongs to it.
template <class Family>
class AnyElement {
 public:
  AnyElement() = default;
  template <class E>
  requires(Family::template takes<E>) AnyElement(E element) : held_(std::move(element)) {}  // implicit, as of a variant

  /// Null when it is of another type.
  template <class E>
  E* get_if() {
    return std::any_cast<E>(&held_);
  }
  template <class E>
  const E* get_if() const {
    return std::any_cast<E>(&held_);
  }
  template <class E>
  const E& get() const {
    return std::any_cast<const E&>(held_);
  }

 private:
  std::any held_;
};

/// The tuple of all types of a family; specialised beside the list.
template <class Family>
struct ListOf;
/// Those of them that scenarios name; specialised where a user's program may bring others.
template <class Family>
struct DeclaredOf : ListOf<Family> {};

namespace detail {
template <class List, std::size_t i = 0, class Visitor, class Any>
decltype(auto) visit_from(Visitor&& visitor, Any& any) {
  if constexpr (i + 1 == std::tuple_size_v<List>) {
    auto* const element = any.template get_if<std::tuple_element_t<i, List>>();
    if (element == nullptr)
      throw std::logic_error(
          "an element that is in no list of its family (elements.hpp); a joint or force of your own goes into OwnJoint "
          "or "
          "OwnForce");
    return visitor(*element);
  } else {
    if (auto* const element = any.template get_if<std::tuple_element_t<i, List>>()) return visitor(*element);
    return visit_from<List, i + 1>(visitor, any);
  }
}
}  // namespace detail

/// visitor(element) with the element's own type, as std::visit does. Needs the family's list.
template <class Visitor, class Family>
decltype(auto) visit(Visitor&& visitor, AnyElement<Family>& any) {
  return detail::visit_from<typename ListOf<Family>::type>(visitor, any);
}
template <class Visitor, class Family>
decltype(auto) visit(Visitor&& visitor, const AnyElement<Family>& any) {
  return detail::visit_from<typename ListOf<Family>::type>(visitor, any);
}

}  // namespace subsoil::mbd
