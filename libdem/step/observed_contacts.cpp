#include "libdem/step/observed_contacts.hpp"

#include <algorithm>

namespace subsoil::dem {
namespace {

template <class T, class Stream>
std::vector<T> part_of(const Stream& stream, std::size_t from, std::size_t count) {
  const T* first = stream.data() + from;
  return {first, first + count};
}
template <class Copies, class Stream>
void put_back(const Copies& copies, Stream& stream) {
  for (const auto& c : copies) std::copy(c.values.begin(), c.values.end(), stream.data() + c.at);
}

}  // namespace

void ObservedContacts::keep(const ActiveRegion& region, const ContactStore& contacts, const SurfaceContacts& surfaces,
                            const ContactLaws& laws, const std::vector<BlockSums>& sums) {
  lines_.clear(), plane_lines_.clear(), activation_.clear(), runs_.clear(), plane_runs_.clear(), losses_.clear();
  unasked_plane_runs_.clear(), unasked_sums_.clear();
  if (!region.any_observed()) return;
  for (std::size_t k = 0; k < contacts.particle_blocks.size(); ++k) {
    if (!region.is_observed(k)) continue;
    const bool asked = region.is_asked_for_energy(k);
    if (asked)
      losses_.push_back({k, {sums[k].lost}});
    else
      unasked_sums_.push_back({k, {sums[k]}});
    const ParticleBlock& block = contacts.particle_blocks[k];
    for (std::size_t r = block.runs_begin; r < block.runs_end; ++r) {
      const PairRun& run = contacts.runs[r];
      runs_.push_back({r, {run}});
      lines_.push_back(
          {run.lines, part_of<Line>(contacts.lines, run.lines, laws.pair_memory(run.law).lines(run.blocks))});
      if (run.candidates)
        activation_.push_back({run.first, part_of<double>(contacts.activation, run.first, run.blocks)});
    }
    const SurfaceContacts::OfBlock& at = surfaces.of_block[k];
    for (std::size_t r = at.planes_begin; r < at.planes_end; ++r) {
      const PlaneRun& run = surfaces.plane_runs[r];
      (asked ? plane_runs_ : unasked_plane_runs_).push_back({r, {run}});
      plane_lines_.push_back(
          {run.lines, part_of<Line>(surfaces.plane_lines, run.lines, laws.surface_memory(run.law).lines(run.blocks))});
    }
  }
}

void ObservedContacts::put_back_histories(ContactStore& contacts, SurfaceContacts& surfaces) const {
  put_back(lines_, contacts.lines), put_back(activation_, contacts.activation), put_back(runs_, contacts.runs);
  put_back(plane_lines_, surfaces.plane_lines);
}

void ObservedContacts::put_back_unasked_sums(SurfaceContacts& surfaces, std::vector<BlockSums>& sums) const {
  put_back(unasked_plane_runs_, surfaces.plane_runs);
  for (const Copy<BlockSums>& c : unasked_sums_) sums[c.at] = c.values.front();
}

void ObservedContacts::put_back_sums(SurfaceContacts& surfaces, std::vector<BlockSums>& sums) const {
  put_back(plane_runs_, surfaces.plane_runs);
  for (const Copy<Losses>& c : losses_) sums[c.at].lost = c.values.front();
}

}  // namespace subsoil::dem
