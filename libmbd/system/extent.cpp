#include "libmbd/system/extent.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "libmbd/elements.hpp"
#include "libmbd/system/bodies_of.hpp"

namespace subsoil::mbd {
namespace {

template <class Force>
concept TiesPoints = requires(const Force& f) {
  f.body_a, f.p_a, f.body_b, f.p_b;
}
&&!(Force::has.touch && Force::has.stick);  // which a contact has, and no stop

struct Box {
  Vec2 low{1e300, 1e300}, high{-1e300, -1e300};
  void include(Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
};

/// Calls take(body a, point on it, body b, point on it) for every force between points.
template <class Take>
void for_ties(const Model& model, const Take& take) {
  for (const auto& f : model.forces)
    visit(
        [&]<class Force>(const Force& force) {
          if constexpr (TiesPoints<Force>) take(force.body_a, force.p_a, force.body_b, force.p_b);
        },
        f.element);
}

/// Bodies that hang together, the ground apart.
class Groups {
 public:
  explicit Groups(const Model& model) : tied_to_(model.bodies.size() + 1) {
    std::iota(tied_to_.begin(), tied_to_.end(), 0);
  }
  int of(int body) {
    auto i = static_cast<std::size_t>(body);
    while (tied_to_[i] != i) i = tied_to_[i] = tied_to_[tied_to_[i]];
    return static_cast<int>(i);
  }
  void tie(int a, int b) {
    if (a != ground && b != ground) tied_to_[static_cast<std::size_t>(of(a))] = static_cast<std::size_t>(of(b));
  }

 private:
  std::vector<std::size_t> tied_to_;
};

}  // namespace

double extent_by_forces(const Model& model) {
  Groups groups(model);
  const auto place = [&](int body, const std::array<double, 2>& p) -> Vec2 {
    if (body == ground) return {p[0], p[1]};
    const auto& pose = model.bodies[static_cast<std::size_t>(body - 1)].pose;
    return BodyState({pose[0], pose[1]}, pose[2], {}, 0).point_in_world(p);
  };
  for_ties(model, [&](int a, const auto&, int b, const auto&) { groups.tie(a, b); });
  std::map<int, Box> boxes;
  for_ties(model, [&](int a, const auto& p_a, int b, const auto& p_b) {
    for (const int body : {a, b}) {
      if (body == ground) continue;
      Box& box = boxes[groups.of(body)];
      box.include(place(a, p_a)), box.include(place(b, p_b)), box.include(place(body, {0, 0}));
    }
  });
  double extent = 0;
  for (const auto& [group, box] : boxes) extent = std::max(extent, length(box.high - box.low));
  return extent;
}

Chains chains_of(const Model& model) {
  Groups groups(model);
  std::vector<int> held(model.joints.size(), ground);  // a body of each joint
  for (std::size_t i = 0; i < held.size(); ++i)
    visit(
        [&](const auto& joint) {
          for (const int body : bodies_of(joint)) {
            groups.tie(held[i], body);
            if (body != ground) held[i] = body;
          }
        },
        model.joints[i].element);
  Chains out;
  for (int body = 0; body <= static_cast<int>(model.bodies.size()); ++body) out.of_bodies.push_back(groups.of(body));
  for (const int body : held) out.of_joints.push_back(body == ground ? -1 : groups.of(body));
  return out;
}

double energy_at_rest(const System& system) {
  constexpr double share = 1e-4;
  const double length = system.length_scale(), speed = share * length;
  const double gravity = std::hypot(system.model().gravity[0], system.model().gravity[1]);
  double energy = 0;
  for (const Body& b : system.model().bodies)
    energy += 0.5 * (b.mass * speed * speed + b.inertia * share * share) + 1e-10 * b.mass * gravity * length;
  return energy;
}

}  // namespace subsoil::mbd
