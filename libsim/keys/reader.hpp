#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "libsim/keys/fields.hpp"
#include "libsim/keys/reading.hpp"

namespace subsoil::sim {

/// The visitor of declarations that fills structs from a document. Every fault goes to the list of problems with its
/// place; reading continues, so that one run names them all.
class Reader final : public Fields {
 public:
  Reader(Reading& reading, const Node& node, std::string path)
      : reading_(reading), node_(node), path_(std::move(path)) {}

  /// Refuses keys that no declaration has asked for. Call once, at the end.
  void finish();

  void card(const char*, const char*) override {}
  void visit_value(const Field& field, Value& value) override;
  void visit_compound(const Field& field, Compound& compound) override { compound.read(*this, field); }
  void visit_section(const Field& field, SectionMember& section) override;
  void visit_list(const Field& field, ListMember& list) override;
  void visit_named(const Field& field, NamedMember& named) override;
  void visit_elements(const Field& field, ElementsMember& elements) override;
  void visit_kind(const Field& field, VariantMember& variant) override;
  void visit_form(const Field& field, VariantMember& variant) override;
  void visit_inline_form(VariantMember& variant) override;

  // ---- for words that use several keys -----------------------------------------------------------------------------
  using Use = std::function<void(const Node&)>;
  Reading& reading() { return reading_; }
  const Node& node() const { return node_; }
  /// Under its name or its former one (former_keys.hpp).
  bool holds(std::string_view key) const { return entry_of(key) != nullptr; }
  std::string child(const std::string& key) const;
  /// Finds a key and lets `use` take its value; turns what it throws into a problem at the value's place.
  void leaf(const Field& field, const Use& use);
  void missing(const Field& field);
  void fault(const Node& node, const std::string& path, const std::string& rule);
  void check_name(const Node::Entry& entry, const std::string& path);
  /// A key of this mapping that nothing more is declared about.
  void know(std::string key) { known_.push_back(std::move(key)); }
  /// The type is unknown, so unknown keys are not reported.
  void leave_open() { open_ = true; }
  /// A number that a rule supplies for a key of this mapping that the file leaves out; NaN: the rule is at fault.
  void supply(const std::string& key, double value) { supplied_[key] = value; }
  std::optional<double> exponent() const { return n_; }
  /// The one of `words` that is a key of `node`; reports what is wrong otherwise.
  std::optional<std::size_t> find_type(const Node& node, const std::string& path,
                                       const std::vector<std::string>& words);

 private:
  const Node::Entry* entry_of(std::string_view key) const;
  void read_mapping(const Node& node, const std::string& path, const Declare& declare_value);
  /// Reads the type that `variant` holds from this mapping and lets it check itself, once nothing else is wrong.
  void read_held(VariantMember& variant);
  bool read_form(const Node& node, const std::string& path, VariantMember& variant);
  void read_alone(const Node& node, const std::string& path, VariantMember& variant, std::size_t type);
  bool take_supplied(const Field& field, Value& value);
  std::string cure_for(const std::string& key) const;

  Reading& reading_;
  const Node& node_;
  std::string path_;
  bool alone_ = false;  // the value of the one key stands in place of the mapping
  std::vector<std::string> known_;
  std::map<std::string, double> supplied_;
  std::optional<double> n_;  // the exponent of this mapping
  bool n_missing_ = false;
  bool open_ = false;
};

std::vector<std::string> words_of(const VariantMember& variant);

}  // namespace subsoil::sim
