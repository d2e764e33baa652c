#pragma once
#include <cstdint>
#include <vector>

#include "libdem/contacts/blocks.hpp"
#include "libdem/laws/law_table.hpp"

namespace subsoil::dem {

/// The laws of a bed and what the engine derives of each: how far it acts, and what its contacts keep.
///
/// Written when laws are exchanged (`replace`) and by rebuilds (`update_cutoffs`: some laws reach farther between large
/// spheres); read by rebuilds and by each run of contact blocks once, so the layout does not matter.
class ContactLaws {
 public:
  /// @param single pairs keep their numbers in float; surfaces keep double
  ContactLaws(LawTable table, bool single);
  void replace(LawTable table);
  void update_cutoffs(double largest_radius);

  const LawTable& table() const { return table_; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(table_.laws.size()); }
  const Law& operator[](std::uint32_t law) const { return table_.laws[law]; }
  int between(int a, int b) const { return table_.of(a, b); }  ///< index by material; -1: none given
  /// Maximum gap across which the law acts between the spheres of the lists, and between them and surfaces, m.
  double cutoff(std::uint32_t law) const { return cutoff_[law]; }
  double surface_cutoff(std::uint32_t law) const { return surface_cutoff_[law]; }
  double largest_cutoff() const;  ///< between spheres
  const MemoryShape& pair_memory(std::uint32_t law) const { return pair_memory_[law]; }
  const MemoryShape& surface_memory(std::uint32_t law) const { return surface_memory_[law]; }
  bool any_bonds() const { return any_bonds_; }

  /// Throws std::invalid_argument when spheres of two materials are in the bed and have no law with each other.
  void require(const std::vector<char>& present) const;

 private:
  void derive();

  LawTable table_;
  bool single_;
  std::vector<double> cutoff_, surface_cutoff_;
  std::vector<MemoryShape> pair_memory_, surface_memory_;
  bool any_bonds_ = false;
};

}  // namespace subsoil::dem
