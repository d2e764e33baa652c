#include "libsim/keys/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmbd/base/fault.hpp"
#include "libsim/keys/former_keys.hpp"
#include "libsim/keys/known_keys.hpp"
#include "libsim/keys/nodes.hpp"

namespace subsoil::sim {

Place place_of(const Places& places, std::string path) {
  for (;;) {
    const auto found = places.find(path);
    if (found != places.end()) return found->second;
    if (path.empty()) return {};
    const std::size_t cut = path.find_last_of(".[");
    path.resize(cut == std::string::npos ? 0 : cut);
  }
}

const mbd::BodyState* Reading::pose_of(int index) const {
  const auto i = static_cast<std::size_t>(index);
  return index >= 0 && i < body_poses.size() ? &body_poses[i] : nullptr;
}

void read_all(const Node& document, Reading& reading, const Declare& declare_document) {
  reading.places[""] = document.place;
  Reader reader(reading, document, "");
  declare_document(reader);
  reader.finish();
}

std::vector<std::string> words_of(const VariantMember& variant) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < variant.count(); ++i) words.push_back(variant.card(i).word);
  return words;
}

// ---- faults --------------------------------------------------------------------------------------------------------

void Reader::fault(const Node& node, const std::string& path, const std::string& rule) {
  reading_.problems.add(node.place, path, node.one_line(), rule);
}

void Reader::missing(const Field& field) {
  std::string what = field.if_missing.empty() ? field.meaning : field.if_missing;
  if (!field.cure.empty()) what += "; " + field.cure;
  if (!field.unit.empty() && field.unit != "1") what += ", in " + field.unit;
  reading_.problems.add(node_.place, child(field.key), fmt::format("is missing: {}", what));
}

namespace {

/// What other programs, or earlier versions of this one, call a key of ours, where `known` has it:
/// {theirs, ours, what is to be said}.
struct OtherWord {
  const char *theirs, *ours, *cure;
};
constexpr OtherWord other_words[] = {
    {"book every", "sample losses every", "; its name is `sample losses every` now"},
    {"diameter", "radius", "; give the `radius`, half of it"},
    {"position", "velocity", "; a move is a `velocity` times a `profile` over time, its start is the boundary's `at`"},
    {"angle", "angular velocity", "; a turn is an `angular velocity` times a `profile` over time"},
    {"speed", "velocity", "; give the `velocity`, a vector"},
    {"friction", "mu", "; friction is `mu`"},
    {"rolling friction", "mu_r", "; rolling friction is `mu_r`"},
    {"stiffness", "k_n", "; the normal stiffness is `k_n`"},
    {"duration", "end", "; the run lasts until `end`"},
};

}  // namespace

/// The nearest key of this mapping, else where else the key is known, else what is known here.
std::string Reader::cure_for(const std::string& key) const {
  const std::string present(present_of(key));
  if (!present.empty() && node_.find(present) != nullptr)
    return fmt::format("; its name is `{}` now, which stands here too", present);
  for (const OtherWord& word : other_words)
    if (key == word.theirs && std::find(known_.begin(), known_.end(), word.ours) != known_.end()) return word.cure;
  if (!nearest(key, known_)) {
    const std::string elsewhere = path_of_key(key, child(key));
    if (!elsewhere.empty()) return fmt::format("; it belongs at `{}`", elsewhere);
  }
  return suggestion(key, known_);
}

void Reader::finish() {
  if (open_) return;
  const auto known = [&](const std::string& key) {
    return std::find(known_.begin(), known_.end(), key) != known_.end();
  };
  for (const auto& [key, value] : supplied_)
    if (!known(key))
      reading_.problems.add(node_.find("combine")->place, child("combine." + key),
                            "the law has no such value; leave it out");
  for (const Node::Entry& e : node_.entries) {
    if (known(e.key)) continue;
    const std::string rule = "unknown key" + cure_for(e.key);
    if (e.value.kind == Node::Kind::scalar) {
      reading_.problems.add(e.place, child(e.key), e.value.one_line(), rule);
    } else {
      reading_.problems.add(e.place, child(e.key), rule);
    }
  }
}

std::optional<std::size_t> Reader::find_type(const Node& node, const std::string& path,
                                             const std::vector<std::string>& words) {
  std::optional<std::size_t> found;
  int count = 0;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (node.find(words[i]) != nullptr) found = i, ++count;
  if (count == 1) return found;
  open_ = true;
  if (count > 1) {
    fault(node, path, "holds two types; keep one of them");
  } else {
    const std::string first = node.entries.empty() ? "" : node.entries.front().key;
    fault(node, path, "does not say what it is" + suggestion(first, words));
  }
  return {};
}

void Reader::check_name(const Node::Entry& entry, const std::string& path) {
  if (const char* wrong = name_fault(entry.key)) reading_.problems.add(entry.place, path + "." + entry.key, wrong);
  if (entry.key == "ground")
    reading_.problems.add(entry.place, path + "." + entry.key, "`ground` is always there; take another name");
}

// ---- values --------------------------------------------------------------------------------------------------------

std::string Reader::child(const std::string& key) const {
  return alone_ ? path_ : path_.empty() ? key : path_ + "." + key;
}

const Node::Entry* Reader::entry_of(std::string_view key) const {
  if (const Node::Entry* entry = node_.find(key)) return entry;
  const std::string_view former = former_of(key);
  return former.empty() ? nullptr : node_.find(former);
}

void Reader::leaf(const Field& field, const Use& use) {
  known_.push_back(field.key);
  const Node::Entry* entry = entry_of(field.key);
  if (entry != nullptr && entry->key != field.key) {
    known_.push_back(entry->key);
    reading_.former.push_back({child(field.key), entry->key, field.key});
  }
  if (entry == nullptr) {
    if (field.needed) missing(field);
    return;
  }
  reading_.places[child(field.key)] = entry->value.place;
  if (entry->value.kind == Node::Kind::null) {
    // Of the value, which `--set` may have emptied in a file that has one.
    reading_.problems.add(entry->value.place, child(field.key), "has no value; give one, or leave the key out");
    return;
  }
  try {
    use(entry->value);
  } catch (const std::invalid_argument& e) {
    fault(entry->value, child(field.key), e.what());
  }
}

bool Reader::take_supplied(const Field& field, Value& value) {
  const auto found = supplied_.find(field.key);
  if (found == supplied_.end() || holds(field.key) || !value.supply(found->second)) return false;
  known_.push_back(field.key);
  return true;
}

void Reader::visit_value(const Field& field, Value& value) {
  if (take_supplied(field, value)) return;
  if (holds(field.key)) value.given();
  leaf(field, [&](const Node& node) {
    if (n_missing_ && field.unit.find("(n") != std::string::npos) return;  // n itself is reported
    value.read(node, {field, reading_, n_});
    if (const std::string* const file = value.input_file()) reading_.input_files.push_back(*file);
  });
  if (!field.exponent) return;
  n_ = value.number();
  n_missing_ = !n_;
}

// ---- structure -----------------------------------------------------------------------------------------------------

void Reader::read_mapping(const Node& node, const std::string& path, const Declare& declare_value) {
  reading_.places[path] = node.place;
  if (node.kind != Node::Kind::mapping) {
    fault(node, path, "must be a mapping: `key: value` lines, or {key: value, ...}");
    return;
  }
  Reader reader(reading_, node, path);
  declare_value(reader);
  reader.finish();
}

void Reader::visit_section(const Field& field, SectionMember& section) {
  const std::string path = child(field.key);
  if (section.when == SectionMember::When::always && !holds(field.key)) {
    known_.push_back(field.key);  // its required keys are then missing by their full path
    Node nothing = Node::mapping();
    nothing.place = node_.place;
    read_mapping(nothing, path, section.declare);
    return;
  }
  leaf(field, [&](const Node& node) {
    if (section.when == SectionMember::When::needed) mapping_of(node);
    read_mapping(node, path, section.declare);
  });
}

void Reader::visit_list(const Field& field, ListMember& list) {
  leaf(field, [&](const Node& node) {
    if (node.kind != Node::Kind::sequence) throw Refusal("must be a list: lines that start with `- `");
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      list.append();
      read_mapping(node.items[i], fmt::format("{}[{}]", child(field.key), i),
                   [&](Fields& fields) { list.declare_item(list.size() - 1, fields); });
    }
  });
}

void Reader::visit_named(const Field& field, NamedMember& named) {
  leaf(field, [&](const Node& node) {
    for (const Node::Entry& e : mapping_of(node).entries) {
      named.append();
      const std::size_t last = named.size() - 1;
      named.set_name(last, e.key);
      check_name(e, child(field.key));
      read_mapping(e.value, child(field.key) + "." + e.key, [&](Fields& fields) { named.declare_item(last, fields); });
    }
  });
}

void Reader::visit_elements(const Field& field, ElementsMember& elements) {
  leaf(field, [&](const Node& node) {
    for (const Node::Entry& e : mapping_of(node).entries) {
      check_name(e, child(field.key));
      const std::string path = child(field.key) + "." + e.key;
      reading_.places[path] = e.value.place;
      elements.append(e.key, [&](VariantMember& element) { return read_form(e.value, path, element); });
    }
  });
}

void Reader::visit_kind(const Field& field, VariantMember& variant) {
  open_ = !holds(field.key);
  leaf(field, [&](const Node& node) {
    const std::string& word = scalar_of(node);
    const std::vector<std::string> words = words_of(variant);
    const auto found = std::find(words.begin(), words.end(), word);
    if (found == words.end()) {
      open_ = true;  // whose parameters the other keys are cannot be told
      throw Refusal("unknown " + field.key + suggestion(word, words));
    }
    variant.hold(static_cast<std::size_t>(found - words.begin()));
    read_held(variant);
  });
}

void Reader::read_held(VariantMember& variant) {
  const std::size_t before = reading_.problems.count();
  variant.declare_held(*this);
  if (reading_.problems.count() != before) return;
  try {
    variant.check_held();
  } catch (const mbd::KeyFault& e) {
    if (const Node::Entry* entry = entry_of(e.key))
      fault(entry->value, child(e.key), e.rule);
    else
      reading_.problems.add(node_.place, path_, e.what());
  } catch (const std::invalid_argument& e) {
    reading_.problems.add(node_.place, path_, e.what());
  }
}

bool Reader::read_form(const Node& node, const std::string& path, VariantMember& variant) {
  if (node.kind != Node::Kind::mapping) {
    fault(node, path, "must be a mapping: `key: value` lines, or {key: value, ...}");
    return false;
  }
  Reader reader(reading_, node, path);
  const auto type = reader.find_type(node, path, words_of(variant));
  if (type) {
    variant.hold(*type);
    reader.read_held(variant);
  }
  reader.finish();
  return type.has_value();
}

void Reader::read_alone(const Node& node, const std::string& path, VariantMember& variant, std::size_t type) {
  Node mapping = Node::mapping();
  mapping.place = node.place;
  mapping.add(variant.card(type).word, node);
  Reader reader(reading_, mapping, path);
  reader.alone_ = true;
  variant.hold(type);
  reader.read_held(variant);
}

void Reader::visit_form(const Field& field, VariantMember& variant) {
  leaf(field, [&](const Node& node) {
    const auto alone = variant.alone();
    if (alone && node.kind == Node::Kind::scalar) {
      read_alone(node, child(field.key), variant, *alone);
    } else {
      read_form(node, child(field.key), variant);
    }
  });
}

void Reader::visit_inline_form(VariantMember& variant) {
  const auto type = find_type(node_, path_, words_of(variant));
  if (!type) return;
  variant.hold(*type);
  read_held(variant);
}

}  // namespace subsoil::sim
