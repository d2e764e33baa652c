#include "libsim/scenario/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "libsim/document/arithmetic.hpp"
#include "libsim/document/grammar.hpp"
#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/keys/printer.hpp"
#include "libsim/keys/reader.hpp"
#include "libsim/keys/schema.hpp"

namespace subsoil::sim {

namespace {

class KnownMaterials final : public Compound {
 public:
  explicit KnownMaterials(const Scenario& scenario) : scenario_(scenario) {}
  void read(Reader& reader, const Field&) override { reader.reading().materials = &scenario_.materials; }
  void print(Printer&, const Field&) const override {}
  void list(KeyList&, const Field&) const override {}
  void outline(Schema&, const Field&) const override {}

 private:
  const Scenario& scenario_;
};

/// Names for amounts, which the values that follow may hold, and each other in any order: those of an included file
/// come behind one's own. The explicit copy of a run holds what became of them.
class ParameterList final : public Compound {
 public:
  void read(Reader& reader, const Field& field) override {
    reader.leaf(field, [&](const Node& node) {
      std::vector<const Node::Entry*> pending;
      for (const Node::Entry& e : mapping_of(node).entries) {
        reader.reading().places[reader.child(field.key) + "." + e.key] = e.value.place;
        pending.push_back(&e);
      }
      for (std::size_t before = pending.size() + 1; !pending.empty();) {
        const bool last = pending.size() == before;  // what is missing now is not there
        before = pending.size();
        const std::vector<const Node::Entry*> unresolved = pending;
        std::erase_if(pending, [&](const Node::Entry* e) {
          try {
            add_parameter(e->key, evaluate_arithmetic(scalar_of(e->value)));
          } catch (const UnknownName& fault) {
            if (!last) return false;
            const bool stands = std::any_of(unresolved.begin(), unresolved.end(),
                                            [&](const Node::Entry* other) { return other->key == fault.name; });
            reader.fault(e->value, reader.child(field.key) + "." + e->key,
                         stands ? fmt::format("`{}` has no value: it holds this one, or is at fault itself", fault.name)
                                : fault.what());
          } catch (const std::invalid_argument& fault) {
            reader.fault(e->value, reader.child(field.key) + "." + e->key, fault.what());
          }
          return true;
        });
      }
    });
  }
  void print(Printer&, const Field&) const override {}
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "named values with units", "none", "", field.meaning);
  }
  void outline(Schema& schema, const Field& field) const override {
    schema.add(field, {{"type", "object"}, {"additionalProperties", number_form("1")}});
  }
};

}  // namespace

void describe(Fields& v, Scenario& s) {
  ParameterList parameters;
  v.visit_compound({"parameters",
                    "names that stand for values in all others: {a: 200 mm, b: 2*a + 30 mm}, then `length: b/2`; each "
                    "may hold others; + - * / ^, brackets, pi, sqrt abs min max hypot sin cos tan asin acos "
                    "atan atan2 exp log"},
                   parameters);
  v.version("subsoil", s.version, "version of the scenario format: 1");
  v.text("title", s.title, "one line about what this is");
  v.choice("analysis", s.analysis,
           {{"dynamics", Analysis::dynamics},
            {"kinematics", Analysis::kinematics},
            {"equilibrium", Analysis::equilibrium},
            {"modes", Analysis::modes},
            {"assembly", Analysis::assembly}},
           "dynamics: motion under forces; kinematics: motion and driving forces of a machine that is driven in every "
           "coordinate; equilibrium: the state of rest (or of towing) and its stability; modes: small oscillations "
           "about it; assembly: how the pose closes. All but dynamics: without soil");
  v.downward("gravity", s.gravity, "m/s^2", "one number acts downward (-y); or a vector");
  v.choice(
      "engine", s.engine, {{"subsoil", SoilEngine::subsoil}, {"liggghts", SoilEngine::liggghts}},
      "what steps the spheres; liggghts: on many processes, `mpirun -np 4 subsoil run FILE.yaml`, for soil that one "
      "machine cannot hold or do in time (docs/reference/many-nodes.md)");
  v.text("simd", s.simd,
         "instruction set of the soil kernel: portable, avx2, avx512, or auto: the best of this processor");
  v.choice(
      "precision", s.precision, {{"double", dem::Precision::doubles}, {"mixed", dem::Precision::mixed}},
      "of the soil; mixed: positions and forces on surfaces in double; velocities, the force on a sphere, springs and "
      "laws between spheres in float (docs/performance.md says what it changes)");
  v.named("materials", s.materials, "what soil, tools and walls are made of");
  KnownMaterials known_materials(s);
  v.visit_compound({}, known_materials);  // what follows combines their values
  v.list("contacts", s.contacts, "the law of each pair of materials that can meet");
  v.section("soil", s.soil, "container and bed; left out: a machine only");
  v.list("boundaries", s.boundaries, "surfaces that are no machine's: fixed or on a given path");
  v.section("machine", s.machine, "planar multibody system; left out: soil only");
  v.section("time", s.time, "end, steps, integrator");
  v.section("output", s.output, "what is written, and how often");
  v.section("limits", s.limits, "beyond these the run stops with exit 3");
}

}  // namespace subsoil::sim
