#pragma once

#include <algorithm>
#include <vector>

#include "libmbd/element/contact_law.hpp"
#include "libmbd/element/limits.hpp"

namespace subsoil::mbd {

/// `has` of contacts with ContactMemory, which have one gap or a list of gaps.
constexpr ForceMembers contact_members(bool list_of_gaps) {
  return {.check = true,
          .initialise_from_pose = true,
          .gap = !list_of_gaps,
          .gaps = list_of_gaps,
          .stick = true,
          .touch = true,
          .trace = true,
          .states = true};
}

/// What contacts with ContactLaw have in common: at each place that may touch (numbered as the gaps), what the contact
/// has begun with, and whether it sticks. The way s of a place that sticks is a state, s' = slip, so that surfaces of
/// any shape may roll and slide on each other. A contact C holds `touches`, one per place, and first_state, names this
/// its Memory, and provides
///   law, gap_count(), place(scene, k): the bodies and the point of place k
template <class C>
class ContactMemory {
 public:
  explicit ContactMemory(C& contact) : contact_(contact) {}

  bool remembers() const { return contact_.law.remembers(); }
  std::size_t stick_count() const { return contact_.law.can_stick() ? contact_.gap_count() : 0; }

  /// The force at a place, with its friction, on both bodies.
  ForcePower push(const Scene& scene, std::size_t k, const ContactPlace& p, Loads& loads, ForceValues& values) const {
    return contact_.law.push(scene, p, touched(k), stick_count() > 0 ? way(scene, k) : 0, loads, values);
  }

  // --- states: the way of each place that can stick ---
  std::size_t state_count() const { return stick_count(); }
  std::vector<double> start_states(const Scene&) const { return std::vector<double>(state_count(), 0.0); }
  std::vector<double> state_scales() const { return std::vector<double>(state_count(), 1.0); }  // m, as a pose
  std::vector<double> state_rates(const Scene& scene) const {
    std::vector<double> out(state_count(), 0.0);
    for (std::size_t k = 0; k < out.size(); ++k)
      if (holds(k)) out[k] = slip(scene, k);
    return out;
  }

  // --- events ---
  Changeover touch(const Scene& scene, std::size_t k, bool closes) {
    if (!remembers()) return {};
    Touch& t = at(k);
    const double strain = holds(k) ? t.surfaces.stored(contact_.law.stick_stiffness, way(scene, k)) : 0;
    if (closes)
      begin(scene, k);
    else
      t = {};
    return {strain, true};
  }
  bool follow_touches(const Scene& scene, double close, bool from_here) {
    if (!contact_.law.can_stick()) return false;
    if (from_here) contact_.touches.assign(contact_.gap_count(), Touch{});
    bool changed = false;
    for (std::size_t k = 0; k < contact_.touches.size(); ++k) {
      const bool near = contact_.place(scene, k).point.gap < close;
      if (near == contact_.touches[k].closed) continue;
      changed = true;
      if (near)
        begin(scene, k);
      else
        contact_.touches[k] = {};
    }
    return changed;
  }
  bool sticks(std::size_t k) const { return holds(k); }
  /// Whether a place at that gap exerts a force: one that sticks does so from the instant at which it closes.
  bool acts(std::size_t k, double gap) const { return gap < 0 || holds(k); }
  double hold(const Scene& scene, std::size_t k) const {
    if (k >= contact_.touches.size() || !contact_.touches[k].closed) return 1;
    const ContactPlace p = contact_.place(scene, k);
    return contact_.touches[k].surfaces.hold(
        contact_.law.stick_stiffness, way(scene, k), contact_.law.slip(scene, p),
        contact_.law.friction * contact_.law.push(scene, p, contact_.touches[k]).force);
  }
  Changeover pass_event(const Scene& scene, std::size_t k) {
    return at(k).surfaces.pass_event(contact_.law.stick_stiffness, way(scene, k), slip(scene, k));
  }
  bool creeps() const { return !contact_.law.can_stick() && contact_.law.friction > 0; }
  double held(const Scene& scene, std::size_t k) const {
    return contact_.touches[k].surfaces.spring(contact_.law.stick_stiffness, way(scene, k), 0);
  }
  double grip_limit(const Scene& scene, std::size_t k) const {
    return contact_.law.friction * contact_.law.push(scene, contact_.place(scene, k), contact_.touches[k]).force;
  }
  double grip(const Scene& scene, std::size_t k, double force, double mass) {
    return at(k).surfaces.grip(contact_.law.stick_stiffness, way(scene, k), slip(scene, k), force, mass,
                               contact_.law.stick_damping);
  }
  void damp(std::size_t k, double mass) {
    at(k).surfaces.damp(contact_.law.stick_stiffness, mass, contact_.law.stick_damping);
  }
  void slide(std::size_t k, int sense) { at(k).surfaces.slide(sense); }
  int sense(std::size_t k) const { return touched(k).surfaces.sliding; }
  double slip_speed(const Scene& scene, std::size_t k) const { return slip(scene, k); }
  /// By central differences along the motion: the point and its tangent move on surfaces of any shape. They err by
  /// dt^2 times the third derivative of the slip, and by its rounding over dt: dt is 1e-6 s, or 1e-5 of the time in
  /// which a body turns by a radian or moves by `length`, if that is shorter.
  double slip_acceleration(const Scene& scene, std::size_t k, std::span<const double> accelerations,
                           double length) const {
    double rate = 0;
    const ContactPlace at = contact_.place(scene, k);
    for (const int body : {at.body_a, at.body_b}) {
      if (body < 1) continue;
      const BodyState& b = scene.bodies[static_cast<std::size_t>(body)];
      const double* const a = accelerations.data() + 3 * (body - 1);
      rate = std::max({rate, std::abs(b.omega), std::sqrt(std::abs(a[2])), std::hypot(b.v.x, b.v.y) / length,
                       std::sqrt(std::hypot(a[0], a[1]) / length)});
    }
    const double dt = rate > 10 ? 1e-5 / rate : 1e-6;
    std::vector<BodyState> moved(scene.bodies.begin(), scene.bodies.end());
    const auto slip_after = [&](double h) {
      for (std::size_t i = 1; i < moved.size(); ++i) {
        const BodyState& b = scene.bodies[i];
        const double* const a = accelerations.data() + 3 * (i - 1);
        const Vec2 acceleration{a[0], a[1]};
        moved[i] = {b.r + h * b.v + (0.5 * h * h) * acceleration, b.angle + h * b.omega + 0.5 * h * h * a[2],
                    b.v + h * acceleration, b.omega + h * a[2]};
      }
      Scene then = scene;
      then.bodies = moved, then.t += h;
      return slip(then, k);
    };
    return (slip_after(dt) - slip_after(-dt)) / (2 * dt);
  }

  // --- memory ---
  void initialise_from_pose(const Scene& scene) { begin_trace(scene); }
  /// Places that overlap have just touched.
  void begin_trace(const Scene& scene) {
    contact_.touches.assign(remembers() ? contact_.gap_count() : 0, Touch{});
    for (std::size_t k = 0; k < contact_.touches.size(); ++k)
      if (contact_.place(scene, k).point.gap < 0) begin(scene, k);
  }
  std::vector<double> memory() const {
    std::vector<double> out;
    for (const Touch& t : contact_.touches) {
      out.push_back(t.closed), out.push_back(t.damping);
      for (const double m : t.surfaces.memory()) out.push_back(m);
    }
    return out;
  }
  void set_memory(const std::vector<double>& m) {
    auto next = m.begin();
    for (Touch& t : contact_.touches) {
      t.closed = *next++ != 0, t.damping = *next++;
      std::array<double, 3> surfaces{};
      for (double& value : surfaces) value = *next++;
      t.surfaces.set_memory(surfaces);
    }
  }

 private:
  const Touch& touched(std::size_t k) const {
    static const Touch none{};
    return k < contact_.touches.size() ? contact_.touches[k] : none;
  }
  Touch& at(std::size_t k) {
    if (contact_.touches.size() < contact_.gap_count()) contact_.touches.resize(contact_.gap_count());
    return contact_.touches[k];
  }
  bool holds(std::size_t k) const {
    return contact_.law.can_stick() && k < contact_.touches.size() && contact_.touches[k].closed &&
           contact_.touches[k].surfaces.sticks();
  }
  double way(const Scene& scene, std::size_t k) const { return scene.states[contact_.first_state + k]; }
  double slip(const Scene& scene, std::size_t k) const { return contact_.law.slip(scene, contact_.place(scene, k)); }
  void begin(const Scene& scene, std::size_t k) {
    const ContactPlace p = contact_.place(scene, k);
    Touch& t = at(k);
    t.closed = true, t.damping = contact_.law.normal.damping_from(contact_.law.approach(scene, p));
    if (contact_.law.can_stick())
      t.surfaces.begin(way(scene, k), contact_.law.slip(scene, p), contact_.law.stick_damping);
  }

  C& contact_;
};

/// The same of stops, which have Limits and no friction: S holds impact_damping, the b of the impact (negative: none
/// yet), and provides limits and rate(scene).
template <class S>
class StopMemory {
 public:
  explicit StopMemory(S& stop) : stop_(stop) {}

  bool remembers() const { return stop_.limits.law.gives_restitution(); }
  Changeover touch(const Scene& scene, std::size_t, bool closes) {
    if (closes && remembers()) stop_.impact_damping = stop_.limits.law.damping_from(std::abs(stop_.rate(scene)));
    return {};
  }
  void initialise_from_pose(const Scene& scene) { begin_trace(scene); }
  void begin_trace(const Scene& scene) { touch(scene, 0, true); }
  std::vector<double> memory() const { return std::vector<double>(remembers(), stop_.impact_damping); }
  void set_memory(const std::vector<double>& m) {
    if (!m.empty()) stop_.impact_damping = m[0];
  }
  double damping() const { return stop_.impact_damping < 0 ? stop_.limits.law.damping_from(0) : stop_.impact_damping; }

 private:
  S& stop_;
};

}  // namespace subsoil::mbd
