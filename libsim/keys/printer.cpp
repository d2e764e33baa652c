#include "libsim/keys/printer.hpp"

#include <fmt/format.h>

namespace subsoil::sim {

Node print_all(const Declare& declare_value, bool comments) {
  Node root = Node::mapping();
  Printer printer(root, comments);
  declare_value(printer);
  return root;
}

std::string Printer::comment(const std::string& meaning, const std::string& range) const {
  if (!comments_) return {};
  const std::size_t bar = range.find(" |");
  const bool spelled_out = meaning.find(range.substr(0, bar) + ":") != std::string::npos;
  return bar != std::string::npos && !spelled_out ? fmt::format("{}; {}", meaning, range) : meaning;
}

void Printer::leaf(const std::string& key, Node value, const std::string& meaning, const std::string& range) {
  if (value.kind == Node::Kind::null) return;
  const auto remark = remarks_.find(key);
  value.comment = remark == remarks_.end() ? comment(meaning, range) : remark->second;
  node_.add(key, std::move(value));
}

void Printer::visit_value(const Field& field, Value& value) {
  if (field.exponent) n_ = value.number();
  leaf(field.key, value.print(scope()), field.cure.empty() ? field.meaning : field.meaning + "; " + field.cure,
       value.range());
}

std::string Printer::body_name(int index) const {
  const auto i = static_cast<std::size_t>(index);
  return index >= 0 && i < body_names_.size() ? body_names_[i] : "?";
}

void Printer::visit_section(const Field& field, SectionMember& section) {
  if (!section.there) return;
  Node mapping = Node::mapping(section.flow);
  mapping.comment = comment(field.meaning, "");
  Printer printer(mapping, comments_ && !section.flow);
  printer.body_names_ = body_names_;
  section.declare(printer);
  body_names_ = printer.body_names_;
  const bool says_by_being_there = section.when == SectionMember::When::given;
  if (!mapping.entries.empty() || says_by_being_there) node_.add(field.key, std::move(mapping));
}

void Printer::visit_list(const Field& field, ListMember& list) {
  if (list.size() == 0) return;
  Node items = Node::list();
  items.comment = comment(field.meaning, "");
  for (std::size_t i = 0; i < list.size(); ++i) {
    Node& item = items.items.emplace_back(Node::mapping());
    Printer printer(item, comments_ && i == 0);
    list.declare_item(i, printer);
  }
  node_.add(field.key, std::move(items));
}

Node Printer::named_items(std::size_t size, const std::function<const std::string&(std::size_t)>& name,
                          const std::function<void(std::size_t, Printer&)>& print_item) const {
  Node mapping = Node::mapping();
  for (std::size_t i = 0; i < size; ++i) {
    Node item = Node::mapping(true);
    Printer printer(item, false);
    printer.body_names_ = body_names_;
    print_item(i, printer);
    mapping.add(name(i), std::move(item));
  }
  return mapping;
}

void Printer::visit_named(const Field& field, NamedMember& named) {
  if (named.size() == 0) return;
  Node mapping = named_items(
      named.size(), [&](std::size_t i) -> const std::string& { return named.name(i); },
      [&](std::size_t i, Printer& printer) { named.declare_item(i, printer); });
  mapping.comment = comment(field.meaning, "");
  node_.add(field.key, std::move(mapping));
}

void Printer::visit_elements(const Field& field, ElementsMember& elements) {
  if (elements.size() == 0) return;
  Node mapping = named_items(
      elements.size(), [&](std::size_t i) -> const std::string& { return elements.name(i); },
      [&](std::size_t i, Printer& printer) {
        elements.use_item(i, [&](VariantMember& element) { element.declare_held(printer); });
      });
  mapping.comment = comment(field.meaning, "");
  node_.add(field.key, std::move(mapping));
}

void Printer::visit_kind(const Field& field, VariantMember& variant) {
  leaf(field.key, Node::of(variant.card(variant.held()).word), field.meaning);
  variant.declare_held(*this);
}

void Printer::visit_form(const Field& field, VariantMember& variant) {
  Node form = Node::mapping(true);
  Printer printer(form, false);
  variant.declare_held(printer);
  if (variant.alone() == variant.held() && form.entries.size() == 1) {
    const std::string value = form.entries[0].value.scalar;
    form = Node::of(value);
  }
  form.comment = comment(field.meaning, "");
  const bool empty = form.entries.empty() && form.scalar.empty();
  if (!empty) node_.add(field.key, std::move(form));
}

}  // namespace subsoil::sim
