#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "libdem/packing/fibres.hpp"
#include "libdem/packing/settle.hpp"
#include "libdem/step/stability.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

struct World;

/// Fibres of one name. Their spheres are numbered in one row, fibre by fibre from end to end; of a moving bed in each
/// of its periods.
struct FibreGroup {
  std::string name;
  dem::FibreShape shape;
  std::size_t count = 0;
  std::uint32_t first = 0;   ///< number of the first sphere
  std::uint32_t period = 0;  ///< spheres of a period of a moving bed, after which numbers repeat; else 0

  std::uint32_t end() const { return first + static_cast<std::uint32_t>(count) * per_fibre(); }
  std::uint32_t per_fibre() const { return static_cast<std::uint32_t>(shape.spheres()); }
  std::uint32_t in_period(std::uint32_t id) const { return period > 0 ? id % period : id; }
  bool has(std::uint32_t id) const { return in_period(id) >= first && in_period(id) < end(); }
  std::size_t fibre_of(std::uint32_t id) const { return (in_period(id) - first) / per_fibre(); }
};

/// Of the scenario in its order, not numbered yet.
std::vector<FibreGroup> fibre_groups(const Scenario& s);
/// The same before any has been laid.
std::vector<FibreGroup> groups_without_fibres(const Scenario& s);
/// Whether spheres of a material are parts of fibres and nothing else. A bed from a file does not state it.
bool is_of_fibres_only(const Scenario& s, int material);
/// What the stable step is asked for the law between two materials: with the sizes of the spheres that it acts between.
/// Fibres are thinner and lighter than soil by far, and most laws never meet one.
/// @param soil for spheres that are not of fibres only
dem::StepQuestion question_between(const Scenario& s, const dem::StepQuestion& soil, int a, int b);
/// World::fibres from SoilReport::fibres_from on: that number alone states which sphere belongs to which fibre.
void number_fibres(World& world);
/// Whether a sphere is one of a fibre, and none of the soil.
bool is_of_fibres(const World& world, std::uint32_t id);
/// Number of the fibre that a sphere belongs to, over all groups from 0, of a moving bed in its period; -1: of none.
std::int32_t fibre_of(const std::vector<FibreGroup>& groups, std::uint32_t id);

/// Lays the fibres of a scenario on a bed that lies: each group in its region, or above what is there, over the
/// container's plan. Spheres of the bed that fibres in a region meet are left out.
class FibreCover final : public dem::BedCover {
 public:
  /// @param raise makes the walls reach up to a height, m, world y
  FibreCover(World& world, const Loaded& loaded, std::function<void(double)> raise)
      : world_(world), loaded_(loaded), raise_(std::move(raise)) {}
  Laid lay(dem::Bed& bed, std::uint32_t first) override;
  void laid(const Laid& what) override;
  /// Throws ScenarioError where the fibres have no room, whatever the bed below them is like.
  void refuse_without_room() const;

 private:
  /// All of a group, which become part of `taken`.
  std::vector<dem::FibrePose> place_group(const FibreGroup& group, std::size_t index,
                                          std::vector<dem::PlacedFibre>& taken, double top) const;
  std::vector<dem::FibrePose> place(const FibreSection& f, const FibreGroup& group, std::size_t index,
                                    const std::vector<dem::PlacedFibre>& taken, double top) const;
  std::size_t make_room(dem::Bed& bed, const dem::FibreShape& shape, const std::vector<dem::FibrePose>& poses) const;

  World& world_;
  const Loaded& loaded_;
  std::function<void(double)> raise_;
};

}  // namespace subsoil::sim
