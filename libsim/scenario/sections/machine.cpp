#include "libsim/scenario/sections/machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "libmbd/controllers.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/measures.hpp"
#include "libmbd/measures/control_input.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/keys/printer.hpp"
#include "libsim/keys/ranges.hpp"
#include "libsim/keys/reader.hpp"
#include "libsim/keys/schema.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

template <class Family>
struct TypesOf<mbd::AnyElement<Family>> : mbd::DeclaredOf<Family> {};

void describe(Fields& v, BodySection& b) {
  v.quantity("mass", b.mass, "kg", "(0, inf)", "mass");
  v.quantity("inertia", b.inertia, "kg m^2", "(0, inf)", "moment of inertia about the centre of mass");
  v.vector("at", b.at, "m", "centre of mass in the start pose, x y");
  v.quantity("angle", b.angle, "rad", "(-inf, inf)", "of the body's axes in the start pose, counter-clockwise");
  v.vector("velocity", b.velocity, "m/s", "of the centre of mass at the start");
  v.quantity("angular velocity", b.spin, "rad/s", "(-inf, inf)", "at the start, counter-clockwise");
  v.choice(
      "pose is", b.pose_is,
      {{"given", mbd::StartMark::given}, {"exact", mbd::StartMark::exact}, {"about", mbd::StartMark::about}},
      "given: a run is refused where the joints move the body by more than 1 % of its size; exact: it is not moved "
      "at all, others are; about: a guess, moved as far as need be");
  v.choice("velocity is", b.velocity_is,
           {{"given", mbd::StartMark::given}, {"exact", mbd::StartMark::exact}, {"about", mbd::StartMark::about}},
           "given: what is not 0 stays and the rest follows, a run is refused where the joints change it by more than "
           "1e-3; exact: zeros stay too; about: a guess, changed as far as need be");
  v.optional_outline(
      "outline", b.outline,
      "points `x y` of its outline in pictures, in its own axes, or a CSV file of them whose header names "
      "the unit; left out: drawn from its surfaces, else from its joints");
}

void describe(Fields& v, Surface& s) {
  v.reference("body", s.body, Family::body, "the body that carries it");
  v.optional_reference("material", s.material, Family::material, "of the surface; left out when it touches no soil");
  v.inline_form(s.shape);
  v.choice("placed in", s.placed_in, {{"body", PlacedIn::body}, {"world", PlacedIn::world}},
           "axes of `at` and `rotation`: the body's, about its centre of mass, or the world's in the start pose");
  v.vector("at", s.at, "m", "where the origin of the shape is put");
  v.section("rotation", s.rotation, "turns the shape about its origin, by `axis` and `angle` or by `turns`");
  v.flag("touches soil", s.touches_soil, "no: it is drawn only");
  v.quantity("cutting edges", s.cutting, "rad", "(0, 3.1]",
             "edges at which the surface is a wedge of this angle or less: they cut fibres with a `bond cutting "
             "strength`; left out: none");
  v.section("wear", s.wear, "keeps pressure, work and wear on each triangle, in frames and in the summary");
}

void describe(Fields& v, JointEventSection& e) {
  v.optional_reference("opens", e.opens, Family::joint, "the joint that it opens: release, shear pin");
  v.optional_reference("closes", e.closes, Family::joint,
                       "the joint that it closes where its bodies are, by a plastic impact: latch. A joint that events "
                       "only close starts open");
  v.quantity("at", e.at, "s", "[0, inf)", "when: at this time");
  v.quantity("reaction above", e.reaction_above, "N", "(0, inf)", "when: the force in the joint exceeds this");
  v.text("measure", e.measure, "when: this measure, a column of machine.measures, passes ...");
  v.level("above", e.above, "... this value upward, given with the measure's unit: 30 deg");
  v.level("below", e.below, "... this value downward");
  v.choice("joint starts", e.starts,
           {{"auto", mbd::JointEvent::Starts::by_events},
            {"open", mbd::JointEvent::Starts::open},
            {"closed", mbd::JointEvent::Starts::closed}},
           "auto: open where events only close the joint");
}

const NamedMeasure* measure_of(const MachineSection& m, const std::string& column, std::size_t& place) {
  for (const NamedMeasure& measure : m.measures) {
    const auto columns = mbd::columns_of(measure.element);
    for (place = 0; place < columns.size(); ++place)
      if (column == (columns[place].suffix.empty() ? measure.name : measure.name + "." + columns[place].suffix))
        return &measure;
  }
  return nullptr;
}

namespace {

/// Hands the bodies to those who name them.
class KnownBodies final : public Compound {
 public:
  explicit KnownBodies(const MachineSection& machine) : machine_(machine) {}
  void read(Reader& reader, const Field&) override {
    for (const BodySection& body : machine_.bodies) {
      reader.reading().body_names.push_back(body.name);
      reader.reading().body_poses.emplace_back(mbd::Vec2{body.at[0], body.at[1]}, body.angle, mbd::Vec2{}, 0.0);
    }
  }
  void print(Printer& printer, const Field&) const override {
    for (const BodySection& body : machine_.bodies) printer.know_body(body.name);
  }
  void list(KeyList&, const Field&) const override {}
  void outline(Schema&, const Field&) const override {}

 private:
  const MachineSection& machine_;
};

/// Takes what beams stand for out of the lists that are printed, and puts it back.
class BeamsTakenOut final : public Compound {
 public:
  explicit BeamsTakenOut(MachineSection& machine) : machine_(machine) {}
  void read(Reader&, const Field&) override {}
  void print(Printer&, const Field&) const override { take_beams_out(machine_); }
  void list(KeyList&, const Field&) const override {}
  void outline(Schema&, const Field&) const override {}

 private:
  MachineSection& machine_;
};

/// The nodes of beams, as bodies after the given ones.
class BeamNodes final : public Compound {
 public:
  explicit BeamNodes(MachineSection& machine) : machine_(machine) {}
  void read(Reader& reader, const Field&) override {
    const std::size_t given = machine_.bodies.size();
    add_beam_nodes(machine_);
    for (std::size_t i = given; i < machine_.bodies.size(); ++i) {
      const BodySection& body = machine_.bodies[i];
      reader.reading().body_names.push_back(body.name);
      reader.reading().body_poses.emplace_back(mbd::Vec2{body.at[0], body.at[1]}, body.angle, mbd::Vec2{}, 0.0);
    }
  }
  void print(Printer& printer, const Field&) const override {
    const std::size_t given = machine_.bodies.size();
    add_beam_nodes(machine_);
    for (std::size_t i = given; i < machine_.bodies.size(); ++i) printer.know_body(machine_.bodies[i].name);
  }
  void list(KeyList&, const Field&) const override {}
  void outline(Schema&, const Field&) const override {}

 private:
  MachineSection& machine_;
};

class BeamElements final : public Compound {
 public:
  explicit BeamElements(MachineSection& machine) : machine_(machine) {}
  void read(Reader&, const Field&) override { add_beam_elements(machine_); }
  void print(Printer&, const Field&) const override { add_beam_elements(machine_); }
  void list(KeyList&, const Field&) const override {}
  void outline(Schema&, const Field&) const override {}

 private:
  MachineSection& machine_;
};

class KnownMarkers final : public Compound {
 public:
  explicit KnownMarkers(const MachineSection& machine) : machine_(machine) {}
  void read(Reader& reader, const Field&) override { reader.reading().markers = machine_.markers; }
  void print(Printer&, const Field&) const override {}
  void list(KeyList&, const Field&) const override {}
  void outline(Schema&, const Field&) const override {}

 private:
  const MachineSection& machine_;
};

/// `pose`, or {towing equilibrium: speed}.
class StartWord final : public Compound {
 public:
  explicit StartWord(Start& start) : start_(start) {}
  void read(Reader& reader, const Field& field) override {
    reader.leaf(field, [&](const Node& node) {
      if (node.kind == Node::Kind::scalar) {
        if (node.scalar != "pose") throw Refusal("must be `pose` or {towing equilibrium: 0.5 m/s}");
        return;
      }
      Reader inner(reader.reading(), mapping_of(node), reader.child(field.key));
      start_.kind = StartKind::towing_equilibrium;
      start_.speed = required;
      inner.quantity("towing equilibrium", start_.speed, "m/s", "(-inf, inf)", "speed along x of all bodies");
      inner.finish();
    });
  }
  void print(Printer& printer, const Field& field) const override { printer.leaf(field.key, node(), field.meaning); }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "word, or {towing equilibrium: m/s}", KeyList::fallback(node(), false), "", field.meaning);
  }
  void outline(Schema& schema, const Field& field) const override {
    const Json towing{{"type", "object"},
                      {"properties", {{"towing equilibrium", number_form("m/s")}}},
                      {"required", Json::array({"towing equilibrium"})},
                      {"additionalProperties", false}};
    schema.add(field, either({words_form({"pose"}), towing}));
  }

 private:
  Node node() const {
    if (start_.kind == StartKind::pose) return Node::of("pose");
    Node node = Node::mapping(true);
    node.add("towing equilibrium", Node::of(format_quantity(start_.speed, "m/s")));
    return node;
  }
  Start& start_;
};

}  // namespace

namespace {
/// Names in a formula that are measures with one column, each once.
std::vector<std::string> measures_in(const MachineSection& m, const std::string& formula) {
  std::vector<std::string> names;
  const auto starts = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; };
  const auto continues = [&](char c) { return starts(c) || std::isdigit(static_cast<unsigned char>(c)); };
  for (std::size_t i = 0; i < formula.size();) {
    if (!starts(formula[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < formula.size() && continues(formula[end])) ++end;
    const std::string name = formula.substr(i, end - i);
    i = end;
    std::size_t place = 0;
    if (measure_of(m, name, place) != nullptr && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  }
  return names;
}
}  // namespace

std::vector<std::string> measured_by(const MachineSection& m, const mbd::AnyController& controller) {
  return visit(
      [&]<class Controller>(const Controller& c) -> std::vector<std::string> {
        if constexpr (std::is_same_v<Controller, mbd::FormulaController>) return measures_in(m, c.text);
        if constexpr (std::is_same_v<Controller, mbd::TableOfTwo>) return split_at_semicolons(c.measures);
        if constexpr (requires { c.measure; }) return {c.measure};
        return {};
      },
      controller);
}

void describe(Fields& v, MachineSection& m) {
  BeamsTakenOut without_beams(m);
  v.visit_compound({}, without_beams);
  v.named("bodies", m.bodies, "rigid bodies in the x-y plane; `ground` is always there");
  KnownBodies known_bodies(m);
  v.visit_compound({}, known_bodies);  // what follows names them
  v.named("beams", m.beams,
          "elastic beams. Of a beam `tine` the bodies `tine start`, `tine 1`, ..., `tine end` are its nodes, which "
          "joints, forces, markers and surfaces name as others");
  BeamNodes nodes(m);
  v.visit_compound({}, nodes);
  v.named("markers", m.markers, "points with axes on bodies or the ground, for measures and pictures");
  KnownMarkers known_markers(m);
  v.visit_compound({}, known_markers);
  v.elements("joints", m.joints, "constraints between bodies");
  v.elements("drivers", m.drivers, "motions given as functions of time");
  v.elements("forces", m.forces, "springs, dampers, loads, wheels");
  v.elements("measures", m.measures, "columns of your own: what is measured of markers, joints, forces and bodies");
  v.elements("controllers", m.controllers,
             "what moves springs, loads, cylinders and motors by their `controller`: PID, formula, transfer function, "
             "table of measures");
  v.named("events", m.events,
          "joints that open and close: {trip: {opens: shear pin, reaction above: 20 kN}}, {drop: {opens: hook, at: 0.5 "
          "s}}, {catch: {closes: hook, measure: gap, below: 1 mm}}");
  v.named("surfaces", m.surfaces, "what of the bodies meets the soil, or is drawn");
  BeamElements elements(m);
  v.visit_compound({}, elements);
  StartWord start(m.start);
  v.visit_compound({"start", "`pose` as given, or {towing equilibrium: speed}: the steady state found by the program"},
                   start);
  v.choice("redundant", m.redundant,
           {{"minimum-norm", mbd::Redundancy::minimum_norm}, {"refuse", mbd::Redundancy::refuse}},
           "constraints that depend on each other: share their reaction with least norm, or stop and name them");
  v.flag("assemble", m.assemble, "move the bodies until the joints close; no: refuse a pose that is off");
}

namespace {

struct MachineChecks : Checks {
  Scenario& s;

  void machine() {
    MachineSection& m = *s.machine;
    if (m.bodies.empty()) refuse("machine.bodies", "is missing: a machine has at least one body");
    beams(m);
    const Names bodies = names_of(m.bodies);
    for (Surface& surface : m.surfaces) {
      const std::string path = "machine.surfaces." + surface.name;
      refer(path + ".body", surface.body, bodies, "body");
      const auto found = std::find(bodies.begin(), bodies.end(), surface.body);
      surface.body_index = found == bodies.end() ? 0 : static_cast<int>(found - bodies.begin()) + 1;
      material(path + ".material", surface.material);
      check_shape(*this, path, surface.shape);
      direction(path + ".rotation.axis", surface.rotation.axis);
      check_wear(*this, path + ".wear", surface.wear);
      if (surface.wear && !surface.touches_soil)
        refuse(path + ".wear", "a surface that is drawn only bears nothing; leave one of the two out");
      if (s.soil && surface.touches_soil && surface.material.empty()) {
        refuse(path + ".material", "is missing; a surface in soil needs a material, or `touches soil: no`");
      }
    }
    measures(m);
    for (const NamedForce& force : m.forces)
      if (const auto* friction = force.element.get_if<mbd::JointFriction>())
        refer("machine.forces." + force.name + ".joint friction", friction->joint, names_of(m.joints), "joint");
    contacts(m);
    controllers(m);
    events(m);
    wheels(m);
  }

  /// Keys of contacts, stops and wheels beside which another one acts. A written scenario has them with their defaults.
  void contacts(const MachineSection& m) {
    for (const NamedForce& force : m.forces) {
      const std::string path = "machine.forces." + force.name + ".";
      const auto without_effect = [&](bool when, const char* key, const char* why) {
        if (when && places.contains(path + key))
          refuse(path + key, std::string("has no effect ") + why + "; leave it out");
      };
      const auto normal = [&](const mbd::HuntCrossleyForce& law) {
        const bool given = law.gives_restitution();
        without_effect(given && law.damping != 0, "damping", "beside `restitution`, from which it follows");
        without_effect(!given && law.slowest_impact != mbd::HuntCrossleyForce{}.slowest_impact, "restitution from",
                       "without `restitution`");
      };
      visit(
          [&]<class Force>(const Force& f) {
            if constexpr (requires { f.limits.law.restitution; }) normal(f.limits.law);
            if constexpr (requires { f.law.stick_stiffness; }) {
              normal(f.law.normal);
              const bool stiff = !std::isnan(f.law.stick_stiffness);
              without_effect(stiff && f.law.slip_speed != mbd::ContactLaw{}.slip_speed, "slip speed",
                             "beside `stick stiffness`: the surfaces stick");
              without_effect(f.law.friction == 0, "stick stiffness", "without `friction`");
              without_effect(!stiff, "stick damping", "without `stick stiffness`");
            }
            if constexpr (requires { f.shear_displacement; }) {
              without_effect(!f.shears() && f.cohesion != 0, "cohesion", "without `shear displacement`");
              without_effect(!f.shears() && f.internal_friction != 0, "internal friction",
                             "without `shear displacement`");
              without_effect(f.shears() && f.cohesion == 0 && f.internal_friction == 0, "shear displacement",
                             "without `cohesion` and `internal friction`");
            }
          },
          force.element);
    }
  }

  void events(const MachineSection& m) {
    for (const JointEventSection& e : m.events) {
      const std::string path = "machine.events." + e.name;
      if (e.opens.empty() == e.closes.empty()) refuse(path, "needs either `opens` or `closes`, the name of a joint");
      if (!e.opens.empty()) refer(path + ".opens", e.opens, names_of(m.joints), "joint");
      if (!e.closes.empty()) refer(path + ".closes", e.closes, names_of(m.joints), "joint");
      const bool passes = !e.measure.empty();
      if ((e.at ? 1 : 0) + (e.reaction_above ? 1 : 0) + (passes ? 1 : 0) != 1)
        refuse(path, "needs one condition: `at`, `reaction above`, or `measure` with `above` or `below`");
      if (passes != (e.above.empty() == e.below.empty() ? false : true))
        refuse(path, "a `measure` passes one value: give `above` or `below` with it, and these with a measure only");
      if (passes) passed_value(path, m, e);
    }
  }

  void passed_value(const std::string& path, const MachineSection& m, const JointEventSection& e) {
    std::size_t place = 0;
    const NamedMeasure* measure = measure_of(m, e.measure, place);
    if (measure == nullptr)
      return refuse(path + ".measure", e.measure,
                    "no column of a measure has this name; declare it in machine.measures");
    const std::string& value = e.above.empty() ? e.below : e.above;
    try {
      if (!value.empty()) parse_quantity(value, mbd::columns_of(measure->element)[place].unit);
    } catch (const UnitError& error) {
      refuse(path + (e.above.empty() ? ".below" : ".above"), value, error.what());
    }
  }

  void controllers(const MachineSection& m) {
    for (const NamedController& c : m.controllers)
      visit([&](const auto& law) { inputs(m, "machine.controllers." + c.name, law); }, c.element);
    for (const NamedForce& force : m.forces) {
      const auto [name, unit] = driven(force.element);
      if (name.empty()) continue;
      const std::string path = "machine.forces." + force.name + ".controller";
      refer(path, name, names_of(m.controllers), "controller");
      for (const NamedController& c : m.controllers)
        if (c.name == name)
          same_unit("machine.controllers." + name + ".output in",
                    visit([](const auto& law) { return law.output_unit; }, c.element), unit, "what it drives is in");
    }
  }

  /// A column of a measure by its name, in that unit.
  void input(const MachineSection& m, const std::string& path, const std::string& column, const std::string& unit_path,
             const std::string& unit) {
    std::size_t place = 0;
    if (const NamedMeasure* measure = measure_of(m, column, place))
      return same_unit(unit_path, unit, mbd::columns_of(measure->element)[place].unit, "the measure is in");
    Names columns;
    for (const NamedMeasure& one : m.measures)
      for (const auto& c : mbd::columns_of(one.element))
        columns.push_back(c.suffix.empty() ? one.name : one.name + "." + c.suffix);
    refuse(path, column,
           "no column of a measure has this name" + suggestion(column, columns) + "; declare it in machine.measures");
  }
  void inputs(const MachineSection& m, const std::string& path, const mbd::PidController& law) {
    input(m, path + ".pid", law.measure, path + ".measured in", law.measured_unit);
  }
  void inputs(const MachineSection& m, const std::string& path, const mbd::TransferFunction& law) {
    input(m, path + ".transfer function", law.measure, path + ".measured in", law.measured_unit);
  }
  void inputs(const MachineSection& m, const std::string& path, const mbd::TableOfTwo& law) {
    const std::vector<std::string> columns = split_at_semicolons(law.measures);
    if (columns.size() != 2)
      return refuse(path + ".table of two", law.measures, "must name two measures: [speed, gap]");
    input(m, path + ".table of two", columns[0], path + ".first in", law.first_unit);
    input(m, path + ".table of two", columns[1], path + ".second in", law.second_unit);
  }
  void inputs(const MachineSection& m, const std::string& path, const mbd::FormulaController& law) {
    try {
      make_formula_of(law.text, measured_by(m, law));
    } catch (const std::exception& error) {
      refuse(path + ".formula", law.text,
             std::string(error.what()) + "; names in it are those of measures with one column (`component: x`)");
    }
  }

  void same_unit(const std::string& path, const std::string& given, const std::string& wanted, const char* what) {
    try {
      const Unit a = parse_unit(given), b = parse_unit(wanted);
      if (a.to_si(1) == 1 && a.powers == b.powers) return;
    } catch (const UnitError&) {
    }
    refuse(path, given, fmt::format("{} {}; write that unit", what, wanted));
  }

  /// The controller that a force names, and the unit of the output that it takes.
  static std::pair<std::string, const char*> driven(const Force& force) {
    return visit(
        []<class Element>(const Element& element) -> std::pair<std::string, const char*> {
          if constexpr (Element::has.controlled) {
            const char* unit = "N";
            if constexpr (std::is_same_v<Element, mbd::RotationalSpringDamper>) unit = "N m";
            if constexpr (std::is_same_v<Element, mbd::HydraulicCylinder>) unit = "1";
            if constexpr (std::is_same_v<Element, mbd::TorqueSpeedMotor>) unit = "1";
            if constexpr (std::is_same_v<Element, mbd::ElectricMotor>) unit = "V";
            if constexpr (std::is_same_v<Element, mbd::AppliedForce>)
              if (element.controls == mbd::Controls::moment) unit = "N m";
            return {element.controller, unit};
          } else {
            return {};
          }
        },
        force);
  }

  void beams(const MachineSection& m) {
    for (const BeamSection& beam : m.beams) {
      const std::string path = "machine.beams." + beam.name;
      material(path + ".material", beam.material);
      if (beam.lacks_numbers()) continue;  // said already
      if (!beam.material.empty() && std::holds_alternative<mbd::GivenSection>(beam.section))
        refuse(path + ".material", "a section by its numbers has no shape that could meet the soil; give its sizes");
      try {
        beam.check();
      } catch (const std::invalid_argument& error) {
        refuse(path, error.what());
      }
    }
  }

  void measures(const MachineSection& m) {
    for (const NamedMeasure& measure : m.measures) {
      const std::string path = "machine.measures." + measure.name;
      if (const auto* reaction = measure.element.get_if<mbd::ReactionMeasure>())
        refer(path + ".reaction", reaction->element, names_of(m.joints), "joint");
      if (const auto* force = measure.element.get_if<mbd::ForceMeasure>())
        refer(path + ".force", force->element, names_of(m.forces), "force");
      for (const Watch& watch : s.output.watch)
        if (watch.name == measure.name)
          refuse("output.monitor." + watch.name, "is a measure of the machine, which is a column by itself; drop one");
    }
  }

  void wheels(const MachineSection& m) {
    if (!s.soil || !s.soil->bed) return;
    for (const NamedForce& force : m.forces) {
      const auto* wheel = force.element.get_if<mbd::WheelOnSoil>();
      const auto* ground = force.element.get_if<mbd::GroundElement>();
      if (wheel == nullptr && ground == nullptr) continue;
      for (const Surface& surface : m.surfaces) {
        if (surface.body_index != (wheel ? wheel->body : ground->body) || !surface.touches_soil) continue;
        refuse("machine.forces." + force.name,
               fmt::format("the {} carries `{}`, and so would the spheres under its surface `{}`; leave the law "
                           "out, or give the surface `touches soil: no`",
                           wheel ? "wheel law" : "ground element", surface.body, surface.name));
      }
    }
  }
};

}  // namespace

void check_machine(Checks& checks, Scenario& s) { MachineChecks{checks, s}.machine(); }

}  // namespace subsoil::sim
