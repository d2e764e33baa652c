#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Reports when soil that a tool disturbs reaches a wall of the container: then the bin is too small for the tool.
///
/// Soil at a wall is disturbed when more than 5 % of the spheres that lay within one mean diameter of the wall when the
/// means began have moved since by more than half a mean radius. What a wall carries shows nothing of this: by momentum
/// the walls carry the draft however large the bin is. In a moving bed they are those that lay at floor and side walls,
/// or before its end ahead, against the places that they had at rest.
class WallWatch {
 public:
  static constexpr double share = 0.05, moved = 0.5;

  /// Where the spheres are now is where they lay.
  void begin(const World& world);
  bool has_begun() const { return !lay_.empty(); }
  /// Walls that were reached since the last look, each once.
  std::vector<std::string> look(const World& world);
  /// Whether any was by the last look; unknown where the means never began.
  std::optional<bool> any_reached() const;
  void archive(Archive& a) { a("walls", walls_)("lay", lay_)("radius", radius_); }

 private:
  void begin(const World& world, const dem::MovingBed& window);
  std::vector<std::string> look(const World& world, const dem::MovingBed& window);
  struct Wall {
    std::string name;
    std::vector<std::uint32_t> ids;  ///< of the spheres that lay at it, rising
    bool reached = false;
    void archive(Archive& a) { a("name", name)("ids", ids)("reached", reached); }
  };
  std::vector<Wall> walls_;
  std::vector<Vec3> lay_;  ///< by id; in a moving bed of no matter
  double radius_ = 0;      ///< mean, m
};

}  // namespace subsoil::sim
