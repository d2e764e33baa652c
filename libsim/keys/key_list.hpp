#pragma once
#include <string>
#include <vector>

#include "libsim/keys/fields.hpp"
#include "libsim/keys/known_keys.hpp"

namespace subsoil::sim {

/// The visitor of declarations that lists their keys: `explain`, docs/reference/keys.md.
class KeyList final : public Fields {
 public:
  KeyList(std::vector<KnownKey>& keys, std::string path) : keys_(keys), path_(std::move(path)) {}

  void card(const char* word, const char* meaning) override { card_ = {word, meaning}; }
  void visit_value(const Field& field, Value& value) override;
  void visit_compound(const Field& field, Compound& compound) override { compound.list(*this, field); }
  void visit_section(const Field& field, SectionMember& section) override;
  void visit_list(const Field& field, ListMember& list) override;
  void visit_named(const Field& field, NamedMember& named) override;
  void visit_elements(const Field& field, ElementsMember& elements) override;
  void visit_kind(const Field& field, VariantMember& variant) override;
  void visit_form(const Field& field, VariantMember& variant) override;
  void visit_inline_form(VariantMember& variant) override { list_types("", variant); }

  const Card& card() const { return card_; }
  void add(const std::string& key, const std::string& unit, const std::string& fallback, const std::string& range,
           const std::string& meaning);
  /// What stands in the column of defaults: of a null value "required" or "left out".
  static std::string fallback(const Node& value, bool needed);

 private:
  void list_types(const std::string& key, VariantMember& variant);
  /// Keys of one alternative, below `key.word`.
  void list_type(const std::string& key, const Declare& declare_type);
  std::string child(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

  std::vector<KnownKey>& keys_;
  std::string path_;
  Card card_;
};

}  // namespace subsoil::sim
