#pragma once
#include <optional>
#include <string>

#include "libmbd/base/function.hpp"
#include "libsim/keys/fields.hpp"

/// A boundary that a controller presses onto the soil.
namespace subsoil::sim {

struct ServoSection {
  mbd::Function load, pressure;   // N, Pa; one of them
  Vec3 along{0, -1, 0};           // in which the load pushes
  double limit = required;        // m/s
  std::optional<double> gain;     // m/(N s)
  std::optional<double> lag;      // s
  double integral = 0, rate = 0;  // m/(N s^2), m/N
};
void describe(Fields& v, ServoSection& s);

struct Checks;
void check_servo(Checks& checks, const std::string& path, const ServoSection& servo);

}  // namespace subsoil::sim
