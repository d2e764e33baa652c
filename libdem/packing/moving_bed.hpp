#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/bed.hpp"
#include "libdem/packing/carried_soil.hpp"

/// A long bed in a short window that follows a tool (docs/theory, section 7.2).
namespace subsoil::dem {

/// Energy of one contact of a periodic bed, by the places of its spheres in `state`.
struct StoredInContact {
  std::int64_t i = 0, j = 0;  ///< j < 0: at a surface
  std::int64_t across = 0;    ///< as of a pair
  double energy = 0;          ///< J
  void archive(Archive& a) { a("i", i)("j", j)("across", across)("energy", energy); }
};

/// One period along x of a bed at rest, with the contacts of its spheres, those across its ends among them. Any number
/// of them stand behind each other as the spheres of the periodic bed did: forces at the joints are its own.
struct PeriodicBlock {
  double low = 0, length = 0;  ///< of the period along x, m
  Bed::State state;            ///< spheres numbered from 0, at rest; pairs; bonds; contacts at surfaces
  /// Of these spheres, with their centres in the period; members lie beside them, beyond its ends too.
  std::vector<Clump> clumps;
  std::vector<ClumpShape> shapes;    ///< of the clumps
  std::vector<std::int64_t> across;  ///< of each pair: periods from that of the first sphere to that of the second
  std::vector<std::int64_t> bonds_across;  ///< likewise of each bond
  std::vector<StoredInContact> stored;     ///< of contacts that carry a force

  std::size_t size() const { return state.spheres.size(); }
  const Sphere& sphere(std::size_t k) const { return state.spheres[k]; }
  double energy() const;  ///< in all its contacts, J
  /// Place in `clumps` of the one that each sphere belongs to; -1: none.
  std::vector<long> clump_of_spheres() const;
};

/// Of a bed that is periodic along x; its spheres are stopped. @param boundary_of index that each of its boundaries has
/// in the bed that is made of blocks. Bonds of cement form. Throws std::invalid_argument for those that form later than
/// at 0, and for fixed spheres.
PeriodicBlock block_of(Bed& bed, std::span<const int> boundary_of);

struct MovingBedPlan {
  double rear = 0;    ///< x of the end of the window that the tool leaves behind, at the start, m
  double step = 0;    ///< by which the window advances, m
  int steps = 1;      ///< length of the window
  int direction = 1;  ///< of the travel along x: 1 or -1
};

/// The window is so many steps long and slides over a bed that repeats the periodic one without end. Beyond both its
/// ends spheres are fixed, as far as those inside can reach: ahead those that come next, where they
/// were at rest, behind those that lie there. So soil at the ends meets soil, as in a bed that continues.
///
/// When the window advances by a step, between two steps in time, the spheres that were fixed ahead are released, those
/// behind them are put in, some of which are fixed now, with the contacts that they had at rest; those within reach
/// behind the new rear end are fixed where they are, what lies farther back is removed. Spheres that have been pushed
/// over the fixed ones, into the place of new ones, are removed too.
///
/// A fibre may lie across either end: its bonds come in with the contacts, and what of it is fixed holds it as soil is
/// held. A bond ends where both its spheres are fixed, and with a sphere that is removed.
///
/// A clump belongs to where its centre is at rest: it is held, released and removed as a whole.
///
/// Sphere i of period c, from the one in which the window starts on, has the number (c + 1) n + i, n spheres a period.
class MovingBed {
 public:
  /// Throws std::invalid_argument for a period shorter than the fixed length, or a plan without sense.
  MovingBed(PeriodicBlock block, const MovingBedPlan& plan);

  /// Length that is fixed beyond each end, m: two of the maximum diameters of grains. One is what reaches a sphere
  /// inside, another keeps those that are pushed between the fixed ones.
  /// @param largest_reach maximum radius of a sphere, or of the sphere about a clump, m
  static double held_length(double largest_reach) { return 4 * largest_reach; }
  double held_length() const { return held_; }

  /// All spheres of the window at the start, and the fixed ones, into a bed with boundaries and without spheres.
  void fill(Bed& bed) const;
  /// On by a step. @param walls boundaries that advance with the window
  void advance(Bed& bed, std::span<const int> walls);

  long advanced() const { return advanced_; }                                 ///< steps, since the start
  double way() const { return static_cast<double>(advanced_) * plan_.step; }  ///< m
  double length() const { return plan_.steps * plan_.step; }                  ///< m
  double rear() const { return plan_.rear + plan_.direction * way(); }        ///< x of the window's ends, m
  double front() const { return rear() + plan_.direction * length(); }
  const CarriedSoil& entered() const { return entered_; }
  const CarriedSoil& left() const { return left_; }
  std::size_t pushed_out() const { return pushed_out_; }  ///< of those left: over the fixed ones ahead

  const PeriodicBlock& block() const { return block_; }
  const MovingBedPlan& plan() const { return plan_; }
  std::size_t place_in_block(std::uint32_t id) const { return id % block_.size(); }
  Vec3 place_at_rest(std::uint32_t id) const;  ///< of a sphere before anything disturbed it, m

  void archive(Archive& a);  ///< beside block and plan

 private:
  /// A stretch of the bed, m from the first rear end on along the travel: low <= u < high.
  struct Stretch {
    double low, high;
    bool holds(double u) const { return u >= low && u < high; }
  };
  std::uint32_t id(long period, std::size_t sphere) const;
  double along(double x) const { return plan_.direction * (x - plan_.rear); }
  double along(long period, std::size_t sphere) const {
    return static_cast<double>(period) * block_.length + depth_[sphere];
  }
  Vec3 site(long period, std::size_t sphere) const;
  double end_ahead(long advanced) const { return static_cast<double>(plan_.steps + advanced) * plan_.step; }
  template <class Use>
  void each_period(const Stretch& of, const Use& use) const;
  void put_spheres(Bed::State& out, const Stretch& of, bool fixed) const;
  std::vector<Clump> clumps_in(const Stretch& of) const;
  /// Depth of a sphere of the bed, of its clump if it is in one, m along the travel.
  double depth_now(const Bed& bed, const Sphere& s) const;
  void put_contacts(Bed::State& out, const Stretch& of) const;
  CarriedSoil content(const Stretch& of, const Vec3& gravity) const;
  long hindmost(const Stretch& of, long period, std::int64_t i, std::int64_t j, std::int64_t across) const;
  std::vector<std::uint32_t> in_the_way(const Bed& bed, const Bed::State& added) const;

  PeriodicBlock block_;
  MovingBedPlan plan_;
  std::vector<long> clump_of_;  ///< of the spheres of a period; -1: none
  std::vector<double> depth_;   ///< of the spheres of a period, or their clumps, from its rear end, m
  double held_ = 0, largest_ = 0;
  long advanced_ = 0;
  CarriedSoil entered_, left_;
  std::size_t pushed_out_ = 0;
};

}  // namespace subsoil::dem
