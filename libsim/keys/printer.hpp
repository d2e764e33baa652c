#pragma once
#include <map>
#include <string>
#include <vector>

#include "libsim/keys/fields.hpp"

namespace subsoil::sim {

/// The visitor of declarations that prints a struct's values below a node: the explicit copy, `new`.
class Printer final : public Fields {
 public:
  Printer(Node& node, bool comments) : node_(node), comments_(comments) {}

  void card(const char* word, const char*) override { word_ = word; }
  void visit_value(const Field& field, Value& value) override;
  void visit_compound(const Field& field, Compound& compound) override { compound.print(*this, field); }
  void visit_section(const Field& field, SectionMember& section) override;
  void visit_list(const Field& field, ListMember& list) override;
  void visit_named(const Field& field, NamedMember& named) override;
  void visit_elements(const Field& field, ElementsMember& elements) override;
  void visit_kind(const Field& field, VariantMember& variant) override;
  void visit_form(const Field& field, VariantMember& variant) override;
  void visit_inline_form(VariantMember& variant) override { variant.declare_held(*this); }

  // ---- for words that use several keys -----------------------------------------------------------------------------
  /// The one place where a key is printed. A null value is one that is left out.
  void leaf(const std::string& key, Node value, const std::string& meaning, const std::string& range = {});
  const std::string& word() const { return word_; }
  PrintScope scope() const { return {n_, body_names_}; }
  std::string body_name(int index) const;
  void know_body(const std::string& name) { body_names_.push_back(name); }
  /// States in place of the meaning where the value of a key is from.
  void remark(const std::string& key, std::string remark) { remarks_[key] = std::move(remark); }

 private:
  std::string comment(const std::string& meaning, const std::string& range) const;
  Node named_items(std::size_t size, const std::function<const std::string&(std::size_t)>& name,
                   const std::function<void(std::size_t, Printer&)>& print_item) const;

  Node& node_;
  bool comments_ = false;
  std::string word_;         // of the last card
  std::optional<double> n_;  // the exponent of this mapping
  std::vector<std::string> body_names_{"ground"};
  std::map<std::string, std::string> remarks_;
};

/// Values of a declaration as a document.
Node print_all(const Declare& declare_value, bool comments);

}  // namespace subsoil::sim
