#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "libdem/bed.hpp"

/// A long bed in a short window that follows a tool (docs/theory.md, section 7.2).
namespace subsoil::dem {

/// One period along x of a bed at rest, with the contacts of its spheres, those across its ends among them. Any number
/// of such blocks stand behind each other as the spheres of the periodic bed did: forces at the joints are its own.
struct PeriodicBlock {
  double low = 0, length = 0;        ///< of the period along x, m
  Bed::State state;                  ///< spheres numbered from 0, at rest; pairs; contacts at surfaces
  std::vector<std::int64_t> across;  ///< of each pair: blocks from that of the first sphere to that of the second
  double stored = 0;                 ///< in its contacts, J

  std::size_t size() const { return state.ids.size() / 2; }
};

/// Of a bed that is periodic along x; its spheres are stopped. @param boundary_of index that each of its boundaries has
/// in the bed that is made of blocks. Throws std::invalid_argument for bonds, clumps and fixed spheres.
PeriodicBlock block_of(Bed& bed, std::span<const int> boundary_of);

/// What came into the window ahead, or was left behind: of spheres when they begin or cease to move freely.
struct CarriedSoil {
  std::size_t spheres = 0;
  double mass = 0;                              ///< kg
  Vec3 momentum;                                ///< N s
  double kinetic = 0, gravity = 0, stored = 0;  /// J
  double energy() const { return kinetic + gravity + stored; }
};

struct MovingBedPlan {
  double rear = 0;    ///< x of the end of the window that the tool leaves behind, at the start, m
  int blocks = 1;     ///< in the window
  int direction = 1;  ///< of the travel along x: 1 or -1
};

/// The window holds whole blocks. Beyond both its ends spheres are held in place (fixed), as far as those inside can
/// reach: ahead those of the next block, where they were at rest, behind those that lie there. So soil at the ends
/// meets soil, as in a bed that goes on.
///
/// When the window goes on by a block, between two steps, the spheres that were held ahead are let go, the rest of
/// their block and what is to be held of the next one are put in, with the contacts that they had at rest; those within
/// reach behind the new rear end are held where they are, what lies farther back is taken out. Spheres that have been
/// pushed over the held ones, into the place of new ones, are taken out too.
class MovingBed {
 public:
  /// Throws std::invalid_argument for a block shorter than what is held, or a plan without sense.
  MovingBed(PeriodicBlock block, const MovingBedPlan& plan);

  /// Length that is held beyond each end, m: two of the largest diameters. One is what reaches a sphere inside, another
  /// keeps those that are pushed between the held ones.
  static double held_length(double largest_radius) { return 4 * largest_radius; }
  double held_length() const { return held_; }

  /// All spheres of the window at the start, and the held ones, into a bed with boundaries and without spheres.
  void fill(Bed& bed) const;
  /// On by a block. @param walls boundaries that go on with the window
  void advance(Bed& bed, std::span<const int> walls);

  long advanced() const { return advanced_; }                                    ///< blocks, since the start
  double way() const { return static_cast<double>(advanced_) * block_.length; }  ///< m
  double rear() const { return plan_.rear + plan_.direction * way(); }           ///< x of the window's ends, m
  double front() const { return rear() + plan_.direction * plan_.blocks * block_.length; }
  const CarriedSoil& entered() const { return entered_; }
  const CarriedSoil& left() const { return left_; }
  std::size_t pushed_out() const { return pushed_out_; }  ///< of those left: over the held ones ahead

  const PeriodicBlock& block() const { return block_; }
  const MovingBedPlan& plan() const { return plan_; }
  std::size_t place_in_block(std::uint32_t id) const { return id % block_.size(); }
  Vec3 place_at_rest(std::uint32_t id) const;  ///< of a sphere before anything disturbed it, m

  std::vector<double> save() const;  ///< beside block and plan
  void restore(std::span<const double> from);

 private:
  std::uint32_t id(long copy, std::size_t sphere) const;
  double along(double x) const { return plan_.direction * (x - plan_.rear); }  ///< from the first rear end on, m
  Vec3 site(long copy, std::size_t sphere) const;
  double depth(std::size_t sphere) const;  ///< from the rear end of its block, m
  template <class Chosen>
  void put_spheres(Bed::State& out, long copy, bool fixed, const Chosen& chosen) const;
  void put_contacts(Bed::State& out, long copy, bool only_across) const;
  CarriedSoil of_block(long copy, const Vec3& gravity) const;
  std::vector<std::uint32_t> in_the_way(const Bed& bed, const Bed::State& added) const;

  PeriodicBlock block_;
  MovingBedPlan plan_;
  double held_ = 0, largest_ = 0;
  long advanced_ = 0;
  CarriedSoil entered_, left_;
  std::size_t pushed_out_ = 0;
};

}  // namespace subsoil::dem
