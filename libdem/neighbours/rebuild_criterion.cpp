#include "libdem/neighbours/rebuild_criterion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace subsoil::dem {
namespace {

/// Largest angle by which a boundary turned, rad.
double angle_between(const Pose& was, const Pose& is) {
  const Quaternion rotation = is.attitude * was.attitude.conjugate();
  return 2 * std::atan2(norm(Vec3{rotation.x, rotation.y, rotation.z}), std::abs(rotation.w));
}

}  // namespace

void RebuildCriterion::begin(double skin, const ParticleStore& particles, std::span<const Boundary> boundaries,
                             const ParticleStatistics& statistics, Grid grid, int threads) {
  stale_ = false;
  skin_ = skin;
  path_ = 0;
  listed_pose_.clear(), listed_active_.clear();
  for (const Boundary& b : boundaries) listed_pose_.push_back(b.pose), listed_active_.push_back(b.active);
  measure_boundaries(particles, boundaries, statistics);
  measured_.known = false;
  measured_.place.reserve(boundaries.size()), measured_.way.reserve(boundaries.size());
  // A sphere that is too large for the grid finds its neighbours beyond the next cell.
  displacement_counts_ = !particles.empty() && statistics.largest <= grid.fits;
  displacement_.begin(std::move(grid), skin, particles.size(), boundaries.size(), threads,
                      [&](std::size_t i) { return particles[i].x; });
}

/// How far a boundary reaches from its origin, for the path of its points when it turns.
void RebuildCriterion::measure_boundaries(const ParticleStore& particles, std::span<const Boundary> boundaries,
                                          const ParticleStatistics& statistics) {
  const double reaches = statistics.largest + skin_;  // while the lists hold
  const Vec3 around{reaches, reaches, reaches};
  const Bounds bed{statistics.box.low - around, statistics.box.high + around};
  boundary_radius_.resize(boundaries.size());
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Bounds box = bounds(boundaries[b].shape);
    boundary_radius_[b] = box.farthest(Vec3{});
    if (std::isfinite(boundary_radius_[b])) continue;
    // An infinite plane that turns: what counts is how far the bed reaches from its origin.
    boundary_radius_[b] = particles.empty() ? 0 : bed.farthest(boundaries[b].pose.position);
  }
}

void RebuildCriterion::measure(const ParticleStore& particles, std::span<const Boundary> boundaries, int threads) {
  measured_.place.clear(), measured_.way.clear();
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    measured_.place.push_back(boundaries[b].pose.position);
    measured_.way.push_back(measured_.place.back() - listed_pose_[b].position);
  }
  const auto measure_centres = [&](const auto* records) {
    return displacement_.measure(measured_.way, skin_, threads, [&](std::size_t i) { return records[i].x; });
  };
  measured_.found =
      particles.is_mixed() ? measure_centres(particles.mixed()) : measure_centres(particles.spheres().data());
  measured_.path = path_;
  measured_.known = true;
}

void RebuildCriterion::copy(const RebuildCriterion& from, bool same_lists) {
  stale_ = from.stale_, skin_ = from.skin_, path_ = from.path_;
  if (!same_lists) {
    listed_pose_ = from.listed_pose_, listed_active_ = from.listed_active_, boundary_radius_ = from.boundary_radius_;
    displacement_counts_ = from.displacement_counts_;
    displacement_.copy(from.displacement_);
  }
  measured_ = from.measured_;
  if (!measured_.known) return;
  const std::span<const double> against = from.measured_.found.against;  // lies in the other's memory
  measured_.found = displacement_.room_for_found(measured_.found.parted, measured_.found.gone, against.size());
  displacement_.set_found(against);
}

void RebuildCriterion::archive(Archive& a) {
  a("path", path_)("measured", measured_.known);
  if (!measured_.known) return;
  const std::size_t boundaries = listed_pose_.size();
  double parted = measured_.found.parted, gone = measured_.found.gone;
  a("parted", parted)("gone", gone)("path then", measured_.path);
  if (a.reads())
    measured_.found = displacement_.room_for_found(parted, gone, boundaries), measured_.place.resize(boundaries);
  std::vector<double> against(measured_.found.against.begin(), measured_.found.against.end());
  a("against", std::span(against))("places", measured_.place);
  if (measured_.place.size() != boundaries) Archive::refuse("places");
  if (a.reads()) displacement_.set_found(against);
}

bool RebuildCriterion::hold_within(double limit, std::span<const Boundary> boundaries, double longest_path) const {
  const double since = measured_.known ? path_ - measured_.path : 0;
  // No sphere may be farther from its place than the skin: cells and boundaries are looked at as far as that.
  const bool known = measured_.known && measured_.found.gone + since <= skin_;
  if (2 * longest_path > limit && !(known && measured_.found.parted + 2 * since <= limit)) return false;
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Pose& is = boundaries[b].pose;
    const Pose& was = listed_pose_[b];
    double nearer = longest_path + norm(is.position - was.position);
    if (known) nearer = std::min(nearer, measured_.found.against[b] + since + norm(is.position - measured_.place[b]));
    if (nearer + angle_between(was, is) * boundary_radius_[b] > limit) return false;
  }
  return true;
}

bool RebuildCriterion::lists_hold(const ParticleStore& particles, std::span<const Boundary> boundaries,
                                  double longest_path, int threads) {
  if (stale_) return false;
  for (std::size_t b = 0; b < boundaries.size(); ++b)
    if (boundaries[b].active != (listed_active_[b] != 0)) return false;
  if (hold_within(skin_, boundaries, longest_path)) return true;
  if (!displacement_counts_) return false;
  measure(particles, boundaries, threads);
  // Nearly used up they would be measured every other step, at half a step's cost.
  constexpr double worth_it = 0.9;
  return hold_within(worth_it * skin_, boundaries, longest_path);
}

}  // namespace subsoil::dem
