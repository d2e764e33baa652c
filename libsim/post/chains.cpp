#include "libsim/post/chains.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libdem/laws/contact.hpp"

namespace subsoil::sim {

namespace {

const Material* material_of(const Scenario& scenario, const std::string& name) {
  const auto found = std::find_if(scenario.materials.begin(), scenario.materials.end(),
                                  [&](const Material& m) { return m.name == name; });
  return found == scenario.materials.end() ? nullptr : &*found;
}

}  // namespace

RestForce::RestForce(const Scenario& scenario, const std::vector<std::string>& materials)
    : materials_(materials.size()), laws_(materials.size() * materials.size()) {
  for (const Contact& c : scenario.contacts) {
    const Material *a = material_of(scenario, c.between[0]), *b = material_of(scenario, c.between[1]);
    if (a == nullptr || b == nullptr) continue;
    const dem::Law law = law_between(c.law, *a, *b);
    for (std::size_t i = 0; i < materials_; ++i)
      for (std::size_t j = 0; j < materials_; ++j)
        if ((materials[i] == a->name && materials[j] == b->name) ||
            (materials[i] == b->name && materials[j] == a->name))
          laws_[i * materials_ + j] = law;
  }
}

double RestForce::reach(double radius) const {
  double most = 0;
  for (const auto& law : laws_)
    if (law) most = std::max(most, (*law)->cutoff(0.5 * radius));
  return most;
}

double RestForce::operator()(const ChainSphere& a, const ChainSphere& b, double overlap) const {
  const std::size_t at = static_cast<std::size_t>(a.material) * materials_ + static_cast<std::size_t>(b.material);
  if (at >= laws_.size() || !laws_[at]) return 0;
  const double sum = double{a.r} + b.r;
  double memory[dem::kOwnMemory] = {};
  const dem::Approach<double> approach{.overlap = overlap,
                                       .rate = 0,
                                       .root_m = 1,  // only damping asks for it
                                       .r_eff = double{a.r} * b.r / sum,
                                       .elapsed = 0,
                                       .per_sum = 1 / sum};
  return (*laws_[at])->normal(approach, memory).force;
}

std::vector<Chain> chains(const std::vector<ChainSphere>& spheres, const RestForce& force) {
  double largest = 0;
  for (const ChainSphere& s : spheres) largest = std::max(largest, double{s.r});
  const double gap = force.known() ? force.reach(largest) : 0, cell = std::max(2 * largest + gap, 1e-9);
  using Place = std::array<long, 3>;
  const auto place = [&](const ChainSphere& s) {
    const auto of = [&](float v) { return std::lround(std::floor(double{v} / cell)); };
    return Place{of(s.x), of(s.y), of(s.z)};
  };
  std::vector<std::pair<Place, std::uint32_t>> grid;  // sorted: cells in a row along z follow each other
  for (std::uint32_t i = 0; i < spheres.size(); ++i) grid.emplace_back(place(spheres[i]), i);
  std::sort(grid.begin(), grid.end());
  std::vector<Chain> out;
  const auto meet = [&](std::uint32_t i, std::uint32_t j) {
    const ChainSphere &a = spheres[i], &b = spheres[j];
    const double overlap = a.r + b.r - std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
    if (overlap <= -gap) return;
    const double size = force.known() ? force(a, b, overlap) : overlap / std::min(a.r, b.r);
    if (std::isfinite(size) && size != 0) out.push_back({i, j, size});
  };
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    const auto [cx, cy, cz] = place(spheres[i]);
    for (long ix = cx - 1; ix <= cx + 1; ++ix)
      for (long iy = cy - 1; iy <= cy + 1; ++iy) {
        const Place first{ix, iy, cz - 1}, last{ix, iy, cz + 1};
        for (auto at = std::lower_bound(grid.begin(), grid.end(), std::pair{first, std::uint32_t{0}});
             at != grid.end() && at->first <= last; ++at)
          if (at->second > i) meet(i, at->second);
      }
  }
  return out;
}

}  // namespace subsoil::sim
