#include "libsim/view/symbols.hpp"

#include <cmath>
#include <concepts>
#include <utility>

#include "libmbd/elements.hpp"

namespace subsoil::sim {
namespace {

Json in_plane(const Vec2& p) { return {p[0], p[1]}; }
Json finite_or_null(double v) { return std::isfinite(v) ? Json(v) : Json(); }

/// A revolute joint or bushing between two bodies; else one of the second, else the second's centre of mass.
Sketch::Pair pin_between(const Sketch& sketch, int a, int b) {
  for (const Sketch::Pair& p : sketch.pins) {
    if (p.a == a && p.b == b) return p;
    if (p.a == b && p.b == a) return {a, b, p.p_b, p.p_a};
  }
  for (const Sketch::Pair& p : sketch.pins) {
    if (p.b == b) return {a, b, {0, 0}, p.p_b};
    if (p.a == b) return {a, b, {0, 0}, p.p_a};
  }
  return {a, b, {0, 0}, {0, 0}};
}

/// A force along the line between points of two bodies, positive where it pushes them apart.
template <class Force>
concept PushesApart = std::same_as<Force, mbd::SpringDamper> || std::same_as<Force, mbd::HydraulicCylinder> ||
    std::same_as<Force, mbd::DistanceStop>;
/// A torque on the second body, positive counter-clockwise.
template <class Force>
concept Turns = std::same_as<Force, mbd::RotationalSpringDamper> || std::same_as<Force, mbd::RotationalStop> ||
    std::same_as<Force, mbd::ElectricMotor> || std::same_as<Force, mbd::TorqueSpeedMotor>;
/// A force at a point of one body, of which the first value is the component along x.
template <class Force>
concept ActsAlongX = std::same_as<Force, mbd::AppliedForce> || std::same_as<Force, mbd::Drag>;

class ElementSymbols {
 public:
  ElementSymbols(const Scenario& s, const Sketch& sketch, const ThingOf& thing_of)
      : machine_(*s.machine), sketch_(sketch), thing_of_(thing_of) {}

  Json make() {
    for (const NamedJoint& j : machine_.joints)
      thing_ = thing_of_("machine.joints." + j.name), visit([&](const auto& joint) { take(joint); }, j.element);
    for (const NamedForce& f : machine_.forces)
      thing_ = thing_of_("machine.forces." + f.name), visit([&](const auto& force) { take(force); }, f.element);
    return std::move(out_);
  }

 private:
  Json& add(const char* kind, const Sketch::Pair& p) {
    out_.push_back(
        {{"kind", kind}, {"thing", thing_}, {"a", p.a}, {"b", p.b}, {"pa", in_plane(p.p_a)}, {"pb", in_plane(p.p_b)}});
    return out_.back();
  }
  template <class Element>
  static Sketch::Pair ends(const Element& e) {
    return {e.body_a, e.body_b, e.p_a, e.p_b};
  }
  template <class Stop>
  void limit(Json& symbol, const Stop& stop) {
    symbol["from"] = finite_or_null(stop.limits.least), symbol["until"] = finite_or_null(stop.limits.largest);
  }

  // Pins, welds, slides and rods are drawn as the sketch has them.
  void take(const mbd::Revolute&) {}
  void take(const mbd::Translational&) {}
  void take(const mbd::Fixed&) {}
  void take(const mbd::PointOnLine&) {}
  void take(const mbd::Distance&) {}
  void take(const mbd::DiskOnLine& j) { on_line(j, "slides"); }
  void take(const mbd::RollingOnLine& j) { on_line(j, "rolls"); }
  void take(const mbd::RackAndPinion& j) { on_line(j, "rack"); }
  void take(const mbd::DiskOnDisk& j) { two_disks(j, j.inside, "slides"); }
  void take(const mbd::RollingOnDisk& j) { two_disks(j, j.inside, "rolls"); }
  void take(const mbd::GearPair& j) { two_disks(j, j.inside, "gears"); }
  void take(const mbd::GearRatio& j) {
    const Sketch::Pair a = pin_between(sketch_, j.body_c, j.body_a), b = pin_between(sketch_, j.body_c, j.body_b);
    add("ratio", {j.body_a, j.body_b, a.p_b, b.p_b})["ratio"] = j.ratio;
  }
  void take(const mbd::Coupler&) {}
  template <std::size_t rows>
  void take(const mbd::OwnJoint<rows>&) {}  // no scenario names one, nor a force of a user's program
  void take(const mbd::OwnForce&) {}
  void take(const mbd::CamFollower& j) { add("follower", ends(j)); }
  void take(const mbd::FlatFacedCam& j) { add("follower", ends(j))["angle"] = j.angle_b; }
  void take(const mbd::PointOnCurve& j) { add("follower", {j.body_a, j.body_b, {0, 0}, j.p_b}); }

  /// A disk of b on a line of a.
  template <class Element>
  void on_line(const Element& e, const char* what) {
    Json& out = add("disk on line", ends(e));
    out["angle"] = e.angle_a, out["radius"] = e.radius, out["what"] = what;
  }
  template <class Element>
  void two_disks(const Element& e, bool inside, const char* what) {
    Json& out = add("two disks", ends(e));
    out["radius"] = e.radius_a, out["radiusB"] = inside ? -e.radius_b : e.radius_b, out["what"] = what;
  }

  void take(const mbd::SpringDamper&) {}       // a helix or a damper of the sketch
  void take(const mbd::HydraulicCylinder&) {}  // a cylinder of the sketch
  void take(const mbd::AppliedForce& f) {
    Json& out = add("load", {mbd::ground, f.body, {0, 0}, f.point});
    out["along"] = {f.fx.value(0), f.fy.value(0), f.moment.value(0)};
    out["turns"] = f.axes == mbd::Axes::body;
  }
  void take(const mbd::RotationalSpringDamper& f) { add("torsion", pin_between(sketch_, f.body_a, f.body_b)); }
  void take(const mbd::Bushing& f) { add("bushing", ends(f)); }
  void take(const mbd::BeamElement& f) { add("beam", ends(f)); }
  void take(const mbd::Drag& f) { add("drag", {mbd::ground, f.body, {0, 0}, f.point}); }
  void take(const mbd::LineContact& f) { on_line(f, "contact"); }
  void take(const mbd::DiskContact& f) { two_disks(f, f.side == mbd::DiskSide::inside, "contact"); }
  void take(const mbd::OutlineContact& f) {
    const auto place = [](const auto& form) { return place_of(form); };
    add("contact", {f.body_a, f.body_b, std::visit(place, f.first), std::visit(place, f.second)});
  }
  static Vec2 place_of(const mbd::DiskOutline& o) { return o.centre; }
  static Vec2 place_of(const mbd::ProfileOutline& o) { return o.centre; }
  static Vec2 place_of(const mbd::PolygonOutline& o) { return mean_of(o.points); }
  static Vec2 place_of(const mbd::FlankOutline& o) { return mean_of(o.points); }
  static Vec2 place_of(const mbd::FlatOutline& o) { return o.point; }
  template <class Points>
  static Vec2 mean_of(const Points& points) {
    Vec2 sum{0, 0};
    for (const auto& p : points) sum[0] += p[0], sum[1] += p[1];
    const double count = points.empty() ? 1 : static_cast<double>(points.size());
    return {sum[0] / count, sum[1] / count};
  }
  void take(const mbd::RotationalStop& f) { limit(add("angle stop", pin_between(sketch_, f.body_a, f.body_b)), f); }
  void take(const mbd::SlideStop& f) {
    Json& out = add("slide stop", ends(f));
    out["angle"] = f.angle_a;
    limit(out, f);
  }
  void take(const mbd::DistanceStop& f) { limit(add("distance stop", ends(f)), f); }
  void take(const mbd::WheelOnSoil& f) {
    Json& out = add("ground", {mbd::ground, f.body, {0, f.surface}, {0, 0}});
    out["radius"] = f.radius;
  }
  void take(const mbd::GroundElement& f) {
    Json& out = add("ground", {mbd::ground, f.body, {0, f.surface}, f.point});
    out["radius"] = f.radius;
  }
  void take(const mbd::JointFriction& f) {
    const std::string joint = "machine.joints." + f.joint;
    for (const Sketch::Pair& p : sketch_.pins)
      if (p.element == joint) return void(add("friction", p));
    for (const Sketch::Slide& s : sketch_.slides)
      if (s.element == joint) return void(add("friction", s));
  }
  void take(const mbd::ElectricMotor& f) { add("motor", pin_between(sketch_, f.body_a, f.body_b)); }
  void take(const mbd::TorqueSpeedMotor& f) { add("motor", pin_between(sketch_, f.body_a, f.body_b)); }

  const MachineSection& machine_;
  const Sketch& sketch_;
  const ThingOf& thing_of_;
  int thing_ = -1;
  Json out_ = Json::array();
};

}  // namespace

Json element_symbols(const Scenario& scenario, const Sketch& sketch, const ThingOf& thing_of) {
  return ElementSymbols(scenario, sketch, thing_of).make();
}

Json positive_sense(const Force& force, const Sketch& sketch) {
  return visit(
      [&]<class F>(const F& f) -> Json {
        if constexpr (PushesApart<F>)
          return {{"body", f.body_b},
                  {"point", in_plane(f.p_b)},
                  {"from", {{"body", f.body_a}, {"point", in_plane(f.p_a)}}}};
        else if constexpr (Turns<F>)
          return {{"body", f.body_b}, {"point", in_plane(pin_between(sketch, f.body_a, f.body_b).p_b)}, {"turn", 1}};
        else if constexpr (ActsAlongX<F>)
          return {{"body", f.body}, {"point", in_plane(f.point)}, {"along", {1, 0, 0}}};
        else
          return nullptr;
      },
      force);
}

}  // namespace subsoil::sim
