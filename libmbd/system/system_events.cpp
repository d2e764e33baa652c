#include <algorithm>
#include <cmath>

#include "libmbd/system/measure.hpp"
#include "libmbd/system/system_elements.hpp"
#include "libmbd/system/wrench.hpp"

/// Events of joints: what opens and closes them, and when.
namespace subsoil::mbd {

void System::attach_events() {
  open_.assign(model_.joints.size(), 0);
  passed_.assign(model_.events.size(), 0);
  std::vector<char> opens(open_.size(), 0), closes(open_.size(), 0);
  for (auto& e : model_.events) {
    const PartName what{PartName::Kind::event, e.name};
    naming(what, [&] { e.element.check(); });
    std::string known;
    std::size_t i = 0;
    for (; i < model_.joints.size() && model_.joints[i].name != e.element.joint; ++i)
      known += (i ? ", " : "") + model_.joints[i].name;
    if (i == model_.joints.size())
      refuse_model(what, ": no joint '" + e.element.joint + "'; there are " + (known.empty() ? "none" : known));
    e.element.index = i;
    (e.element.does == JointEvent::Does::opens ? opens : closes)[i] = 1;
    has_instants_ = has_instants_ || e.element.timed();
    const bool latches = visit([]<class Joint>(const Joint&) { return Joint::has.latch; }, model_.joints[i].element);
    if (closes[i] && !latches)
      refuse_model(
          what, ": joint '" + e.element.joint + "' cannot close on the way; a revolute, fixed or distance joint can");
  }
  for (std::size_t i = 0; i < open_.size(); ++i) open_[i] = closes[i] && !opens[i];
  for (const auto& e : model_.events)
    if (e.element.starts != JointEvent::Starts::by_events)
      open_[e.element.index] = e.element.starts == JointEvent::Starts::open;
  open_at_start_ = open_;
  for (const auto& f : model_.forces)
    if (const auto* friction = f.element.get_if<JointFriction>())
      for (std::size_t i = 0; i < model_.joints.size(); ++i)
        if (model_.joints[i].name == friction->joint && may_open(i))
          refuse_model({PartName::Kind::force, f.name},
                       ": joint '" + friction->joint +
                           "' may open, and friction would act in it still; take the friction or the event away");
}

bool System::may_open(std::size_t joint) const {
  return std::any_of(model_.events.begin(), model_.events.end(),
                     [&](const auto& e) { return e.element.index == joint; });
}

int System::open_rows() const {
  int rows = 0;
  for (std::size_t i = 0; i < open_.size(); ++i)
    if (open_[i]) rows += (i + 1 < joint_row_.size() ? joint_row_[i + 1] : joints_end_) - joint_row_[i];
  return rows;
}

void System::begin_joints() {
  open_ = open_at_start_;
  std::fill(passed_.begin(), passed_.end(), 0);
  for (const auto& e : model_.events)
    set_latched_of(model_.joints[e.element.index].element, given_latched_[e.element.index]);
}

double System::event_gap(std::size_t event, const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda) const {
  const JointEvent& e = model_.events[event].element;
  const bool opens = e.does == JointEvent::Does::opens;
  if (e.timed() || opens == (open_[e.index] != 0)) return 1;
  if (!std::isnan(e.reaction_above)) {
    const int first = visit([](const auto& joint) { return joint.body_a; }, model_.joints[e.index].element);
    return e.reaction_above - length(joint_wrench(*this, e.index, lambda, first).force);
  }
  const double value = e.input->value(Observation{*this, acceleration, lambda});
  return std::isnan(e.above) ? value - e.below : e.above - value;
}

void System::switch_joint(std::size_t event) {
  const JointEvent& e = model_.events[event].element;
  passed_[event] = 1;
  open_[e.index] = e.does == JointEvent::Does::opens;
  if (open_[e.index]) return;
  visit(
      [&]<class Joint>(Joint& joint) {
        if constexpr (Joint::has.latch) joint.latch(body(joint.body_a), body(joint.body_b));
      },
      model_.joints[e.index].element);
}

std::size_t System::due_event(double close) const {
  for (std::size_t i = 0; i < model_.events.size(); ++i) {
    const JointEvent& e = model_.events[i].element;
    if (e.timed() && !passed_[i] && e.at <= t_ + close) return i;
  }
  return model_.events.size();
}

Changeover System::pass_event(std::size_t force, std::size_t place) {
  return visit(
      [&]<class Force>(Force& f) {
        if constexpr (Force::has.stick) return remembering(f).pass_event(scene(), place);
        return Changeover{};
      },
      model_.forces[force].element);
}

Changeover System::touch(std::size_t force, std::size_t place, bool closes) {
  return visit(
      [&]<class Force>(Force& f) {
        if constexpr (Force::has.touch) return remembering(f).touch(scene(), place, closes);
        return Changeover{};
      },
      model_.forces[force].element);
}

bool System::follow_touches(double close, bool from_here) {
  bool changed = false;
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    auto&& memory = remembering(*placed.element);
    if constexpr (requires { memory.follow_touches(scene(), close, from_here); })
      changed = memory.follow_touches(scene(), close, from_here) || changed;
  });
  return changed;
}

std::vector<std::string> System::creeping() const {
  std::vector<std::string> names;
  for (const auto& f : model_.forces)
    visit(
        [&]<class Force>(const Force& force) {
          if constexpr (Force::has.stick)
            if (remembering(force).creeps()) names.push_back(f.name);
        },
        f.element);
  return names;
}

System::Grips System::grips() const {
  Grips out;
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.stick || Force::has.touch)
      if (remembering(*placed.element).remembers())
        for (const double value : remembering(*placed.element).memory()) out.push_back(value);
  });
  return out;
}

void System::set_grips(const Grips& grips) {
  auto next = grips.begin();
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.stick || Force::has.touch)
      if (remembering(*placed.element).remembers()) {
        auto memory = remembering(*placed.element).memory();
        for (auto& value : memory) value = *next++;
        remembering(*placed.element).set_memory(memory);
      }
  });
}

int System::sense(std::size_t force, std::size_t place) const {
  return visit(
      [&]<class Force>(const Force& f) {
        if constexpr (Force::has.stick) return remembering(f).sense(place);
        return 0;
      },
      model_.forces[force].element);
}

namespace {
// The sense in which surfaces that nothing stops slide on: as they move soon after this instant; 0: they rest.
template <class Force>
int led_on(const System& system, const Force& f, std::size_t place, const GripMotion& motion) {
  constexpr double visible = 1e-11;                // m/s, beside the rounding of a speed
  constexpr double least = 1e-5, farthest = 1e-3;  // s
  const double now = std::abs(f.slip_speed(system.scene(), place));
  for (double after = least; after < 2 * farthest && motion.look_ahead(after); after *= 10) {
    const double then = f.slip_speed(system.scene(), place);
    if (std::abs(then) > std::max(visible, 2 * now)) return then > 0 ? 1 : -1;
  }
  return 0;
}

// s'' with that force of the grip, in which it is linear but for what it does to the friction of other places.
template <class Force>
double slip_with(const System& system, Force& f, std::size_t place, const GripMotion& motion, double force) {
  f.grip(system.scene(), place, force, 0);
  const Eigen::VectorXd& solved = motion.accelerate();
  return f.slip_acceleration(system.scene(), place, {solved.data(), static_cast<std::size_t>(solved.size())},
                             system.length_scale());
}

// The inertia against what friction does along s, the same to both sides: friction elsewhere may depend on the sense.
template <class Slip>
double inertia_against(double force, const Slip& slip) {
  const double back = slip(-force);
  return 2 * force / (slip(force) - back);
}

// A secant, repeated.
template <class Force>
double grip_place(const System& system, Force&& f, std::size_t place, const GripMotion& motion) {
  if (!f.sticks(place)) return 0;
  const double kept = system.keeps_grips() ? f.held(system.scene(), place) : 0;
  const auto slip = [&](double with) { return slip_with(system, f, place, motion, with); };
  const auto slide = [&](int sense) {
    f.slide(place, sense);
    motion.accelerate();
    return 0.0;
  };
  const double free = slip(0), limit = f.grip_limit(system.scene(), place);
  constexpr double rounding = 1e-8;  // of a slip's acceleration beside those of the bodies
  const double fastest = motion.accelerate().cwiseAbs().maxCoeff();
  if (!(limit > 0) && !system.keeps_grips() && std::abs(free) > rounding * fastest) return slide(free > 0 ? 1 : -1);
  double held = limit > 0 ? limit : 1, rest = slip(held), mass = held / (rest - free);
  // What friction does to s'' of surfaces that are led, by a driver or a cam, is rounding of either sign.
  const double size = std::max({std::abs(free), fastest, held / system.mass().maxCoeff()});
  if (!system.keeps_grips() && !(std::abs(rest - free) > rounding * size)) {
    if (const int sense = led_on(system, f, place, motion); sense != 0) return slide(sense);
    slip(held);
  }
  if (!(mass > 0 && std::isfinite(mass))) {  // its surfaces cannot move, or are not held by forces
    const double stored = f.grip(system.scene(), place, kept, 0);
    motion.accelerate();
    return stored;
  }
  if (system.keeps_grips()) {
    held = kept;
  } else {
    for (int turn = 0; turn < 3; ++turn) held -= mass * rest, rest = slip(held);
  }
  for (int turn = 0; turn < 3; ++turn) {  // what presses the surfaces may depend on the grip
    const double most = StickSlip::most_of_grip * f.grip_limit(system.scene(), place);
    held = std::clamp(held, -most, most), slip(held);
  }
  const double inertia = inertia_against(limit > 0 ? limit : 1, slip);
  slip(held);
  return f.grip(system.scene(), place, held, inertia > 0 && std::isfinite(inertia) ? inertia : mass);
}

template <class Force>
void damp_place(const System& system, Force&& f, std::size_t place, const GripMotion& motion) {
  if (!f.sticks(place)) return;
  const auto memory = f.memory();
  const double limit = f.grip_limit(system.scene(), place), force = limit > 0 ? limit : 1;
  const double mass = inertia_against(force, [&](double with) { return slip_with(system, f, place, motion, with); });
  f.set_memory(memory);
  if (mass > 0 && std::isfinite(mass)) f.damp(place, mass);
  motion.accelerate();
}
template <class Force>
double share_places(const System& system, Force&& f, std::span<const std::size_t> places, const GripMotion& motion) {
  const auto memory = f.memory();
  std::vector<double> held, limits;
  double sum = 0, most = 0;
  for (const std::size_t p : places) {
    held.push_back(f.held(system.scene(), p)), limits.push_back(f.grip_limit(system.scene(), p));
    sum += held.back(), most += limits.back();
  }
  if (!(most > 0)) return 0;
  // The largest s'' of these places, with that share of what they hold by their limits.
  double stored = 0;
  const auto moved = [&](const auto& force) {
    stored = 0;
    for (std::size_t k = 0; k < places.size(); ++k) stored += f.grip(system.scene(), places[k], force(k), 0);
    const Eigen::VectorXd& solved = motion.accelerate();
    double largest = 0;
    for (const std::size_t p : places)
      largest = std::max(largest, std::abs(f.slip_acceleration(system.scene(), p,
                                                               {solved.data(), static_cast<std::size_t>(solved.size())},
                                                               system.length_scale())));
    return largest;
  };
  const auto as_held = [&](std::size_t k) { return held[k]; };
  const auto shared = [&](std::size_t k) { return sum * limits[k] / most; };
  constexpr double rounding = 1e-6;  // of what a limit does
  const double before = moved(as_held), before_stored = stored, scale = most / system.mass().maxCoeff();
  if (moved(shared) > 2 * before + rounding * scale) {
    f.set_memory(memory);
    motion.accelerate();
    return 0;
  }
  const double after = stored;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const std::size_t p = places[k];
    const double mass = inertia_against(limits[k] > 0 ? limits[k] : 1,
                                        [&](double with) { return slip_with(system, f, p, motion, with); });
    f.grip(system.scene(), p, shared(k), mass > 0 && std::isfinite(mass) ? mass : 0);
  }
  motion.accelerate();
  return after - before_stored;
}
}  // namespace

double System::share_grips(std::size_t force, std::span<const std::size_t> places, const GripMotion& motion) {
  return visit(
      [&]<class Force>(Force& f) {
        if constexpr (Force::has.stick) return share_places(*this, remembering(f), places, motion);
        return 0.0;
      },
      model_.forces[force].element);
}

void System::damp(std::size_t force, std::size_t place, const GripMotion& motion) {
  visit(
      [&]<class Force>(Force& f) {
        if constexpr (Force::has.stick) damp_place(*this, remembering(f), place, motion);
      },
      model_.forces[force].element);
}

double System::grip(std::size_t force, std::size_t place, const GripMotion& motion) {
  return visit(
      [&]<class Force>(Force& f) {
        if constexpr (Force::has.stick) return grip_place(*this, remembering(f), place, motion);
        return 0.0;
      },
      model_.forces[force].element);
}

}  // namespace subsoil::mbd
