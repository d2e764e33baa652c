#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libsim/document/document.hpp"
#include "libsim/document/refusal.hpp"
#include "libsim/keys/range.hpp"

/// Nodes of a document taken apart; each throws a Refusal when the node is something else.
namespace subsoil::sim {

const std::string& scalar_of(const Node& node);
const Node& mapping_of(const Node& node);
/// Of a list its items, else the node itself.
std::vector<const Node*> items_of(const Node& node);
/// `1 2 3 mm`, or [1 mm, 2 mm, 3 mm]; as many as asked for, 0: any number.
std::vector<double> numbers_of(const Node& node, const std::string& unit, std::size_t count,
                               std::optional<double> n = {});
long whole_number(const Node& node, const Range& range, const std::string& cure = {});
void check_range(double value, const Range& range, const std::string& unit, const std::string& cure = {});
/// Names become columns such as `shovel.x` and groups of files; null when the name is fit for that.
const char* name_fault(const std::string& name);

/// A list of scalars on one line.
Node sequence(const std::vector<std::string>& texts);

}  // namespace subsoil::sim
