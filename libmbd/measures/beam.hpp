#pragma once

#include <algorithm>
#include <stdexcept>

#include "libmbd/forces/beam_element.hpp"
#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

/// Of a beam (libmbd/system/beam.hpp), by the names of its nodes and elements:
///   deflection x, y   of its end, in the axes of its start: A_start^T (r_end - r_start), less that of the start pose
///   turn              of its end against its start, less that of the start pose                               (rad)
///   moment            the maximum bending moment of all sections at nodes, with its sign                      (N m)
///   axial force       the maximum of all elements, with its sign, tension positive                            (N)
///   stress, stress at the maximum of all sections (Pa), and where: its place along the beam                   (m)
///   strain energy     of all elements                                                                         (J)
struct BeamMeasure {
  static constexpr MeasureMembers has{.attach = true, .of_solution = true};
  std::string beam{};
  std::vector<std::size_t> elements{};  ///< by their place among the forces
  int start = -1, end = -1;
  Vec2 rest{};
  double rest_turn = 0;

  template <class V>
  void describe(V& v) {
    v.card("beam", "deflection, moments, stress and strain energy of a beam; each beam has these columns by itself");
    v.text("beam", beam, "the beam");
  }
  std::vector<MeasureColumn> columns() const {
    return {{"deflection x", "m"}, {"deflection y", "m"}, {"turn", "rad"},    {"moment", "N m"},
            {"axial force", "N"},  {"stress", "Pa"},      {"stress at", "m"}, {"strain energy", "J"}};
  }
  void attach(const System& system) {
    const Model& model = system.model();
    for (std::size_t i = 0; i < model.forces.size(); ++i)
      if (model.forces[i].name.starts_with(beam + " element ") && model.forces[i].element.get_if<BeamElement>())
        elements.push_back(i);
    if (elements.empty()) throw std::invalid_argument("there is no beam '" + beam + "'");
    start = element(system, 0).body_a, end = element(system, elements.size() - 1).body_b;
    const auto state = [&](int body) {
      const auto& pose = model.bodies[static_cast<std::size_t>(body - 1)].pose;
      return BodyState({pose[0], pose[1]}, pose[2], {}, 0);
    };
    rest = seen(state(start), state(end)), rest_turn = state(end).angle - state(start).angle;
  }
  void evaluate(const Observation& o, std::span<double> out) const {
    const Vec2 deflection = seen(o.system.body(start), o.system.body(end)) - rest;
    out[0] = deflection.x, out[1] = deflection.y;
    out[2] = o.system.body(end).angle - o.system.body(start).angle - rest_turn;
    std::fill(out.begin() + 3, out.end(), 0.0);
    const auto larger = [](double& most, double value) {
      if (std::abs(value) > std::abs(most)) most = value;
    };
    double place = 0;
    for (std::size_t k = 0; k < elements.size(); ++k) {
      const BeamElement& e = element(o.system, k);
      const auto& [axial, shear, moment_a, moment_b, stress, none] = o.system.values()[elements[k]];
      larger(out[3], moment_a), larger(out[3], moment_b), larger(out[4], axial);
      if (stress > out[5]) out[5] = stress, out[6] = place + (std::abs(moment_b) > std::abs(moment_a) ? e.length : 0);
      out[7] += o.system.powers()[elements[k]].stored;
      place += e.length;
    }
  }

 private:
  const BeamElement& element(const System& system, std::size_t k) const {
    return system.model().forces[elements[k]].element.get<BeamElement>();
  }
  static Vec2 seen(const BodyState& from, const BodyState& of) {
    const Vec2 d = of.r - from.r;
    return {from.c * d.x + from.s * d.y, from.c * d.y - from.s * d.x};
  }
};

}  // namespace subsoil::mbd
