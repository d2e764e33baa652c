#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "libdem/base/large_pages.hpp"
#include "libdem/particles/particles.hpp"
#include "libdem/particles/periodic.hpp"

namespace subsoil::dem {

using Spheres = std::vector<Sphere, LargePages<Sphere>>;

/// Mass that contacts find of a fixed sphere over its own: a power of two, and 2^90 kg fits in single precision.
inline constexpr double kUnyielding = 0x1p90;
inline constexpr std::uint32_t kGone = ~std::uint32_t{0};  ///< new index of a sphere that left

/// Records of all spheres of a bed, in the order of the cells that they were last sorted by.
///
/// | data             | written by                                                | read by                       |
/// |---|---|---|
/// | records, double  | users (add, restore, shift, sleep), the  sort of a        | every contact, for both       |
/// |                  | rebuild; in double precision the move at a step's end     | particles; rebuilds, results  |
/// | records, mixed   | `sync_to_mixed`, the move at a step's end                 | every contact                 |
/// | masses           | rebuilds                                                  | contacts, see below           |
/// | numbers, slots   | users; rebuilds                                           | snapshots                     |
/// | images (behind)  | rebuilds; `renew_images`, before each step                | contacts across periodic sides|
///
/// The move is the only writer within a step: each worker moves the spheres of its own particle blocks, once their
/// forces are complete.
///
/// Layout: one array of records. A contact reads its second particle whole, at a place that the sort keeps near but
/// that no prefetcher predicts; structure-of-arrays lost there (particles.hpp). Mixed precision has a second array in
/// place of conversions in the contact: 64 instead of 96 bytes per particle and contact.
///
/// A law finds the mass of the body that is hit: of a free sphere its own, of a clump's member the clump's (as LAMMPS
/// has it), of a fixed one kUnyielding times its own, so that every law finds the limit of a pair with a body that does
/// not yield,
///   m_eff = m M/(m + M) -> m of the free sphere
/// to m/M <= 1e-21 for a free sphere up to a million times as heavy (LAMMPS, `fix freeze`); r_eff is that of both.
/// These masses are an array of their own, of beds that are not of free spheres alone; runs of contact blocks between
/// free spheres do not read it (PairRun::all_free). In the records there is no room, and two meanings of a mass had
/// readers take one for the other.
class ParticleStore {
 public:
  explicit ParticleStore(Precision precision) : precision_(precision) {}

  bool is_mixed() const { return precision_ == Precision::mixed; }
  std::size_t size() const { return spheres_.size() - images_.size(); }
  bool empty() const { return size() == 0; }
  /// Records in double: as they are now where `sync_from_mixed` was called since the last step.
  std::span<Sphere> spheres() { return {spheres_.data(), size()}; }
  std::span<const Sphere> spheres() const { return {spheres_.data(), size()}; }
  /// And behind them the images.
  std::span<const Sphere> spheres_and_images() const { return spheres_; }
  const PeriodicImages& images() const { return images_; }
  /// Room for the records of these, in place of those there are.
  void set_images(PeriodicImages images);
  /// Before spheres come, leave or are sorted: none any more. Returns whether there were any.
  bool drop_images();
  void renew_images(int threads);  ///< as their spheres are now
  const Sphere& operator[](std::size_t i) const { return spheres_[i]; }
  /// What kernels work on in mixed precision; null in double.
  MixedSphere* mixed() { return is_mixed() ? mixed_.data() : nullptr; }
  const MixedSphere* mixed() const { return is_mixed() ? mixed_.data() : nullptr; }
  /// Masses that contacts find, of spheres and images, while lists hold; empty: those of the records.
  std::span<const double> masses() const { return masses_; }
  double mass_in_contact(std::uint32_t i) const { return masses_.empty() ? spheres_[i].m : masses_[i]; }
  /// kg, by which a sphere yields to a surface: of a fixed one its own.
  double mass_at_surface(std::uint32_t i) const {
    return spheres_[i].kind == SphereKind::fixed ? spheres_[i].m : mass_in_contact(i);
  }
  /// For new lists, images included. @param all_free none is fixed or in a clump
  /// @param of_clump mass of the clump that a member belongs to, kg, by index
  void find_masses(bool all_free, const std::function<double(std::uint32_t)>& of_clump);
  Sphere now(std::uint32_t i) const;  ///< record in double of one sphere, or image, as it is now
  void stop(std::uint32_t i);         ///< within a step: neither velocity nor angular velocity any more

  /// Positions and motions of the records in double to those of mixed precision, if that is asked for.
  void sync_to_mixed(int threads);
  void sync_from_mixed(int threads);  ///< and back, where steps have run since
  /// Before each step: what it moves are the records of mixed precision, if there are any.
  void begin_step() { spheres_behind_ = is_mixed(); }

  /// Adds a sphere with this number, which is new, or the next one. Throws std::invalid_argument for one without sense.
  void add(const SphereSpec& in, int materials, std::optional<std::uint32_t> number = {});
  void clear();
  void restore(const Sphere& s);  ///< with the number that it has
  /// Takes out the spheres whose centres lie below `floor`, m, and those for which `gone` holds; each is given to
  /// `leave` before. Returns for each that stays its index before; nothing if all do.
  std::vector<std::uint32_t> take_out(double floor, const std::function<bool(const Sphere&)>& gone,
                                      const std::function<void(const Sphere&, bool fell)>& leave, int threads);

  void number_slots();                                                        ///< after spheres came or left
  std::uint32_t slot_of(const Sphere& s) const { return slot_of_id_[s.id]; }  ///< place in a snapshot

 private:
  Precision precision_;
  Spheres spheres_;
  std::vector<MixedSphere, LargePages<MixedSphere>> mixed_;
  bool spheres_behind_ = false;  ///< steps have moved the records of mixed precision only
  PeriodicImages images_;        ///< the last records of both arrays
  std::vector<double, LargePages<double>> masses_;
  std::uint32_t next_id_ = 0;
  std::vector<std::uint32_t> slot_of_id_;  ///< empty once spheres came or left
};

}  // namespace subsoil::dem
