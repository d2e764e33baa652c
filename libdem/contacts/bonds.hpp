#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "libdem/contacts/bond_record.hpp"
#include "libdem/contacts/contact_store.hpp"
#include "libdem/contacts/surface_contacts.hpp"

namespace subsoil::dem {

/// Bonds between spheres: when they form, what broke, how many there are. What each bond keeps (reference overlap,
/// damage) lies with the history of its contact (ContactStore::lines), since the kernel needs both at once.
///
/// | data            | written by                                                   | read by             |
/// |---|---|---|
/// | may_form        | users                                                        | each step           |
/// | formed (by law) | `form_due`, restarts                                         | `form_due`, restarts|
/// | broke_in_run    | workers, of the runs they evaluate, during the sweep         | `record_broken`     |
/// | count, broken   | `form_due`, `Bed::insert`, `record_broken`, rebuilds (removed), restarts | users  |
///
/// A flag per run in place of a list of what broke: several workers may evaluate blocks of one run, nothing is broken
/// in nearly all steps, and the order of the records must follow the lists and not the threads.
class Bonds {
 public:
  bool may_form = false;
  std::vector<char> formed;
  BondCount count;
  std::vector<BrokenBond> broken;  ///< since the start, in the order in which they broke

  /// Laws were exchanged: what has formed of each stays known.
  void resize(const ContactLaws& laws) { formed.resize(laws.count(), 0); }
  void begin_lists(const ContactStore& contacts) { broke_in_run_.assign(contacts.runs.size(), 0); }

  /// Bonds of laws whose time has come by `until`, s; lists hold.
  void form_due(double until, ContactStore& contacts, const ParticleStore& particles, const ContactLaws& laws);
  /// A bond of the run broke in this step; called by workers.
  void mark_broken(std::uint32_t run);
  /// Marks bonds of fibres that cutting edges have pressed through in this step: they break in the next.
  ///
  /// The section that an edge would cut is the bond nearest to it: of the bonds of the sphere that it touches the one
  /// in whose direction it lies. Of a sphere at an end only an edge beyond half the radius cuts: one in its middle has
  /// cut it off already, or cuts nothing off. What counts is the force in the direction in which the edge points.
  /// Forces of one boundary on both spheres of a bond add up.
  void cut(std::span<const EdgeContact> at_edges, ContactStore& contacts, const ParticleStore& particles,
           const ContactLaws& laws, const PeriodicCell& cell);
  /// Bonds that broke in this step, in the order of the lists; what they stored is added to `lost`, J. Called after
  /// every sweep, so that no later build of the lists can drop one.
  void record_broken(double time, ContactStore& contacts, const ParticleStore& particles, const ContactLaws& laws,
                     double& lost);

 private:
  void form_in_run(const PairRun& run, double gap, ContactStore& contacts, const ParticleStore& particles,
                   const MemoryShape& shape);
  void record_run(const PairRun& run, double time, ContactStore& contacts, const ParticleStore& particles,
                  const ContactLaws& laws, double& lost);

  std::vector<char> broke_in_run_;  ///< a byte of its own for each, threads write them
};

/// use(i, j) for each intact bond: indices of its spheres.
void each_bond(const ContactStore& contacts, const ContactLaws& laws,
               const std::function<void(std::uint32_t, std::uint32_t)>& use);
/// Intact bonds of each sphere.
void count_bonds(const ContactStore& contacts, const ContactLaws& laws, const ParticleStore& particles, Snapshot& out);

}  // namespace subsoil::dem
