#pragma once
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/contacts/contact_record.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// What fibres do to the surfaces that move: sums of the forces of single contacts, of the instants of frames. A step
/// sums the forces on a surface over all spheres and does not keep them by material, so that there is no mean of every
/// step.
class FibreDrag {
 public:
  explicit FibreDrag(const World& world);
  void take(double time, const std::vector<dem::ContactRecord>& contacts);
  struct Mean {
    std::string surface;
    Vec3 force;  ///< of the fibres on the surface, N
    std::size_t frames = 0;
  };
  /// Over the frames from `from` to `until`, of one group of World::fibres on each surface; empty of no frame.
  std::vector<Mean> means(std::size_t group, double from, double until) const;
  void archive(Archive& a) {
    if (!boundaries_.empty()) a("times", times_)("forces", forces_);
  }

 private:
  std::size_t at(std::size_t frame, std::size_t group, std::size_t surface) const {
    return (frame * world_.fibres.size() + group) * boundaries_.size() + surface;
  }
  const World& world_;
  std::vector<int> boundaries_;  ///< that move; empty without fibres
  std::vector<double> times_;    ///< s, of the frames
  std::vector<Vec3> forces_;     ///< by frame, group and boundary
};

}  // namespace subsoil::sim
