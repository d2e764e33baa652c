#include "apps/mpi/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "apps/build/laws.hpp"
#include "apps/mpi/messages.hpp"
#include "apps/mpi/rank.hpp"
#include "libdem/particles/fixed.hpp"
#include "libdem/step/state_numbers.hpp"

namespace subsoil::mpi {
namespace {

enum class Task { build, begin, step, spheres, contacts, end, dismiss };

struct Order {
  Task task = Task::dismiss;
  dem::EngineStep step{};
  bool snapshot = false;
};

Order broadcast_order(Order order, MPI_Comm all) {
  MPI_Bcast(&order, sizeof order, MPI_BYTE, 0, all);
  return order;
}

/// Where a boundary stands and how it moves.
struct Motion {
  dem::Pose pose;
  dem::Vec3 velocity, angular_velocity;
  bool active;
};

void broadcast_motions(std::vector<dem::Boundary>& boundaries, MPI_Comm all) {
  std::vector<Motion> motions;
  for (const dem::Boundary& b : boundaries) motions.push_back({b.pose, b.velocity, b.angular_velocity, b.active});
  broadcast(motions, all);
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Motion& m = motions[b];
    boundaries[b].pose = m.pose, boundaries[b].active = m.active;
    boundaries[b].velocity = m.velocity, boundaries[b].angular_velocity = m.angular_velocity;
  }
}

/// On rank 0 the sums over all processes take the place of its own.
void sum_wrenches(std::vector<dem::Boundary>& boundaries, MPI_Comm all) {
  std::vector<double> mine;
  const auto each = [&](auto& of, const auto& use) {
    for (auto& b : of) {
      use(b.wrench.force), use(b.wrench.moment);
      for (auto& mesh : b.meshes) use(mesh.force), use(mesh.moment);
    }
  };
  each(boundaries, [&](const dem::Vec3& v) { dem::put(mine, v); });
  for (const dem::Boundary& b : boundaries) mine.push_back(b.contacts);
  std::vector<double> sums(mine.size());
  MPI_Reduce(mine.data(), sums.data(), static_cast<int>(mine.size()), MPI_DOUBLE, MPI_SUM, 0, all);
  dem::StateReader read{sums};
  int rank = 0;
  MPI_Comm_rank(all, &rank);
  if (rank != 0) return;
  each(boundaries, [&](dem::Vec3& v) { v = read.vector(); });
  for (dem::Boundary& b : boundaries) b.contacts = static_cast<int>(read());
}

/// Of rank 0's state in parts, so that no process has to hold all of it: take(numbers, ids) on every rank.
template <class Take>
void share_out(const std::vector<double>& numbers, const std::vector<std::int64_t>& ids, std::size_t each, MPI_Comm all,
               const Take& take) {
  constexpr std::size_t part = std::size_t{1} << 18;
  std::size_t count = ids.size() / 2;
  MPI_Bcast(&count, sizeof count, MPI_BYTE, 0, all);
  for (std::size_t begin = 0; begin < count; begin += part) {
    const std::size_t end = std::min(begin + part, count);
    std::vector<double> some;
    std::vector<std::int64_t> some_ids;
    if (!ids.empty()) {
      some.assign(numbers.begin() + static_cast<std::ptrdiff_t>(each * begin),
                  numbers.begin() + static_cast<std::ptrdiff_t>(each * end));
      some_ids.assign(ids.begin() + static_cast<std::ptrdiff_t>(2 * begin),
                      ids.begin() + static_cast<std::ptrdiff_t>(2 * end));
    }
    broadcast(some, all), broadcast(some_ids, all);
    take(some, some_ids);
  }
}

/// With which laws and boundaries: of rank 0 those it has, elsewhere built from the same files.
std::unique_ptr<Rank> begin_rank(MPI_Comm all, Beginning beginning, dem::LawTable laws,
                                 std::vector<dem::Boundary> boundaries, const dem::Bed::State& state) {
  MPI_Bcast(&beginning, sizeof beginning, MPI_BYTE, 0, all);
  broadcast_motions(boundaries, all);
  auto rank = std::make_unique<Rank>(all, beginning, std::move(laws), std::move(boundaries));
  share_out(state.spheres, state.ids, 11, all, [&](const auto& n, const auto& ids) { rank->take_spheres(n, ids); });
  share_out(state.pairs, state.pair_ids, dem::kPairRecord, all,
            [&](const auto& n, const auto& ids) { rank->take_pairs(n, ids); });
  share_out(state.surfaces, state.surface_ids, 3 + dem::kPairRecord, all,
            [&](const auto& n, const auto& ids) { rank->take_surfaces(n, ids); });
  rank->begin();
  return rank;
}

template <class T>
std::vector<T> permuted(const std::vector<T>& values, const std::vector<std::size_t>& order) {
  std::vector<T> out;
  out.reserve(values.size());
  for (const std::size_t k : order) out.push_back(values[k]);
  return out;
}

/// Of all processes on rank 0, in rising id.
void gather_snapshot(dem::Snapshot& s, MPI_Comm all) {
  s.id = gather(std::move(s.id), all);
  std::vector<std::size_t> order(s.id.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return s.id[a] < s.id[b]; });
  const auto collect = [&](auto& values) { values = permuted(gather(std::move(values), all), order); };
  collect(s.radius), collect(s.material), collect(s.contacts);
  collect(s.position), collect(s.velocity), collect(s.angular_velocity), collect(s.force), collect(s.torque);
  s.id = permuted(s.id, order);
  s.bonds.clear();
}

dem::Bed::State gather_state(Rank& rank, bool contacts, MPI_Comm all) {
  dem::Bed::State s = rank.state(contacts);
  s.spheres = gather(std::move(s.spheres), all), s.ids = gather(std::move(s.ids), all);
  s.pairs = gather(std::move(s.pairs), all), s.pair_ids = gather(std::move(s.pair_ids), all);
  s.surfaces = gather(std::move(s.surfaces), all), s.surface_ids = gather(std::move(s.surface_ids), all);
  return s;
}

/// What every process does in a step; the snapshot is its own part.
dem::EngineSums step_rank(Rank& rank, dem::EngineStep step, dem::Snapshot* snapshot, MPI_Comm all) {
  broadcast_motions(rank.boundaries(), all);
  step.snapshot = snapshot;
  if (snapshot != nullptr) *snapshot = {};
  const dem::EngineSums sums = rank.step(step);
  sum_wrenches(rank.boundaries(), all);
  if (snapshot != nullptr) gather_snapshot(*snapshot, all);
  return sums;
}

/// For each material the least and the largest sphere twice: what the stable step is found by.
std::vector<dem::SphereSpec> extremes_of(std::span<const dem::Sphere> spheres, int materials) {
  std::vector<std::array<const dem::Sphere*, 2>> found(static_cast<std::size_t>(materials), {nullptr, nullptr});
  for (const dem::Sphere& s : spheres) {
    auto& [least, largest] = found[s.material];
    if (least == nullptr || s.r < least->r) least = &s;
    if (largest == nullptr || s.r > largest->r) largest = &s;
  }
  std::vector<dem::SphereSpec> out;
  for (const auto& of_material : found)
    for (const dem::Sphere* s : of_material)
      if (s != nullptr) out.push_back({s->x, {}, {}, s->r, dem::density(*s), s->material});
  return out;
}

std::vector<dem::Boundary> boundaries_of(const dem::Bed& bed) {
  std::vector<dem::Boundary> out;
  for (int b = 0; b < bed.boundary_count(); ++b) out.push_back(bed.boundary(b));
  return out;
}

class MpiEngine final : public dem::BedEngine {
 public:
  MpiEngine(MPI_Comm all, const app::RunRequest& request, const app::World& world) : all_(all), laws_(world.laws) {
    int ranks = 1;
    MPI_Comm_size(all, &ranks);
    name_ = fmt::format("LIGGGHTS on {} process{}", ranks, ranks == 1 ? "" : "es");
    // The others read the same files: scenario and what overrides it, one word after another.
    std::vector<char> words;
    const auto add = [&](const std::string& word) {
      words.insert(words.end(), word.c_str(), word.c_str() + word.size() + 1);
    };
    add(request.scenario);
    for (const std::string& set : request.sets) add(set);
    broadcast_order({.task = Task::build}, all_);
    broadcast(words, all_);
    std::vector<dem::SphereSpec> extremes = extremes_of(world.bed->spheres(), laws_.materials);
    broadcast(extremes, all_);
  }
  ~MpiEngine() override { broadcast_order({.task = Task::end}, all_); }

  const char* name() const override { return name_.c_str(); }

  void begin(const dem::Bed::State& state, const dem::BedOptions& options,
             std::span<const dem::Boundary> boundaries) override {
    Beginning b;
    b.gravity = options.gravity, b.floor_drop = options.floor_drop, b.spheres = state.ids.size() / 2;
    dem::Bounds box;
    double radii = 0;
    b.smallest = HUGE_VAL;
    for (std::size_t k = 0; k < b.spheres; ++k) {
      const double* s = state.spheres.data() + 11 * k;
      box.include(dem::Vec3{s[0], s[1], s[2]});
      b.smallest = std::min(b.smallest, s[9]), b.largest = std::max(b.largest, s[9]), radii += s[9];
    }
    b.low = box.low, b.high = box.high;
    b.skin = options.skin > 0 ? options.skin : 0.4 * radii / static_cast<double>(b.spheres);
    b.sample_every = options.sample_every > 0 ? options.sample_every : b.spheres <= 5000 ? 1 : 32;
    std::snprintf(b.simd, sizeof b.simd, "%s", options.simd.c_str());
    broadcast_order({.task = Task::begin}, all_);
    rank_ = begin_rank(all_, b, laws_, {boundaries.begin(), boundaries.end()}, state);
  }

  dem::EngineSums step(const dem::EngineStep& step, std::span<dem::Boundary> boundaries) override {
    std::vector<dem::Boundary>& mine = rank_->boundaries();
    for (std::size_t b = 0; b < mine.size(); ++b) {
      mine[b].pose = boundaries[b].pose, mine[b].active = boundaries[b].active;
      mine[b].velocity = boundaries[b].velocity, mine[b].angular_velocity = boundaries[b].angular_velocity;
    }
    broadcast_order({.task = Task::step, .step = step, .snapshot = step.snapshot != nullptr}, all_);
    const dem::EngineSums sums = step_rank(*rank_, step, step.snapshot, all_);
    for (std::size_t b = 0; b < mine.size(); ++b)
      boundaries[b].wrench = mine[b].wrench, boundaries[b].meshes = mine[b].meshes,
      boundaries[b].contacts = mine[b].contacts;
    return sums;
  }

  dem::Bed::State collect(bool contacts) override {
    broadcast_order({.task = contacts ? Task::contacts : Task::spheres}, all_);
    return gather_state(*rank_, contacts, all_);
  }

 private:
  MPI_Comm all_;
  dem::LawTable laws_;
  std::string name_;
  std::unique_ptr<Rank> rank_;
};

/// Laws and boundaries of the scenario that rank 0 runs, without spheres.
app::World build_like_rank_0(MPI_Comm all) {
  std::vector<char> words;
  broadcast(words, all);
  std::vector<dem::SphereSpec> extremes;
  broadcast(extremes, all);
  std::vector<std::string> sets;
  for (std::size_t at = 0; at < words.size(); at += std::strlen(words.data() + at) + 1)
    sets.emplace_back(words.data() + at);
  const std::string scenario = sets.front();
  sets.erase(sets.begin());
  return app::build_world(app::load_scenario(scenario, sets),
                          {.threads = 1, .place_soil = false, .restored = extremes});
}

}  // namespace

std::unique_ptr<dem::BedEngine> make_engine(MPI_Comm all, const app::RunRequest& request, const app::Loaded&,
                                            const app::World& world) {
  if (world.bed->spheres().empty()) throw std::invalid_argument("has no spheres to share out");
  return std::make_unique<MpiEngine>(all, request, world);
}

void dismiss(MPI_Comm all) { broadcast_order({.task = Task::dismiss}, all); }

void serve(MPI_Comm all) {
  std::optional<app::World> world;
  std::unique_ptr<Rank> rank;
  dem::Snapshot snapshot;
  for (;;) {
    const Order order = broadcast_order({}, all);
    switch (order.task) {
      case Task::build:
        world = build_like_rank_0(all);
        break;
      case Task::begin:
        rank = begin_rank(all, {}, world->laws, boundaries_of(*world->bed), {});
        break;
      case Task::step:
        step_rank(*rank, order.step, order.snapshot ? &snapshot : nullptr, all);
        break;
      case Task::spheres:
        gather_state(*rank, false, all);
        break;
      case Task::contacts:
        gather_state(*rank, true, all);
        break;
      case Task::end:
        rank.reset();
        break;
      case Task::dismiss:
        return;
    }
  }
}

}  // namespace subsoil::mpi
