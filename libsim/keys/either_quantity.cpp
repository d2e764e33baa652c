#include "libsim/keys/either_quantity.hpp"

#include "libsim/document/quantity.hpp"
#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/nodes.hpp"

namespace subsoil::sim {

void EitherQuantity::read(const Node& node, const ReadScope& scope) {
  const auto in = [&](const char* unit) -> std::optional<double> {
    try {
      return numbers_of(node, unit, 1, scope.n).front();
    } catch (const std::invalid_argument&) {
      return {};
    }
  };
  value_ = in(unit_), other_ = value_ ? std::nullopt : in(other_unit_);
  if (!value_ && !other_) throw Refusal(std::string("needs ") + either_);
  if (!((value_ ? *value_ : *other_) > 0)) throw Refusal("must be above zero");
}

Node EitherQuantity::print(const PrintScope&) const {
  if (value_) return Node::of(format_quantity(*value_, unit_));
  return other_ ? Node::of(format_quantity(*other_, other_unit_)) : Node{};
}

std::string EitherQuantity::what() const { return std::string(unit_) + " or " + other_unit_; }

Json EitherQuantity::schema() const { return either({number_form(unit_), number_form(other_unit_)}); }

}  // namespace subsoil::sim
