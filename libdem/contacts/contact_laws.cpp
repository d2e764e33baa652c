#include "libdem/contacts/contact_laws.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace subsoil::dem {

ContactLaws::ContactLaws(LawTable table, bool single) : table_(std::move(table)), single_(single) { derive(); }

void ContactLaws::replace(LawTable table) {
  table_ = std::move(table);
  derive();
}

void ContactLaws::derive() {
  if (table_.laws.size() > 255) throw std::invalid_argument("more than 255 contact laws in one bed");
  pair_memory_.clear(), surface_memory_.clear();
  for (const Law& law : table_.laws) {
    pair_memory_.push_back(MemoryShape::of(law, single_));
    surface_memory_.push_back(MemoryShape::at_surface(law));
  }
  any_bonds_ = std::any_of(pair_memory_.begin(), pair_memory_.end(), [](const MemoryShape& m) { return m.bonds; });
}

void ContactLaws::update_cutoffs(double largest_radius) {
  cutoff_.clear(), surface_cutoff_.clear();
  for (const Law& law : table_.laws) {
    cutoff_.push_back(law->pair_cutoff(largest_radius));
    surface_cutoff_.push_back(law->cutoff(largest_radius));
  }
}

double ContactLaws::largest_cutoff() const {
  double largest = 0;
  for (const double cutoff : cutoff_) largest = std::max(largest, cutoff);
  return largest;
}

void ContactLaws::require(const std::vector<char>& present) const {
  for (int a = 0; a < table_.materials; ++a)
    for (int b = a; b < table_.materials; ++b)
      if (present[static_cast<std::size_t>(a)] > (a == b ? 1 : 0) && present[static_cast<std::size_t>(b)] > 0 &&
          between(a, b) < 0)
        throw std::invalid_argument("no contact law between materials " + std::to_string(a) + " and " +
                                    std::to_string(b) + ", and spheres of both are in the bed");
}

}  // namespace subsoil::dem
