#pragma once
#include <optional>
#include <vector>

#include "apps/build/world.hpp"

namespace subsoil::app {

/// The meshed surfaces of the machine that work in the soil, taken as one tool, and how far it has come.
///
/// Steady work is taken to begin when the tool's lowest point (its tip) has travelled, from the soil's near face on,
/// the tool's length in soil plus its depth in soil: then the soil ahead of it and beside it has been sheared along its
/// whole length. It ends when the tip is one depth from the far face, where the end wall begins to be felt.
class ToolProgress {
 public:
  /// Travel is along x, in the direction of the tool's velocity at the start (+x when it stands).
  explicit ToolProgress(const World& world);

  bool exists() const { return !parts_.empty() && far_face_ > near_face_; }
  struct Place {
    Vec3 tip;           ///< lowest point, world
    double depth = 0;   ///< below the soil's mean surface, m; negative: above
    double length = 0;  ///< extent along x of what is below the surface, m
    double speed = 0;   ///< of the tip's body along the travel, m/s
  };
  Place place() const;
  /// When the window of steady work opens at the present place: how long it will last at the present speed (s).
  std::optional<double> window_opens() const;
  /// Estimate of when the tool will reach the soil, s from the start; 0 when it is there.
  double time_to_soil() const;

 private:
  struct Part {
    int body;
    std::vector<Vec3> vertices;  ///< body axes
  };
  const World& world_;
  std::vector<Part> parts_;
  double near_face_ = 0, far_face_ = 0, surface_ = 0;
  int direction_ = 1;
};

}  // namespace subsoil::app
