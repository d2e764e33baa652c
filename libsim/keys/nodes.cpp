#include "libsim/keys/nodes.hpp"

#include <fmt/format.h>

#include <cmath>

#include "libsim/base/input_limits.hpp"
#include "libsim/document/quantity.hpp"

namespace subsoil::sim {

const std::string& scalar_of(const Node& node) {
  if (node.kind != Node::Kind::scalar) throw Refusal("must be a single value, not a list or mapping");
  return node.scalar;
}

const Node& mapping_of(const Node& node) {
  if (node.kind != Node::Kind::mapping) throw Refusal("must be a mapping: `key: value` lines, or {key: value, ...}");
  return node;
}

std::vector<const Node*> items_of(const Node& node) {
  if (node.kind != Node::Kind::sequence) return {&node};
  std::vector<const Node*> items;
  for (const Node& item : node.items) items.push_back(&item);
  return items;
}

namespace {

constexpr double largest = 1e30, smallest = 1 / largest;

/// No length, mass or stiffness of a machine in soil is beyond these, in SI units; powers of them stay finite.
void check_size(double value) {
  if (std::abs(value) > largest) throw Refusal("is above 1e30 in SI units", "check number and unit");
  if (value != 0 && std::abs(value) < smallest)
    throw Refusal("is below 1e-30 in SI units", "check number and unit, or write 0 for none");
}

}  // namespace

std::vector<double> numbers_of(const Node& node, const std::string& unit, std::size_t count, std::optional<double> n) {
  std::vector<double> numbers;
  if (node.kind == Node::Kind::sequence) {  // [1, 0] or [1 m, 2 m]: each with its unit
    if (count == 1 && node.items.size() == 1)
      throw Refusal("is a list, and one value is needed",
                    "leave the brackets out; a dash and a blank begin a list too: write -1 m for a negative value");
    const Node* only = node.items.size() == 1 ? &node.items.front() : nullptr;
    if (count != 1 && only && only->kind == Node::Kind::scalar && parse_quantities(only->scalar, unit, 0, n).size() > 1)
      throw Refusal("is a list of one entry, which holds several numbers",
                    fmt::format("leave the brackets out: {}; or write each number with its unit", only->scalar));
    for (const Node& item : node.items) numbers.push_back(parse_quantity(scalar_of(item), unit, n));
  } else {
    numbers = parse_quantities(scalar_of(node), unit, count, n);
  }
  for (double& number : numbers) {
    if (count != 1 && std::abs(number) < smallest) number = 0;  // a component: rounding of whoever wrote it
    check_size(number);
  }
  if (count != 0 && numbers.size() != count)
    throw Refusal(fmt::format("holds {} numbers", numbers.size()), fmt::format("needed are {}", count));
  return numbers;
}

void check_range(double value, const Range& range, const std::string& unit, const std::string& cure) {
  if (std::isfinite(value)) check_size(value);
  if (range.contains(value)) return;
  throw Refusal(fmt::format("must be in {}{}", range.text(), unit == "1" ? "" : " " + unit), cure);
}

long whole_number(const Node& node, const Range& range, const std::string& cure) {
  const double value = parse_number(scalar_of(node));
  if (value != std::floor(value) || std::abs(value) > 9e15) throw Refusal("must be a whole number");
  check_range(value, range, "1", cure);
  return static_cast<long>(value);
}

const char* name_fault(const std::string& name) {
  if (name.empty()) return "a name must not be empty";
  if (name.size() > input_limits().name_bytes)
    return "a name is too long: it may have 200 bytes; SUBSOIL_LIMITS=name-bytes=N in the environment allows more";
  if (name.find_first_of("./,[]\"\n\t") != std::string::npos) return "a name must not hold . / , [ ] or quotes";
  return nullptr;
}

Node sequence(const std::vector<std::string>& texts) {
  Node node = Node::list(true);
  for (const std::string& text : texts) node.items.push_back(Node::of(text));
  return node;
}

}  // namespace subsoil::sim
