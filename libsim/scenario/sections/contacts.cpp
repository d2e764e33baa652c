#include "libsim/scenario/sections/contacts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/keys/printer.hpp"
#include "libsim/keys/reader.hpp"
#include "libsim/keys/schema.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/friction_faults.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

namespace {

/// Values of the law that a rule supplies from both materials. The law's own keys then hold what came out: printed,
/// they say where it is from, and are read again as they stand.
class Combinations final : public Compound {
 public:
  explicit Combinations(Contact& contact) : contact_(contact) {}
  void read(Reader& reader, const Field& field) override {
    reader.leaf(field, [&](const Node& node) {
      for (const Node::Entry& e : mapping_of(node).entries) try {
          read_rule(reader, e);
        } catch (const Refusal& refusal) {
          reader.fault(e.value, reader.child(field.key) + "." + e.key, refusal.what());
        }
    });
  }
  void print(Printer& printer, const Field&) const override {
    for (const Combination& c : contact_.combine)
      printer.remark(c.key, fmt::format("{} of the two materials'", rule_words[static_cast<std::size_t>(c.rule)]));
  }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "{value: rule}", "left out", fmt::format("{}", fmt::join(rule_words, " | ")), field.meaning);
  }
  void outline(Schema& schema, const Field& field) const override {
    Json values = Json::object();
    for (const Combinable& c : combinables) {
      values[c.key] = words_form({rule_words.begin(), rule_words.end()});
      schema.excuse(c.key, {{"required", Json::array({field.key})},
                            {"properties", {{field.key, {{"required", Json::array({c.key})}}}}}});
    }
    schema.add(field, {{"type", "object"}, {"properties", values}, {"additionalProperties", false}});
  }

 private:
  void read_rule(Reader& reader, const Node::Entry& e) {
    std::vector<std::string> known;
    for (const Combinable& c : combinables) known.emplace_back(c.key);
    const auto what =
        std::find_if(combinables.begin(), combinables.end(), [&](const Combinable& c) { return c.key == e.key; });
    if (what == combinables.end()) throw Refusal("no value that can be combined" + suggestion(e.key, known));
    if (reader.holds(e.key))
      throw Refusal(fmt::format("`{}` stands in this entry too", e.key), "keep the value or the rule");
    reader.supply(e.key, std::nan(""));  // whatever is wrong with it, it is not missing besides
    const auto word = std::find(rule_words.begin(), rule_words.end(), scalar_of(e.value));
    if (word == rule_words.end())
      throw Refusal("unknown rule" + suggestion(e.value.scalar, {rule_words.begin(), rule_words.end()}));
    const auto rule = static_cast<CombinationRule>(word - rule_words.begin());
    reader.supply(e.key, value_of(reader.reading(), *what, rule));
    contact_.combine.push_back({e.key, rule});
  }

  /// NaN where a name is no material's, which is reported elsewhere.
  double value_of(const Reading& reading, const Combinable& what, CombinationRule rule) const {
    double values[2];
    for (std::size_t i = 0; i < 2; ++i) {
      const auto m = std::find_if(reading.materials->begin(), reading.materials->end(),
                                  [&](const Material& material) { return material.name == contact_.between[i]; });
      if (m == reading.materials->end()) return std::nan("");
      if (!((*m).*what.value))
        throw Refusal(fmt::format("material `{}` has no {}", contact_.between[i], what.key),
                      fmt::format("give it there, or the pair's {} here in place of the rule", what.key));
      values[i] = *((*m).*what.value);
    }
    return combined(rule, values[0], values[1]);
  }

  Contact& contact_;
};

}  // namespace

void describe(Fields& v, Contact& c) {
  v.pair("between", c.between, Family::material, "the two materials that meet; any order");
  Combinations combine(c);
  v.visit_compound({"combine",
                    "values of the law by a named rule from those of the two materials: {mu: minimum, restitution: "
                    "geometric-mean}; each may be restitution, mu, mu_d, mu_r, mu_t or work of adhesion"},
                   combine);
  declare_law(v, c.law, "law", "contact law; its parameters stand beside it");
}

namespace {

struct ContactChecks : Checks {
  const Scenario& s;

  static std::pair<std::string, std::string> ordered(const std::string& a, const std::string& b) {
    return a < b ? std::pair{a, b} : std::pair{b, a};
  }

  void contacts() {
    std::map<std::pair<std::string, std::string>, std::size_t> given;
    for (std::size_t i = 0; i < s.contacts.size(); ++i) {
      const auto& [a, b] = s.contacts[i].between;
      const std::string path = fmt::format("contacts[{}]", i);
      material(path + ".between", a);
      if (a != b) material(path + ".between", b);
      const auto [there, fresh] = given.emplace(ordered(a, b), i);
      if (!fresh && !a.empty()) {
        refuse(path + ".between", fmt::format("[{}, {}]", a, b),
               fmt::format("this pair has a law already, in line {}; keep one of them",
                           place_of(places, fmt::format("contacts[{}]", there->second)).line));
      }
      elastic(path, s.contacts[i]);
      for (const FrictionFault& fault : friction_faults(s.contacts[i].law)) {
        const std::string key = path + "." + fault.key;
        if (!fault.idle || places.contains(key)) refuse(key, fmt::format("{:g}", fault.value), fault.rule);
      }
    }
    for (const auto& [pair, meet] : meetings()) {
      if (given.contains(pair)) continue;
      refuse("contacts", fmt::format("{} and {} can meet ({}) but have no law; add `- between: [{}, {}]`", pair.first,
                                     pair.second, meet, pair.first, pair.second));
    }
  }

  /// A law that computes its stiffness needs the materials' elastic constants, one whose bodies yield their strength.
  void elastic(const std::string& path, const Contact& contact) {
    const MaterialNeeds needs = material_needs(contact.law);
    if (needs.in_place_of_elastic != nullptr)
      of_materials(path, contact, needs.law, needs.in_place_of_elastic, "young's modulus and poisson ratio",
                   [](const Material& m) { return m.young && m.poisson; });
    if (needs.in_place_of_yield != nullptr)
      of_materials(path, contact, needs.law, needs.in_place_of_yield, "yield strength",
                   [](const Material& m) { return m.yield.has_value(); });
  }

  template <class Has>
  void of_materials(const std::string& path, const Contact& contact, const std::string& word, const char* instead,
                    const char* what, Has has) {
    for (const std::string& name : std::set<std::string>{contact.between[0], contact.between[1]}) {
      const auto m =
          std::find_if(s.materials.begin(), s.materials.end(), [&](const Material& x) { return x.name == name; });
      if (m == s.materials.end() || has(*m)) continue;
      refuse(path + ".law", word,
             fmt::format("material `{}` has no {}; give {} there, or {} here", name, what,
                         std::string_view(what).find(" and ") == std::string_view::npos ? "it" : "them", instead));
    }
  }

  /// Spheres of a material, 2 for more: one that is alone meets none of its own.
  int count_of(const std::string& material) const {
    if (s.soil->bed)
      for (const FibreSection& f : s.soil->bed->fibres)
        if (f.material == material) return 2;
    for (const InletSection& inlet : s.soil->inlets)
      if (material_of(inlet, s.soil->bed) == material) return 2;
    const BedSection& bed = *s.soil->bed;
    if (bed.fill == Fill::random && bed.count == 1) return 1;
    if (bed.fill != Fill::particles || !bed.layers.empty()) return 2;
    const auto is = [&](const Particle& p) { return (p.material.empty() ? bed.material : p.material) == material; };
    return static_cast<int>(std::min<std::ptrdiff_t>(2, std::count_if(bed.particles.begin(), bed.particles.end(), is)));
  }

  /// Pairs of materials that can touch, and how; only of names that exist.
  std::map<std::pair<std::string, std::string>, std::string> meetings() {
    std::map<std::pair<std::string, std::string>, std::string> pairs;
    if (!s.soil) return pairs;
    const Names known = names_of(s.materials);
    std::set<std::string> spheres;
    for (const InletSection& inlet : s.soil->inlets) spheres.insert(material_of(inlet, s.soil->bed));
    if (const auto& bed = s.soil->bed) {
      spheres.insert(bed->material);
      for (const Particle& p : bed->particles)
        if (!p.material.empty()) spheres.insert(p.material);
      for (const Layer& l : bed->layers) spheres.insert(l.material);
      for (const FibreSection& f : bed->fibres) spheres.insert(f.material);
    }
    const auto meet = [&](const std::string& other, const std::string& how) {
      for (const std::string& sphere : spheres) {
        if (holds(known, sphere) && holds(known, other)) pairs.emplace(ordered(sphere, other), how);
      }
    };
    for (const std::string& sphere : spheres)
      for (const std::string& other : spheres)
        if (sphere != other || count_of(sphere) > 1)
          if (holds(known, sphere) && holds(known, other))
            pairs.emplace(ordered(sphere, other), "spheres with each other");
    if (s.soil->container) meet(s.soil->container->material, "spheres and the container's walls");
    for (const BoundarySection& b : s.boundaries)
      meet(b.material, fmt::format("spheres and the boundary `{}`", b.name));
    if (s.machine) {
      for (const Surface& surface : s.machine->surfaces) {
        if (surface.touches_soil) meet(surface.material, fmt::format("spheres and the surface `{}`", surface.name));
      }
    }
    return pairs;
  }
};

}  // namespace

void check_contacts(Checks& checks, const Scenario& s) { ContactChecks{checks, s}.contacts(); }

}  // namespace subsoil::sim
