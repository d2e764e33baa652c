#include <algorithm>

#include "libdem/base/archive.hpp"
#include "libdem/contacts/particle_block.hpp"

namespace subsoil::dem {

double PathBounds::add_step(const std::vector<ParticleBlock>& blocks) {
  double farthest = 0;
  for (const Bound& b : of_block_) farthest = std::max(farthest, b.step);
  for (std::size_t own = 0; own < blocks.size(); ++own) {
    const ParticleBlock& b = blocks[own];
    double longest = 0;
    for (std::size_t k = own; k <= b.last; ++k) longest = std::max(longest, of_block_[k].step);
    for (std::size_t k = b.interface_first; k <= b.interface_last; ++k) longest = std::max(longest, of_block_[k].step);
    of_block_[own].path += longest;
  }
  return farthest;
}

void PathBounds::archive(Archive& a) {
  for (Bound& b : of_block_) {
    a("path", b.path);
    if (a.reads()) b.step = 0;
  }
}

double PathBounds::longest() const {
  double longest = 0;
  for (const Bound& b : of_block_) longest = std::max(longest, b.path);
  return longest;
}

}  // namespace subsoil::dem
