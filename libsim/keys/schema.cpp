#include "libsim/keys/schema.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"

namespace subsoil::sim {
namespace {

/// Names become columns and groups of files (name_fault).
constexpr const char* fit_names = R"(^(?!ground$)[^./,\[\]"\n\t]+$)";

Json include_form() {
  return {{"description",
           "files whose keys are merged into this mapping; own keys win, a key without value takes one away"},
          {"anyOf", {text_form(), list_form(text_form())}}};
}

Json or_null(Json form) {
  if (form.contains("anyOf")) {
    form["anyOf"].push_back({{"type", "null"}});
    return form;
  }
  Json wrapped = Json::object();
  if (form.contains("description")) {
    wrapped["description"] = form["description"];
    form.erase("description");
  }
  wrapped["anyOf"] = {std::move(form), {{"type", "null"}}};
  return wrapped;
}

Json described(const Json& form) {
  return form.contains("description") ? Json{{"description", form["description"]}} : Json::object();
}

std::string details(const Value& value, const std::string& fallback) {
  std::string text = value.what() == "1" ? "number without unit" : value.what();
  if (!value.range().empty()) text += ", " + value.range();
  if (!fallback.empty() && fallback != "required") text += "; default: " + fallback;
  return text;
}

}  // namespace

void Schema::Mapping::take(const Mapping& other) {
  properties.update(other.properties);
  required.insert(required.end(), other.required.begin(), other.required.end());
  rules.insert(rules.end(), other.rules.begin(), other.rules.end());
  excuses.insert(other.excuses.begin(), other.excuses.end());
  choices.insert(choices.end(), other.choices.begin(), other.choices.end());
}

// ---- keys ----------------------------------------------------------------------------------------------------------

void Schema::add(const Field& field, Json value, const std::string& more) {
  std::string text = field.meaning;
  if (!field.cure.empty()) text += "; " + field.cure;
  if (!more.empty()) text += fmt::format(" ({})", more);
  Json form{{"description", text}};
  form.update(value);
  mapping_.properties[field.key] = shared_.part ? or_null(std::move(form)) : std::move(form);
  if (field.needed && !shared_.part) mapping_.required.push_back(field.key);
}

void Schema::rule(Json rule) {
  if (!shared_.part) mapping_.rules.push_back(std::move(rule));
}

void Schema::visit_value(const Field& field, Value& value) {
  static const std::vector<std::string> no_bodies{"ground"};
  const Node held = value.print({.n = {}, .bodies = no_bodies, .symbols = true});
  add(field, value.schema(), details(value, KeyList::fallback(held, field.needed)));
}

void Schema::visit_section(const Field& field, SectionMember& section) {
  Schema below(shared_, child(field.key));
  section.prototype(below);
  Field whole = field;
  whole.needed = field.needed || (section.when == SectionMember::When::always && below.requires_keys());
  add(whole, below.object());
}

void Schema::visit_list(const Field& field, ListMember& list) {
  Schema below(shared_, child(field.key));
  list.declare_prototype(below);
  add(field, list_form(below.object()), "a list");
}

void Schema::visit_named(const Field& field, NamedMember& named) {
  Schema below(shared_, child(field.key));
  named.declare_prototype(below);
  add(field, names_of(below.object()), "by names of your own");
}

void Schema::visit_elements(const Field& field, ElementsMember& elements) {
  elements.use_prototype([&](VariantMember& element) {
    Schema below(shared_, child(field.key));
    below.visit_inline_form(element);
    add(field, names_of(below.object()), "by names of your own");
  });
}

void Schema::visit_kind(const Field& field, VariantMember& variant) {
  const Choice choice = choice_of(field.key, variant);
  std::vector<std::string> words;
  std::string meanings;
  for (const Alternative& a : choice.alternatives) {
    words.push_back(a.card.word);
    meanings += fmt::format("{}{}: {}", meanings.empty() ? "" : "; ", a.card.word, a.card.meaning);
  }
  add(field, words_form(words), meanings);
  mapping_.choices.push_back(choice);
}

void Schema::visit_form(const Field& field, VariantMember& variant) {
  Schema below(shared_, child(field.key));
  below.visit_inline_form(variant);
  Json form = below.object();
  if (const auto alone = variant.alone()) {
    const Alternative& type = below.mapping_.choices.front().alternatives[*alone];
    form = either({type.mapping.properties[type.card.word], form});
  }
  add(field, std::move(form));
}

void Schema::visit_inline_form(VariantMember& variant) { mapping_.choices.push_back(choice_of("", variant)); }

void Schema::choose_by_key(const std::vector<Outline>& types) {
  Choice choice;
  for (const Outline& type : types) {
    Schema below(shared_, path_);
    type(below);
    choice.alternatives.push_back({below.card_, below.mapping_});
  }
  mapping_.choices.push_back(std::move(choice));
}

Schema::Alternative Schema::alternative(const Declare& declare_type) const {
  Schema below(shared_, child(card_shown_by(declare_type).word));
  declare_type(below);
  return {below.card_, below.mapping_};
}

Schema::Choice Schema::choice_of(const std::string& key, VariantMember& variant) const {
  Choice choice{.key = key, .alternatives = {}};
  for (std::size_t i = 0; i < variant.count(); ++i)
    choice.alternatives.push_back(alternative([&](Fields& fields) { variant.declare_prototype(i, fields); }));
  return choice;
}

// ---- mappings ------------------------------------------------------------------------------------------------------

std::string Schema::part_name() const {
  std::string name = "part";
  for (const char c : path_.empty() ? "" : "." + path_) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '.';
    name += plain ? c : '-';
  }
  return name;
}

Json Schema::object() {
  const std::string part = part_name();
  Json form{{"type", "object"}};
  if (shared_.part) {
    form.update(closed(mapping_));
    shared_.definitions[part] = text_.empty() ? form : either({form, text_form(text_)});
    return reference(part);
  }
  form["if"] = {{"required", Json::array({"include"})}};
  form["then"] = reference(part);
  form["else"] = closed(mapping_);
  return text_.empty() ? form : either({form, text_form(text_)});
}

Json Schema::names_of(const Json& item) const {
  return {{"type", "object"},
          {"propertyNames", {{"pattern", fit_names}}},
          {"properties", {{"include", include_form()}}},
          {"additionalProperties", shared_.part ? or_null(item) : item}};
}

/// No other keys than these. Where words choose among types it is said for each of them.
Json Schema::closed(const Mapping& mapping) const {
  if (!mapping.choices.empty()) return one_of(mapping);
  Json form{{"properties", mapping.properties}, {"additionalProperties", false}};
  form["properties"]["include"] = include_form();
  Json rules = mapping.rules, required = Json::array();
  if (rules.is_null()) rules = Json::array();
  for (const std::string& key : mapping.required) {
    auto excuse = mapping.excuses.find(key);
    if (excuse == mapping.excuses.end()) excuse = mapping.excuses.find("");
    if (excuse == mapping.excuses.end())
      required.push_back(key);
    else
      rules.push_back({{"anyOf", {{{"required", Json::array({key})}}, excuse->second}}});
  }
  if (!required.empty()) form["required"] = required;
  if (!rules.empty()) form["allOf"] = rules;
  return form;
}

/// The keys that all types share are only described outside of the types, so that a fault in one is said once.
Json Schema::one_of(Mapping mapping) const {
  const Choice choice = mapping.choices.front();
  mapping.choices.erase(mapping.choices.begin());
  Json properties = Json::object(), types = Json::array(), words = Json::array();
  for (const auto& [key, form] : mapping.properties.items())
    properties[key] = key == choice.key ? form : described(form);
  for (const Alternative& type : choice.alternatives) {
    const std::string& word = type.card.word;
    Json condition{{"required", Json::array({choice.key.empty() ? word : choice.key})}};
    words.push_back(condition);
    if (choice.key.empty())
      properties[word] = {{"description", type.card.meaning}};
    else
      condition["properties"] = {{choice.key, {{"const", word}}}};
    Mapping whole = mapping;
    whole.take(type.mapping);
    types.push_back({{"if", condition}, {"then", closed(whole)}});
  }
  Json form{{"properties", properties}, {"allOf", types}};
  const bool needed = std::find(mapping.required.begin(), mapping.required.end(), choice.key) != mapping.required.end();
  if (!choice.key.empty() && needed) form["required"] = Json::array({choice.key});
  if (choice.key.empty() && !shared_.part) form["oneOf"] = words;
  return form;
}

}  // namespace subsoil::sim
