#pragma once
#include "libdem/particles/periodic.hpp"

namespace subsoil::sim {

/// use(shift) for every place of a box, its own among them, from which a kernel reaches into the cell.
/// @param low, high corners of the box, m; reach of the kernel, m
template <class Use>
void each_image(const dem::Vec3& low, const dem::Vec3& high, const dem::PeriodicCell& cell, double reach,
                const Use& use) {
  const auto turns = [&](int d) { return cell.length[d] > 0 ? 1 : 0; };
  const auto reaches = [&](int d, double shift) {
    return cell.length[d] == 0 ||
           (high[d] + shift > cell.low[d] - reach && low[d] + shift < cell.low[d] + cell.length[d] + reach);
  };
  for (int a = -turns(0); a <= turns(0); ++a)
    for (int b = -turns(1); b <= turns(1); ++b)
      for (int c = -turns(2); c <= turns(2); ++c) {
        const dem::Vec3 shift{a * cell.length.x, b * cell.length.y, c * cell.length.z};
        if (reaches(0, shift.x) && reaches(1, shift.y) && reaches(2, shift.z)) use(shift);
      }
}

}  // namespace subsoil::sim
