#include "libmbd/forces/ground_element.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

void add_followers(Model& model) {
  for (std::size_t i = 0; i < model.forces.size(); ++i) {
    const std::string name = model.forces[i].name;
    auto* element = model.forces[i].element.get_if<GroundElement>();
    if (element == nullptr || element->body <= ground || element->follower >= 0) continue;
    if (element->body > static_cast<int>(model.bodies.size())) continue;  // refused with the other elements
    const Body& striker = model.bodies[static_cast<std::size_t>(element->body - 1)];
    if (std::isnan(element->mass)) element->mass = striker.mass;
    if (!(element->share > 0)) continue;
    const BodyState state({striker.pose[0], striker.pose[1]}, striker.pose[2], {}, 0);
    const double x = state.r.x + state.vector_in_world(element->point).x, mass = element->share * element->mass;
    element->weight = -mass * model.gravity[1];
    // It never turns: its inertia is there because a body has one.
    element->follower =
        model.add({.name = name + " follower", .mass = mass, .inertia = mass, .pose = {x, element->surface, 0}});
    Translational guide;
    guide.body_a = ground, guide.body_b = element->follower;
    guide.p_a = {x, element->surface}, guide.angle_a = std::acos(0.0);
    model.add(name + " guide", guide);
  }
}

}  // namespace subsoil::mbd
