#include "libsim/document/node.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace subsoil::sim {

Node Node::of(std::string text) {
  Node node;
  node.kind = Kind::scalar;
  node.scalar = std::move(text);
  return node;
}
Node Node::list(bool flow) {
  Node node;
  node.kind = Kind::sequence;
  node.flow = flow;
  return node;
}
Node Node::mapping(bool flow) {
  Node node;
  node.kind = Kind::mapping;
  node.flow = flow;
  return node;
}

const Node::Entry* Node::find(std::string_view key) const {
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.key == key; });
  return found == entries.end() ? nullptr : &*found;
}
Node::Entry* Node::find(std::string_view key) { return const_cast<Entry*>(static_cast<const Node&>(*this).find(key)); }
Node& Node::add(const std::string& key, Node value) {
  kind = Kind::mapping;
  entries.push_back({key, value.place, std::move(value)});
  return entries.back().value;
}

std::string Node::one_line() const {
  std::string text;
  if (kind == Kind::scalar) {
    text = scalar;
  } else if (kind == Kind::null) {
    text = "(nothing)";
  } else if (kind == Kind::sequence) {
    text = "[";
    for (const Node& item : items) text += (text.size() > 1 ? ", " : "") + item.one_line();
    text += "]";
  } else {
    text = "{";
    for (const Entry& e : entries)
      text += fmt::format("{}{}: {}", text.size() > 1 ? ", " : "", e.key, e.value.one_line());
    text += "}";
  }
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

namespace {

// ---- Node -> YAML --------------------------------------------------------------------------------------------------

/// Plain unless YAML would take it for something else.
std::string quoted(const std::string& text) {
  static constexpr std::string_view special = ":{}[],&*#?|-<>=!%@`\"'\\\n\t";
  const bool number_like = !text.empty() && (text[0] == '-' || text[0] == '+') && text.size() > 1 && text[1] != ' ';
  bool plain = !text.empty() && text.front() != ' ' && text.back() != ' ' && text != "~" && text != "null";
  for (std::size_t i = 0; plain && i < text.size(); ++i) {
    const bool inside = i > 0 && (text[i] == '-' || text[i] == '%' || text[i] == '=' || text[i] == '\'');
    if (special.find(text[i]) != std::string_view::npos && !inside && !(i == 0 && number_like)) plain = false;
  }
  if (plain) return text;
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (c == '\n') {
      result += "\\n";
    } else if (c == '\t') {
      result += "\\t";
    } else {
      result += c;
    }
  }
  return result + "\"";
}

std::string flow_text(const Node& node) {
  if (node.kind == Node::Kind::scalar) return quoted(node.scalar);
  if (node.kind == Node::Kind::null) return "~";
  std::vector<std::string> parts;
  for (const Node& item : node.items) parts.push_back(flow_text(item));
  for (const Node::Entry& e : node.entries) parts.push_back(quoted(e.key) + ": " + flow_text(e.value));
  const bool list = node.kind == Node::Kind::sequence;
  return fmt::format("{}{}{}", list ? '[' : '{', fmt::join(parts, ", "), list ? ']' : '}');
}

void block_text(const Node& node, int indent, bool first_inline, std::string& out) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  bool first = first_inline;
  const auto lead = [&] { return std::exchange(first, false) ? std::string{} : margin; };
  for (const Node& item : node.items) {
    out += lead() + "- ";
    const bool flow = item.flow || item.kind == Node::Kind::scalar || (item.items.empty() && item.entries.empty());
    if (flow) {
      out += flow_text(item) + "\n";
    } else {
      block_text(item, indent + 2, true, out);
    }
  }
  for (const Node::Entry& e : node.entries) {
    const Node& value = e.value;
    const bool flow = value.flow || value.kind == Node::Kind::scalar || (value.items.empty() && value.entries.empty());
    std::string line = quoted(e.key) + ":" + (flow ? " " + flow_text(value) : "");
    if (!value.comment.empty()) {
      const std::size_t width = line.size() < 40 ? 40 - line.size() : 1;
      line += std::string(width, ' ') + "# " + value.comment;
    }
    out += lead() + line + "\n";
    if (!flow) block_text(value, indent + 2, false, out);
  }
}

}  // namespace

std::string emit(const Node& node) {
  std::string text;
  block_text(node, 0, false, text);
  return text;
}

}  // namespace subsoil::sim
