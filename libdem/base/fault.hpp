#pragma once
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>

namespace subsoil::dem {

/// A contact, sphere or state that no longer makes sense: the run stops, reports where and keeps what it has. Who
/// handles it reads the fields; the text is for people alone.
struct BedFault : std::runtime_error {
  enum class Kind {
    speed,          ///< a sphere is faster than BedOptions::speed_limit, m/s, or its motion is not a number
    overlap,        ///< a contact is deeper than BedOptions::overlap_limit, a share of the radius
    position,       ///< a position is not finite
    periodic_side,  ///< a surface comes near to a periodic side; value and limit are distances, m
    force,          ///< one of a user is not finite (value 0), or substitutions for it converge too slowly: their ratio
  };
  static constexpr std::uint32_t no_sphere = ~std::uint32_t{0};
  struct Facts {
    Kind kind;
    double time;                       ///< s
    std::uint32_t sphere = no_sphere;  ///< its id
    double value = 0, limit = 0;       ///< in the unit of the kind
  };

  BedFault(const Facts& given, const std::string& text) : std::runtime_error(timed(given.time, text)), facts(given) {}

  Facts facts;

 private:
  static std::string timed(double time, const std::string& text) {
    char start[48];
    std::snprintf(start, sizeof start, "t = %.9g s: ", time);
    return start + text;
  }
};

}  // namespace subsoil::dem
