#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "libsim/base/json.hpp"
#include "libsim/keys/fields.hpp"

namespace subsoil::sim {

/// What the mappings of one schema share. Each is written twice: whole, and as a part that an included file completes
/// or that completes one. In a part no key is required, and a key without value takes an included one away.
struct SchemaShared {
  Json definitions = Json::object();  ///< the parts, and functions by their units
  bool part = false;                  ///< which of both is being written
};

/// The visitor of declarations that writes them as a JSON Schema for editors. Draft 7, since the YAML extension of
/// VS Code knows later ones in parts only. What needs more than one mapping, or the sense of a name, is left to
/// `subsoil check`; what the reader accepts is accepted.
class Schema final : public Fields {
 public:
  Schema(SchemaShared& shared, std::string path) : shared_(shared), path_(std::move(path)) {}

  void card(const char* word, const char* meaning) override { card_ = {word, meaning}; }
  void visit_value(const Field& field, Value& value) override;
  void visit_compound(const Field& field, Compound& compound) override { compound.outline(*this, field); }
  void visit_section(const Field& field, SectionMember& section) override;
  void visit_list(const Field& field, ListMember& list) override;
  void visit_named(const Field& field, NamedMember& named) override;
  void visit_elements(const Field& field, ElementsMember& elements) override;
  void visit_kind(const Field& field, VariantMember& variant) override;
  void visit_form(const Field& field, VariantMember& variant) override;
  void visit_inline_form(VariantMember& variant) override;

  // ---- for words that use several keys -----------------------------------------------------------------------------
  /// A key; `more` states unit, default and range.
  void add(const Field& field, Json value, const std::string& more = {});
  /// A rule about the keys of this mapping.
  void rule(Json rule);
  /// A required key (empty: any) may be left out where the condition holds.
  void excuse(const std::string& key, Json condition) { mapping_.excuses[key] = std::move(condition); }
  /// Text may stand in place of the mapping.
  void may_be_text(std::string pattern) { text_ = std::move(pattern); }
  /// One of several types by the word that is a key of the mapping; each declares itself.
  using Outline = std::function<void(Schema&)>;
  void choose_by_key(const std::vector<Outline>& types);
  /// What has been declared of a key, or null.
  const Json* find(const std::string& key) const {
    return mapping_.properties.contains(key) ? &mapping_.properties[key] : nullptr;
  }
  SchemaShared& shared() { return shared_; }
  const Card& card() const { return card_; }
  bool requires_keys() const { return !mapping_.required.empty(); }
  std::string child(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  /// The schema of the mapping.
  Json object();
  /// Of a mapping of names of one's own.
  Json names_of(const Json& item) const;
  static Json reference(const std::string& definition) { return {{"$ref", "#/definitions/" + definition}}; }

 private:
  struct Alternative;
  struct Choice {
    std::string key;  ///< that holds the word; empty: the word is a key itself
    std::vector<Alternative> alternatives;
  };
  struct Mapping {
    Json properties = Json::object();
    std::vector<std::string> required;
    std::vector<Json> rules;
    std::map<std::string, Json> excuses;
    std::vector<Choice> choices;
    void take(const Mapping& other);
  };
  struct Alternative {
    Card card;
    Mapping mapping;
  };

  Alternative alternative(const Declare& declare_type) const;
  Choice choice_of(const std::string& key, VariantMember& variant) const;
  Json closed(const Mapping& mapping) const;
  Json one_of(Mapping mapping) const;
  std::string part_name() const;

  SchemaShared& shared_;
  std::string path_;
  Card card_;
  Mapping mapping_;
  std::string text_;
};

}  // namespace subsoil::sim
