#include "libsim/scenario/sections/beams.hpp"

#include <algorithm>
#include <cmath>

#include "libmbd/measures/beam.hpp"
#include "libsim/scenario/sections/machine.hpp"

namespace subsoil::sim {

void BeamSection::describe(Fields& v) {
  Beam::describe(v);
  v.optional_reference("material", material, Family::material,
                       "of its surface in soil: every node carries a box (of a round section a cylinder) as long as an "
                       "element; left out: it meets no soil");
}

bool BeamSection::lacks_numbers() const {
  const auto out_of = [](double value) { return !std::isfinite(value); };
  return points.size() < 2 || elements < 1 || elements > 400 || out_of(young) || out_of(density) ||
         out_of(mbd::values_of(section, poisson).area) || out_of(mbd::values_of(section, poisson).second_moment);
}

namespace {

bool can_be_divided(const BeamSection& beam) {
  if (beam.lacks_numbers()) return false;
  try {
    beam.check();
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
}

/// The stretch of the beam that a node stands for, in the node's axes.
struct Stretch {
  double from, to;
};
Stretch stretch_of(const mbd::DividedBeam& divided, std::size_t node) {
  const double half = divided.elements.front().length / 2;
  return {node == 0 ? 0 : -half, node + 1 == divided.nodes.size() ? 0 : half};
}

BodySection node_body(const mbd::DividedBeam& divided, std::size_t i) {
  const mbd::Body& node = divided.nodes[i];
  const auto [from, to] = stretch_of(divided, i);
  const double edge = divided.section.edge;
  BodySection body;
  body.name = node.name, body.mass = node.mass, body.inertia = node.inertia;
  body.at = {node.pose[0], node.pose[1]}, body.angle = node.pose[2];
  body.velocity = {node.velocity[0], node.velocity[1]}, body.spin = node.velocity[2];
  body.outline = {{from, -edge}, {to, -edge}, {to, edge}, {from, edge}};
  return body;
}

/// What of a section's outside meets the soil over a length.
Shape shape_of(const mbd::SectionForm& section, double length) {
  if (const auto* round = std::get_if<mbd::CircleSection>(&section))
    return CylinderShape{.radius = round->diameter / 2, .length = length, .axis = {1, 0, 0}};
  if (const auto* tube = std::get_if<mbd::TubeSection>(&section))
    return CylinderShape{.radius = tube->size[0] / 2, .length = length, .axis = {1, 0, 0}};
  if (const auto* hollow = std::get_if<mbd::HollowRectangleSection>(&section))
    return BoxShape{.size = {length, hollow->size[0], hollow->size[1]}};
  const auto* solid = std::get_if<mbd::RectangleSection>(&section);
  return BoxShape{.size = {length, solid->size[0], solid->size[1]}};
}

void add_surfaces(MachineSection& machine, const BeamSection& beam, const mbd::DividedBeam& divided) {
  if (beam.material.empty() || std::holds_alternative<mbd::GivenSection>(beam.section)) return;
  for (std::size_t i = 0; i < divided.nodes.size(); ++i) {
    const auto [from, to] = stretch_of(divided, i);
    Surface surface;
    surface.name = divided.nodes[i].name + " surface", surface.body = divided.nodes[i].name;
    surface.material = beam.material;
    surface.shape = shape_of(beam.section, to - from);
    surface.at = {(from + to) / 2, 0, 0};
    machine.surfaces.push_back(std::move(surface));
  }
}

}  // namespace

void add_beam_nodes(MachineSection& machine) {
  for (BeamSection& beam : machine.beams) {
    beam.first_node = static_cast<int>(machine.bodies.size()) + 1;
    if (can_be_divided(beam)) {
      const mbd::DividedBeam divided = mbd::divide(beam);
      for (std::size_t i = 0; i < divided.nodes.size(); ++i) machine.bodies.push_back(node_body(divided, i));
    } else {  // their names are known, so that who names them is at no fault
      for (long i = 0; i <= std::clamp(beam.elements, 1L, 400L); ++i) {
        BodySection body;
        body.name = beam.node_name(i), body.at = {0, 0};
        machine.bodies.push_back(std::move(body));
      }
    }
  }
}

void add_beam_elements(MachineSection& machine) {
  for (const BeamSection& beam : machine.beams) {
    if (!can_be_divided(beam)) continue;
    const mbd::DividedBeam divided = mbd::divide(beam);
    for (std::size_t i = 0; i < divided.elements.size(); ++i) {
      mbd::BeamElement element = divided.elements[i];
      element.body_a += beam.first_node, element.body_b += beam.first_node;
      machine.forces.push_back({beam.element_name(static_cast<long>(i) + 1), element});
    }
    machine.measures.push_back({beam.name, mbd::BeamMeasure{.beam = beam.name}});
    add_surfaces(machine, beam, divided);
  }
}

void take_beams_out(MachineSection& machine) {
  std::size_t nodes = 0, elements = 0, measures = 0, surfaces = 0;
  for (const BeamSection& beam : machine.beams) {
    nodes += static_cast<std::size_t>(beam.elements) + 1, elements += static_cast<std::size_t>(beam.elements);
    ++measures;
    if (!beam.material.empty()) surfaces += static_cast<std::size_t>(beam.elements) + 1;
  }
  machine.bodies.resize(machine.bodies.size() - nodes);
  machine.forces.resize(machine.forces.size() - elements);
  machine.measures.resize(machine.measures.size() - measures);
  machine.surfaces.resize(machine.surfaces.size() - surfaces);
}

bool is_beam_node(const std::optional<MachineSection>& machine, const std::string& body) {
  if (!machine) return false;
  const auto names_it = [&](const BeamSection& beam) {
    for (long i = 0; i <= beam.elements; ++i)
      if (beam.node_name(i) == body) return true;
    return false;
  };
  return std::any_of(machine->beams.begin(), machine->beams.end(), names_it);
}

}  // namespace subsoil::sim
