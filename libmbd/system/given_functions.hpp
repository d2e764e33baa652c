#pragma once

namespace subsoil::mbd {

/// Calls visit(f) for each function of time that an element or a controller is given: forces, currents, flows, wind,
/// motions, set points. A new one has its line here, or the test of Inputs fails.
template <class Element, class Visit>
void visit_given_functions(const Element& e, Visit&& visit) {
  if constexpr (requires { e.fx; }) visit(e.fx), visit(e.fy), visit(e.moment);
  if constexpr (requires { e.actuator; }) visit(e.actuator);
  if constexpr (requires { e.voltage; }) visit(e.voltage);
  if constexpr (requires { e.curve; }) visit(e.share);
  if constexpr (requires { e.valve; }) visit(e.valve), visit(e.flow);
  if constexpr (requires { e.wind_x; }) visit(e.wind_x), visit(e.wind_y);
  if constexpr (requires { e.motion; })
    visit(e.motion.position), visit(e.motion.velocity), visit(e.motion.acceleration);
  if constexpr (requires { Element::has.functions; })
    if constexpr (Element::has.functions) visit(e.set_point), visit(e.bias);
}

}  // namespace subsoil::mbd
