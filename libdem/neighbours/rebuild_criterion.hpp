#pragma once
#include <functional>
#include <span>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/geometry/boundary.hpp"
#include "libdem/neighbours/grid.hpp"
#include "libdem/neighbours/relative_displacement.hpp"
#include "libdem/particles/particle_store.hpp"
#include "libdem/particles/statistics.hpp"

namespace subsoil::dem {

/// How long the lists hold: until two spheres that are no pair of theirs, or a sphere and a surface, may have come
/// nearer by the skin. Two bounds, of which the smaller counts.
///
/// Paths: every step adds the longest path of its spheres, by particle block (contacts/path_bounds.hpp), which costs
/// nothing and also activates inactive candidates.
///
/// RelativeDisplacement: how far spheres have really come apart, measured when the paths no longer suffice, and since
/// then by paths. Under a tool, which pushes many the same way, it is half as much.
///
/// | data                     | written by                                 | read by      |
/// |---|---|---|
/// | stale                    | whoever changes spheres, laws or surfaces  | `lists_hold` |
/// | skin, poses, radii       | `begin`, at the end of each rebuild        | `lists_hold` |
/// | path                     | `add_path`, after each step                | `lists_hold` |
/// | measured                 | `lists_hold`                               | `lists_hold` |
///
/// All of it is asked once a step by one thread: the layout does not matter, except that measuring must not allocate.
class RebuildCriterion {
 public:
  void invalidate() { stale_ = true; }
  /// New lists: from here on they are judged.
  void begin(double skin, const ParticleStore& particles, std::span<const Boundary> boundaries,
             const ParticleStatistics& statistics, Grid grid, int threads);
  /// @param longest path of any sphere in the last step, m
  void add_path(double longest) { path_ += longest; }
  bool is_stale() const { return stale_; }
  double skin() const { return skin_; }
  /// Where things were when the lists were built, and what was measured since: what a restart needs to judge the same
  /// lists alike. `poses` and `active` are those of the boundaries then.
  Vec3 listed_place(std::size_t sphere) const { return displacement_.was(sphere); }
  const std::vector<Pose>& listed_poses() const { return listed_pose_; }
  const std::vector<char>& listed_active() const { return listed_active_; }
  void archive(Archive& a);
  /// @param same_lists both judge the same lists
  void copy(const RebuildCriterion& from, bool same_lists);
  /// May measure relative displacements. @param longest_path bound on the path of any sphere since the lists were
  /// built, by particle block, m: at most what `add_path` got
  bool lists_hold(const ParticleStore& particles, std::span<const Boundary> boundaries, double longest_path,
                  int threads);

 private:
  bool hold_within(double limit, std::span<const Boundary> boundaries, double longest_path) const;
  void measure(const ParticleStore& particles, std::span<const Boundary> boundaries, int threads);
  void measure_boundaries(const ParticleStore& particles, std::span<const Boundary> boundaries,
                          const ParticleStatistics& statistics);

  bool stale_ = true;
  double skin_ = 0;                      ///< m
  double path_ = 0;                      ///< bound on the path of any sphere since the lists were built, m
  std::vector<Pose> listed_pose_;        ///< of the boundaries, then
  std::vector<char> listed_active_;      ///< likewise
  std::vector<double> boundary_radius_;  ///< maximum distance of a shape's points from its origin, m
  RelativeDisplacement displacement_;
  bool displacement_counts_ = false;  ///< else paths alone state how long the lists hold
  struct Measured {
    bool known = false;  ///< measured for these lists
    RelativeDisplacement::Found found;
    double path = 0;               ///< `path_` then, m
    std::vector<Vec3> place, way;  ///< of the boundaries' origins, then, and theirs since the lists were built
  } measured_;                     ///< as last measured
};

}  // namespace subsoil::dem
