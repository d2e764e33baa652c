#include "libdem/step/subdomain.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "libdem/base/small_rotation.hpp"
#include "libdem/geometry/world_box.hpp"
#include "libdem/step/surface_forces.hpp"

namespace subsoil::dem {
namespace {

bool all_alike(std::span<const Sphere> spheres) {
  return std::all_of(spheres.begin(), spheres.end(),
                     [&](const Sphere& s) { return s.r == spheres.front().r && s.m == spheres.front().m; });
}

}  // namespace

Subdomain::Subdomain(LawTable laws, std::vector<Boundary> boundaries, const SubdomainOptions& options)
    : options_(options),
      kernel_(choose_kernel(options.simd)),
      laws_(std::move(laws), false),
      boundaries_(std::move(boundaries)) {
  laws_.update_cutoffs(options.largest_radius);
}

void Subdomain::begin_lists(std::span<const Sphere> own, std::size_t ghosts) {
  ghosts_ = ghosts;
  particles_.clear();
  for (const Sphere& s : own) particles_.restore(s);
  particles_.set_images({.spheres = static_cast<std::uint32_t>(own.size()),
                         .of = std::vector<std::uint32_t>(ghosts, 0),
                         .shift = std::vector<Vec3>(ghosts)});
  const auto count = static_cast<std::uint32_t>(own.size() + ghosts);
  sums_of_.assign(std::max<std::size_t>(count, 1), Accumulator{});
  mask_ = std::bit_ceil(std::max(count, 1u)) - 1;
}

void Subdomain::build(std::span<const NearPair> pairs, std::vector<SurfaceHistory> at_surfaces) {
  uniform_ = all_alike({spheres(), size() + ghosts_});
  runs_.clear(), blocks_.clear(), shapes_.clear(), activation_.clear(), lines_.clear();
  // By law, whether they touch, and whether they lie across a border.
  std::vector<std::array<std::vector<NearPair>, 4>> kinds(laws_.count());
  for (const NearPair& p : pairs) {
    const int law = laws_.between(spheres()[p.i].material, spheres()[p.j].material);
    if (law < 0) continue;
    const bool candidate = p.gap > laws_.cutoff(static_cast<std::uint32_t>(law)) && p.was == nullptr;
    const bool across = std::max(p.i, p.j) >= size();
    kinds[static_cast<std::size_t>(law)][(candidate ? 2u : 0u) + (across ? 1u : 0u)].push_back(p);
  }
  for (std::uint32_t law = 0; law < laws_.count(); ++law)
    for (const std::size_t kind : {0u, 1u, 2u, 3u}) append_runs(law, kind >= 2, kind % 2 == 1, kinds[law][kind]);
  surfaces_.build(particles_, boundaries_, laws_, options_.skin, 1);
  surfaces_.waiting = std::move(at_surfaces);
  std::vector<std::uint32_t> same(size());
  std::iota(same.begin(), same.end(), 0u);
  surfaces_.restore_histories(same, laws_);
  listed_.clear(), listed_pose_.clear(), listed_active_.clear();
  for (const Sphere& s : particles_.spheres()) listed_.push_back(s.x);
  for (const Boundary& b : boundaries_) listed_pose_.push_back(b.pose), listed_active_.push_back(b.active);
  path_ = measured_ = path_at_measure_ = 0;
  plane_last_.assign(surfaces_.plane_runs.size(), {});
}

/// Candidates in the order of their gaps, so that a block is not activated by one of its pairs long before the others.
void Subdomain::append_runs(std::uint32_t law, bool candidates, bool across, std::vector<NearPair>& pairs) {
  constexpr std::size_t most = 64 * kBlock;  // of a run, so that samples are spread over steps
  if (candidates)
    std::stable_sort(pairs.begin(), pairs.end(), [](const NearPair& a, const NearPair& b) { return a.gap < b.gap; });
  for (std::size_t at = 0; at < pairs.size(); at += most)
    append_run(law, candidates, across, std::span(pairs).subspan(at, std::min(most, pairs.size() - at)));
}

void Subdomain::append_run(std::uint32_t law, bool candidates, bool across, std::span<const NearPair> pairs) {
  Run run{.law = law, .candidates = candidates, .across = across};
  run.first = static_cast<std::uint32_t>(blocks_.size()), run.lines = lines_.size();
  run.blocks = static_cast<std::uint32_t>((pairs.size() + kBlock - 1) / kBlock);
  const MemoryShape& shape = laws_.pair_memory(law);
  lines_.resize(lines_.size() + shape.lines(run.blocks), Line{});
  for (std::uint32_t b = 0; b < run.blocks; ++b) {
    const auto of_block = pairs.subspan(b * kBlock, std::min<std::size_t>(kBlock, pairs.size() - b * kBlock));
    append_block(of_block);
    for (std::uint32_t l = 0; l < of_block.size(); ++l)
      if (of_block[l].was != nullptr) write_lane(memory(run, b), shape, l, *of_block[l].was);
  }
  runs_.push_back(run);
}

/// Each block is a SELL chunk of its own; lanes beyond the last repeat the first.
void Subdomain::append_block(std::span<const NearPair> pairs) {
  PairBlock block;
  for (std::uint32_t l = 0; l < kBlock; ++l) {
    const NearPair& p = pairs[l < pairs.size() ? l : 0];
    block.i[l] = p.i, block.j[l] = p.j;
  }
  blocks_.push_back(block);
  shapes_.push_back({static_cast<std::uint8_t>(pairs.size()), true});
  activation_.push_back(0);
}

BlockMemory Subdomain::memory(const Run& run, std::uint32_t block) const {
  return BlockMemory::at(const_cast<Line*>(lines_.data()) + run.lines, run.blocks, laws_.pair_memory(run.law), block);
}

bool Subdomain::lists_hold() {
  const double share = 0.5 * options_.skin;
  for (std::size_t b = 0; b < boundaries_.size(); ++b)
    if (boundaries_[b].active != (listed_active_[b] != 0) || moved(b) > share) return false;
  if (measured_ + path_ - path_at_measure_ <= share) return true;
  measured_ = farthest_from_lists(), path_at_measure_ = path_;
  return measured_ <= share;
}

double Subdomain::farthest_from_lists() const {
  double largest = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    const Vec3 way = particles_[i].x - listed_[i];
    largest = std::max(largest, dot(way, way));
  }
  return std::sqrt(largest);
}

/// Longest way of a point of a boundary near spheres since the lists were built, m.
double Subdomain::moved(std::size_t boundary) const {
  const Pose &was = listed_pose_[boundary], &is = boundaries_[boundary].pose;
  const double way = norm(is.position - was.position), angle = norm(small_rotation(was.attitude, is.attitude));
  if (angle == 0) return way;
  Bounds box;
  for (const Sphere& s : particles_.spheres()) box.include(s.x);
  const double reach = box.empty() ? 0 : box.farthest(is.position) + options_.largest_radius + options_.skin;
  return way + angle * std::min(reach, bounds(boundaries_[boundary].shape).farthest(Vec3{}));
}

void Subdomain::evaluate(double elapsed, const Sampling& sampling, bool all) {
  std::size_t next = 0;
  const auto sample = [&] {
    Sample s = sampling.of(next++);
    if (all) s.record = s.accumulate = true;
    return s;
  };
  sums_ = {};
  std::fill(sums_of_.begin() + static_cast<std::ptrdiff_t>(size()), sums_of_.end(), Accumulator{});
  for (Run& run : runs_) pair_forces(run, elapsed, sample());
  for (PlaneRun& run : surfaces_.plane_runs) plane_forces(run, elapsed, sample());
  sum_last();
  edge_forces(elapsed);
  sum_wrenches(boundaries_, surfaces_, elapsed);
}

void Subdomain::pair_forces(Run& run, double elapsed, const Sample& sample) {
  if (run.candidates && path_ < run.activation) return;
  PairJob job{};
  job.record = sample.record, job.accumulate = sample.accumulate;
  job.spheres = spheres();
  job.blocks = blocks_.data() + run.first, job.shapes = shapes_.data() + run.first;
  job.lines = lines_.data() + run.lines;
  job.count = run.blocks;
  job.uniform = uniform_;
  job.elapsed = elapsed;
  job.path = path_;
  job.activation = run.candidates ? activation_.data() + run.first : nullptr;
  job.cutoff = laws_.cutoff(run.law);
  job.ring = ring();
  kernel_.pairs(laws_[run.law], job);
  if (run.candidates) run.activation = *std::min_element(job.activation, job.activation + run.blocks);
  if (!sample.accumulate) return;
  run.last = job.sums;
  take(job.sums, run.across ? 0.5 : 1, sample.weight);
}

void Subdomain::take(const RunSums& s, double share, double weight) {
  sums_.lost += Losses{share * weight * s.damped, share * weight * s.slid, share * weight * s.rolled};
}

/// What is stored, touches and overlaps, of each run as it was last sampled.
void Subdomain::sum_last() {
  const auto add = [&](const RunSums& s, double share, bool between_spheres) {
    sums_.stored += share * s.stored;
    if (between_spheres) sums_.pairs += share * s.within_cutoff;
    sums_.overlap = std::max(sums_.overlap, s.overlap);
  };
  for (const Run& run : runs_) add(run.last, run.across ? 0.5 : 1, true);
  for (const RunSums& last : plane_last_) add(last, 1, false);
}

void Subdomain::plane_forces(PlaneRun& run, double elapsed, const Sample& sample) {
  PlaneJob job = plane_job(boundaries_[run.boundary], particles_, elapsed);
  job.record = sample.record;
  job.blocks = surfaces_.plane_blocks.data() + run.first;
  job.count = run.blocks, job.contacts = run.contacts;
  job.cutoff = laws_.surface_cutoff(run.law);
  job.lines = surfaces_.plane_lines.data() + run.lines;
  job.ring = ring();
  kernel_.planes(laws_[run.law], job);
  if (sample.accumulate) {
    plane_last_[static_cast<std::size_t>(&run - surfaces_.plane_runs.data())] = job.sums;
    take(job.sums, 1, sample.weight);
  }
  run.wrench = {{job.force[0], job.force[1], job.force[2]}, {job.moment[0], job.moment[1], job.moment[2]}};
  run.in_reach = job.sums.within_cutoff;
}

/// At edges, corners and curved surfaces, whose losses are summed in every step.
void Subdomain::edge_forces(double elapsed) {
  const SurfaceForces forces{kernel_, laws_, particles_, boundaries_, surfaces_, elapsed};
  for (SurfaceChunk& chunk : surfaces_.chunks) {
    chunk.lost = {};
    forces.evaluate(chunk);
    sums_.lost += chunk.lost;
    sums_.stored += chunk.stored;
    if (exceeds(chunk.max_overlap, sums_.overlap)) sums_.overlap = chunk.max_overlap;
  }
  for (const std::uint32_t k : surfaces_.entry_order) {
    const SurfaceEntry& e = surfaces_.entries[k];
    sums_of_[e.sphere].f += Four{e.force.x, e.force.y, e.force.z, 0};
    sums_of_[e.sphere].t += Four{e.torque.x, e.torque.y, e.torque.z, static_cast<double>(e.touching)};
  }
}

template <class Job>
Job Subdomain::job_of_all() {
  const Vec3& g = options_.gravity;
  return {{.spheres = spheres(),
           .mixed = nullptr,
           .begin = 0,
           .end = static_cast<std::uint32_t>(size()),
           .ring = ring(),
           .gravity = {g.x, g.y, g.z},
           .uniform = uniform_}};
}

void Subdomain::observe(const EngineStep& step) {
  if (size() == 0) return;
  auto job = job_of_all<ObserveJob>();
  job.before = step.dt_before, job.dt = step.dt;
  kernel_.observe(job);
  sums_.kinetic = job.kinetic, sums_.rotational = job.rotational, sums_.gravity = job.potential;
}

void Subdomain::observe(const EngineStep& step, Snapshot& out) const {
  const double back = 0.5 * step.dt_before;
  for (std::size_t i = 0; i < size(); ++i) {
    const Sphere& s = particles_[i];
    const Four &f = sums_of_[i].f, &t = sums_of_[i].t;
    const Vec3 force = Vec3{f[0], f[1], f[2]} + s.m * options_.gravity, torque{t[0], t[1], t[2]};
    out.id.push_back(s.id), out.radius.push_back(s.r), out.material.push_back(s.material);
    out.position.push_back(s.x);
    out.velocity.push_back(s.v + force * (back / s.m));
    out.angular_velocity.push_back(s.w + torque * (back / inertia(s)));
    out.force.push_back(force), out.torque.push_back(torque);
    out.contacts.push_back(static_cast<int>(t[3]));
  }
}

void Subdomain::move(const EngineStep& step) {
  if (size() == 0) return;
  auto job = job_of_all<MoveJob>();
  job.kick = 0.5 * (step.dt + step.dt_before), job.dt = step.dt;
  kernel_.move(job);
  sums_.speed2 = job.speed2, sums_.squares = job.squares;
}

}  // namespace subsoil::dem
