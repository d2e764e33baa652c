#pragma once
#include <map>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "libmbd/controllers.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/system/system.hpp"

/// What the files of System share: its elements by type, and how a mistake in a model is named.
namespace subsoil::mbd {

// Elements of one type side by side: a loop over each list inlines the element's law, where a call without its type
// costs a jump per element that is of the order of the law itself.
struct System::Elements {
  /// Where an element stands: its number (first row of a constraint, place in the list of a force) and its bodies.
  template <class Element>
  struct Placed {
    Element* element;
    int number;
    int a = ground, b = ground, c = ground;
  };
  template <class Tuple>
  struct Lists;
  template <class... Types>
  struct Lists<std::tuple<Types...>> {
    using type = std::tuple<std::vector<Placed<Types>>...>;
  };
  Lists<AllJoints>::type joints;
  Lists<Drivers>::type drivers;
  Lists<AllForces>::type forces;

  /// What of a constraint is asked for: an element computes no more, since its evaluate() is inlined.
  enum class Part { all, position, gamma };
  template <Part part, class Element>
  static void evaluate(const System& system, const Placed<Element>& placed, SparseConstraints& out);
};

/// Does something with every element of the lists, of all types in their order.
template <class Lists, class Action>
void for_each_placed(const Lists& lists, Action action) {
  std::apply(
      [&](const auto&... list) {
        const auto all = [&](const auto& elements) {
          for (const auto& placed : elements) action(placed);
        };
        (all(list), ...);
      },
      lists);
}

/// `text` follows the name: "joint 'slot'" + ": ...".
[[noreturn]] inline void refuse_model(const PartName& part, const std::string& text, const std::string& key = {}) {
  throw ModelFault(part, part.text() + text, key);
}

/// Tells whose fault it is: "joint 'slot': ..."
template <class Action>
void naming(const PartName& part, Action action) {
  try {
    action();
  } catch (const KeyFault& fault) {
    refuse_model(part, std::string(": ") + fault.what(), fault.key);
  } catch (const std::invalid_argument& error) {
    refuse_model(part, std::string(": ") + error.what());
  }
}

/// What a latch decides of a joint.
inline std::array<double, 3> latched_of(const AnyJoint& any) {
  return visit(
      []<class Joint>(const Joint& joint) -> std::array<double, 3> {
        if constexpr (Joint::has.latch) return joint.latched();
        return {};
      },
      any);
}
inline void set_latched_of(AnyJoint& any, const std::array<double, 3>& m) {
  visit(
      [&]<class Joint>(Joint& joint) {
        if constexpr (Joint::has.latch) joint.set_latched(m);
      },
      any);
}

}  // namespace subsoil::mbd
