#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libdem/geometry/solid_outline.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Where surfaces of the machine and given boundaries come together. Neither feels the other: a run in which they pass
/// through each other stops.
class SurfaceMeeting {
 public:
  explicit SurfaceMeeting(const World& world);

  /// Names of the first pair that has met.
  std::optional<std::string> look() const;
  /// Pairs that may meet in a time, s, if bodies keep their velocity of now and boundaries their path: for `check`.
  std::vector<std::string> may_meet(const World& world, double time) const;

 private:
  struct One {
    std::string name;
    int boundary, body;
    dem::SolidOutline outline;
  };
  std::vector<One> tools_, stones_;
};

/// What helps.
extern const char* const surface_meeting_cure;

}  // namespace subsoil::sim
