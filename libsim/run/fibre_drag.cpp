#include "libsim/run/fibre_drag.hpp"

#include <algorithm>

namespace subsoil::sim {

FibreDrag::FibreDrag(const World& world) : world_(world) {
  if (world.fibres.empty()) return;
  for (const SurfaceRecord& s : world.surfaces)
    if (s.moves && std::find(boundaries_.begin(), boundaries_.end(), s.boundary) == boundaries_.end())
      boundaries_.push_back(s.boundary);
}

void FibreDrag::take(double time, const std::vector<dem::ContactRecord>& contacts) {
  if (boundaries_.empty()) return;
  const std::size_t frame = times_.size();
  times_.push_back(time);
  forces_.resize(at(frame + 1, 0, 0));
  for (const dem::ContactRecord& c : contacts) {
    if (!c.at_surface || !is_of_fibres(world_, c.i)) continue;
    const auto surface = std::find(boundaries_.begin(), boundaries_.end(), static_cast<int>(c.j));
    if (surface == boundaries_.end()) continue;
    for (std::size_t g = 0; g < world_.fibres.size(); ++g)
      if (world_.fibres[g].has(c.i))
        forces_[at(frame, g, static_cast<std::size_t>(surface - boundaries_.begin()))] -= c.force;
  }
}

std::vector<FibreDrag::Mean> FibreDrag::means(std::size_t group, double from, double until) const {
  std::vector<Mean> out;
  for (std::size_t s = 0; s < boundaries_.size(); ++s) {
    Mean mean{world_.bed->boundary(boundaries_[s]).name, {}, 0};
    for (std::size_t f = 0; f < times_.size(); ++f)
      if (times_[f] >= from && times_[f] <= until) mean.force += forces_[at(f, group, s)], ++mean.frames;
    if (mean.frames == 0) continue;
    mean.force = mean.force * (1 / static_cast<double>(mean.frames));
    out.push_back(mean);
  }
  return out;
}

}  // namespace subsoil::sim
