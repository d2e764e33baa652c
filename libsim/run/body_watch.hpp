#pragma once
#include <array>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Reports that a surface of the machine reaches through a closed wall or the floor that it did not pass when the
/// run began: bodies meet spheres alone, and go through walls as if there were none. Each wall once of each surface.
class BodyWatch {
 public:
  BodyWatch(const Scenario& scenario, const World& world);

  /// At the first look they begin where they are.
  std::vector<std::string> look(const coupling::Simulation& simulation);
  void archive(Archive& a);

 private:
  struct Watched {
    std::size_t surface = 0;  ///< in World::surfaces
    std::vector<Vec3> points;
    std::array<bool, 6> through{};  ///< by face: when the run began, or reported
  };
  /// Faces beyond which a point of it lies by more than the margin, before the face and not past its edges.
  std::array<bool, 6> beyond(const Watched& one, const coupling::Simulation& simulation) const;

  const World& world_;
  Vec3 low_, high_;  ///< of the container
  std::array<bool, 6> closed_{};
  double margin_ = 0;  ///< m
  std::vector<Watched> all_;
  bool begun_ = false;
};

}  // namespace subsoil::sim
