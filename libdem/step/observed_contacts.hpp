#pragma once
#include <cstdint>
#include <vector>

#include "libdem/contacts/contact_store.hpp"
#include "libdem/contacts/surface_contacts.hpp"
#include "libdem/step/active_region.hpp"
#include "libdem/step/energy_balance.hpp"

namespace subsoil::dem {

/// Contacts of sleeping particle blocks that a step evaluates only because their forces or energies are asked for. They
/// are put back as they were: springs of a sleeping contact are cut to the present limit by its next evaluation, and
/// the motion would depend on when that is.
class ObservedContacts {
 public:
  /// Before the sweep.
  void keep(const ActiveRegion& region, const ContactStore& contacts, const SurfaceContacts& surfaces,
            const ContactLaws& laws, const std::vector<BlockSums>& sums);
  /// After the sweep.
  void put_back_histories(ContactStore& contacts, SurfaceContacts& surfaces) const;
  /// Likewise of blocks that are evaluated for a frame alone: energies and wrenches are summed as without one.
  void put_back_unasked_sums(SurfaceContacts& surfaces, std::vector<BlockSums>& sums) const;
  /// After energies and wrenches are summed.
  void put_back_sums(SurfaceContacts& surfaces, std::vector<BlockSums>& sums) const;

 private:
  template <class T>
  struct Copy {
    std::size_t at;
    std::vector<T> values;
  };
  std::vector<Copy<Line>> lines_, plane_lines_;
  std::vector<Copy<double>> activation_;
  std::vector<Copy<PairRun>> runs_;
  std::vector<Copy<PlaneRun>> plane_runs_, unasked_plane_runs_;
  std::vector<Copy<Losses>> losses_;           ///< by particle block
  std::vector<Copy<BlockSums>> unasked_sums_;  ///< likewise
};

}  // namespace subsoil::dem
