#pragma once
#include <vector>

#include "libsim/io/run_writer.hpp"
#include "libsim/setup/sketch.hpp"

namespace subsoil::sim {

/// What frames hold of a mechanism beside its surfaces: outlines of the bodies that have none, springs and links,
/// joints and markers, all in the plane z = 0.
class MechanismFrames {
 public:
  explicit MechanismFrames(const Scenario& scenario);

  const Sketch& sketch() const { return sketch_; }
  /// Adds the blocks to a frame's list: an outline per body first, then what deforms.
  void list(std::vector<OutputSurface>& surfaces) const;
  /// The pose of every listed outline, and the vertices of what deforms, at a pose of the machine.
  void take(const Poses& poses, std::vector<dem::Pose>& placed, std::vector<std::vector<Vec3>>& deformed) const;

 private:
  /// Points of several bodies that one block holds, body by body.
  struct Cloud {
    std::string name;
    std::vector<std::pair<int, Vec2>> points;
    bool paired;  ///< two and two make a line
  };
  void gather();

  Sketch sketch_;
  std::vector<std::pair<int, OutputSurface>> outlines_;  ///< with the body that carries it
  std::vector<Cloud> clouds_;
};

}  // namespace subsoil::sim
