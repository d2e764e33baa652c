#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

std::vector<MeasureColumn> columns_of(VectorPart part, const char* unit) {
  if (part == VectorPart::both) return {{"x", unit}, {"y", unit}};
  return {{"", unit}};
}

std::vector<MeasureColumn> columns_of(WrenchPart part) {
  if (part == WrenchPart::all) return {{"x", "N"}, {"y", "N"}, {"moment", "N m"}};
  return {{"", part == WrenchPart::moment ? "N m" : "N"}};
}

void put(VectorPart part, Vec2 value, std::span<double> out) {
  if (part == VectorPart::both) {
    out[0] = value.x, out[1] = value.y;
  } else {
    out[0] = part == VectorPart::x ? value.x : part == VectorPart::y ? value.y : length(value);
  }
}

void put(WrenchPart part, Vec2 force, double moment, std::span<double> out) {
  if (part == WrenchPart::all) {
    out[0] = force.x, out[1] = force.y, out[2] = moment;
  } else if (part == WrenchPart::moment) {
    out[0] = moment;
  } else {
    out[0] = part == WrenchPart::x ? force.x : part == WrenchPart::y ? force.y : length(force);
  }
}

}  // namespace subsoil::mbd
