#include "libsim/keys/key_list.hpp"

namespace subsoil::sim {
namespace {

/// Looks at the card alone.
class CardFinder final : public Fields {
 public:
  void card(const char* word, const char* meaning) override { found = {word, meaning}; }
  void visit_value(const Field&, Value&) override {}
  void visit_compound(const Field&, Compound&) override {}
  void visit_section(const Field&, SectionMember&) override {}
  void visit_list(const Field&, ListMember&) override {}
  void visit_named(const Field&, NamedMember&) override {}
  void visit_elements(const Field&, ElementsMember&) override {}
  void visit_kind(const Field&, VariantMember&) override {}
  void visit_form(const Field&, VariantMember&) override {}
  void visit_inline_form(VariantMember&) override {}
  Card found;
};

}  // namespace

Card card_shown_by(const Declare& declare_type) {
  CardFinder finder;
  declare_type(finder);
  return finder.found;
}

void KeyList::add(const std::string& key, const std::string& unit, const std::string& fallback,
                  const std::string& range, const std::string& meaning) {
  keys_.push_back({child(key), unit, fallback, range, meaning});
}

std::string KeyList::fallback(const Node& value, bool needed) {
  return needed ? "required" : value.kind == Node::Kind::null ? "left out" : value.one_line();
}

void KeyList::visit_value(const Field& field, Value& value) {
  static const std::vector<std::string> no_bodies{"ground"};
  const Node held = value.print({.n = {}, .bodies = no_bodies, .symbols = true});
  add(field.key, value.what(), fallback(held, field.needed), value.range(),
      field.cure.empty() ? field.meaning : field.meaning + "; " + field.cure);
}

void KeyList::visit_section(const Field& field, SectionMember& section) {
  add(field.key, "section", "", "", field.meaning);
  KeyList below(keys_, child(field.key));
  section.prototype(below);
}

void KeyList::visit_list(const Field& field, ListMember& list) {
  add(field.key, "list of mappings", "left out", "", field.meaning);
  KeyList below(keys_, child(field.key));
  list.declare_prototype(below);
}

void KeyList::visit_named(const Field& field, NamedMember& named) {
  add(field.key, "named mappings", "left out", "", field.meaning);
  KeyList below(keys_, child(field.key) + ".<name>");
  named.declare_prototype(below);
}

void KeyList::visit_elements(const Field& field, ElementsMember& elements) {
  add(field.key, "named mappings", "left out", "", field.meaning);
  elements.use_prototype([&](VariantMember& element) { list_types(field.key, element); });
}

void KeyList::visit_kind(const Field& field, VariantMember& variant) {
  std::string range;
  std::vector<KnownKey> types;
  for (std::size_t i = 0; i < variant.count(); ++i) {
    KeyList below(types, path_);
    below.list_type("", [&](Fields& fields) { variant.declare_prototype(i, fields); });
    range += (range.empty() ? "" : " | ") + below.card_.word;
  }
  add(field.key, "word", "required", range, field.meaning);
  keys_.insert(keys_.end(), types.begin(), types.end());
}

void KeyList::visit_form(const Field& field, VariantMember& variant) {
  add(field.key, "one of the forms below", field.needed ? "required" : "left out", "", field.meaning);
  const Card own = card_;  // the card is that of the type whose form this is
  list_types(field.key, variant);
  card_ = own;
}

void KeyList::list_types(const std::string& key, VariantMember& variant) {
  for (std::size_t i = 0; i < variant.count(); ++i)
    list_type(key, [&](Fields& fields) { variant.declare_prototype(i, fields); });
}

void KeyList::list_type(const std::string& key, const Declare& declare_type) {
  std::vector<KnownKey> below;
  KeyList inner(below, "");
  declare_type(inner);
  card_ = inner.card_;
  const std::string head = key.empty() ? "" : key + ".", at = head + card_.word;
  // The word is a key of its own (`revolute: [a, b]`, `plane: {...}`) or only names the type (`law: wet`).
  KnownKey type{at, "type", "", "", card_.meaning};
  if (!below.empty() && below.front().path == card_.word) {
    type = below.front();
    type.meaning = type.meaning == card_.meaning ? card_.meaning : card_.meaning + "; value: " + type.meaning;
    below.erase(below.begin());
  }
  add(at, type.unit, type.fallback, type.range, type.meaning);
  for (const KnownKey& k : below) {
    const bool nested = k.path.starts_with(card_.word + ".");
    add((nested ? head : at + ".") + k.path, k.unit, k.fallback, k.range, k.meaning);
  }
}

}  // namespace subsoil::sim
