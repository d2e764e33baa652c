#include "apps/mpi/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

#include "apps/mpi/messages.hpp"
#include "apps/mpi/parts.hpp"
#include "apps/mpi/rank.hpp"
#include "libdem/particles/fixed.hpp"
#include "libsim/io/frame_parts.hpp"
#include "libsim/run/frames.hpp"
#include "libsim/setup/laws.hpp"

namespace subsoil::mpi {
namespace {

enum class Task {
  build,
  begin,
  step,
  spheres,
  contacts,
  open_parts,
  write_parts,
  publish_parts,
  drop_parts,
  instant,
  restore,
  end,
  dismiss
};

struct Order {
  Task task = Task::dismiss;
  dem::EngineStep step{};
  bool snapshot = false;
  sim::PartPlace place{};
  sim::Between between{};
  double quantum = 0;
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
  each(boundaries, [&](const dem::Vec3& v) { mine.insert(mine.end(), {v.x, v.y, v.z}); });
  for (const dem::Boundary& b : boundaries) mine.push_back(b.contacts);
  std::vector<double> sums(mine.size());
  MPI_Reduce(mine.data(), sums.data(), static_cast<int>(mine.size()), MPI_DOUBLE, MPI_SUM, 0, all);
  const double* next = sums.data();
  int rank = 0;
  MPI_Comm_rank(all, &rank);
  if (rank != 0) return;
  each(boundaries, [&](dem::Vec3& v) {
    for (int d = 0; d < 3; ++d) v[d] = *next++;
  });
  for (dem::Boundary& b : boundaries) b.contacts = static_cast<int>(*next++);
}

/// Of rank 0's state in parts, so that no process has to hold all of it: take(records) on every rank.
template <class Record, class Take>
void share_out(const std::vector<Record>& records, MPI_Comm all, const Take& take) {
  constexpr std::size_t part = std::size_t{1} << 18;
  std::size_t count = records.size();
  MPI_Bcast(&count, sizeof count, MPI_BYTE, 0, all);
  for (std::size_t begin = 0; begin < count; begin += part) {
    const std::size_t end = std::min(begin + part, count);
    std::vector<Record> some;
    if (!records.empty())
      some.assign(records.begin() + static_cast<std::ptrdiff_t>(begin),
                  records.begin() + static_cast<std::ptrdiff_t>(end));
    broadcast(some, all);
    take(some);
  }
}

/// With which laws and boundaries: of rank 0 those it has, elsewhere built from the same files.
std::unique_ptr<Rank> begin_rank(MPI_Comm all, Beginning beginning, dem::LawTable laws,
                                 std::vector<dem::Boundary> boundaries, const dem::Bed::State& state) {
  MPI_Bcast(&beginning, sizeof beginning, MPI_BYTE, 0, all);
  broadcast_motions(boundaries, all);
  auto rank = std::make_unique<Rank>(all, beginning, std::move(laws), std::move(boundaries));
  share_out(state.spheres, all, [&](const auto& some) { rank->take_spheres(some); });
  share_out(state.pairs, all, [&](const auto& some) { rank->take_pairs(some); });
  share_out(state.surfaces, all, [&](const auto& some) { rank->take_surfaces(some); });
  rank->begin();
  return rank;
}

dem::Bed::State gather_state(Rank& rank, bool contacts, MPI_Comm all) {
  dem::Bed::State s = rank.state(contacts);
  s.spheres = gather(std::move(s.spheres), all);
  s.pairs = gather(std::move(s.pairs), all);
  s.surfaces = gather(std::move(s.surfaces), all);
  return s;
}

/// What every process does in a step; the snapshot is its own part, which stays with the parts of frames if there are
/// any.
dem::EngineSums step_rank(Rank& rank, dem::EngineStep step, dem::Snapshot* snapshot, std::optional<Parts>& parts,
                          MPI_Comm all) {
  broadcast_motions(rank.boundaries(), all);
  step.snapshot = snapshot;
  if (snapshot != nullptr) *snapshot = {};
  const bool kept = snapshot != nullptr && parts;
  const dem::EngineSums sums = kept ? parts->step(rank, step) : rank.step(step);
  sum_wrenches(rank.boundaries(), all);
  if (snapshot != nullptr && !kept) gather_snapshot(*snapshot, all);
  return sums;
}

/// The folder as rank 0 names it: a relative one is the same everywhere, as mpirun starts all in one.
void open_parts(std::optional<Parts>& parts, const std::string& directory, const sim::Scenario& scenario,
                double quantum, MPI_Comm all) {
  std::vector<char> words(directory.begin(), directory.end());
  broadcast(words, all);
  parts.emplace(all, std::string(words.begin(), words.end()), sim::frame_options(scenario), quantum);
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

class MpiEngine final : public dem::BedEngine, public sim::FrameParts {
 public:
  MpiEngine(MPI_Comm all, const sim::RunRequest& request, const sim::Scenario& scenario, const sim::World& world)
      : all_(all), scenario_(scenario), laws_(world.laws) {
    MPI_Comm_size(all, &ranks_);
    name_ = fmt::format("LIGGGHTS on {} process{}", ranks_, ranks_ == 1 ? "" : "es");
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
    b.gravity = options.gravity, b.floor_drop = options.floor_drop, b.spheres = state.spheres.size();
    dem::Bounds box;
    double radii = 0;
    b.smallest = HUGE_VAL;
    for (const dem::Sphere& s : state.spheres) {
      box.include(s.x);
      b.smallest = std::min(b.smallest, s.r), b.largest = std::max(b.largest, s.r), radii += s.r;
    }
    b.low = box.low, b.high = box.high;
    b.skin = options.skin > 0 ? options.skin : 0.4 * radii / static_cast<double>(b.spheres);
    b.sample_every = options.sample_every > 0 ? options.sample_every : b.spheres <= 5000 ? 1 : 32;
    std::snprintf(b.simd, sizeof b.simd, "%s", options.simd.c_str());
    broadcast_order({.task = Task::begin}, all_);
    rank_ = begin_rank(all_, b, laws_, {boundaries.begin(), boundaries.end()}, state);
  }

  dem::EngineSums step(const dem::EngineStep& step, std::span<dem::Boundary> boundaries) override {
    if (restored_) restore_parts();
    std::vector<dem::Boundary>& mine = rank_->boundaries();
    for (std::size_t b = 0; b < mine.size(); ++b) {
      mine[b].pose = boundaries[b].pose, mine[b].active = boundaries[b].active;
      mine[b].velocity = boundaries[b].velocity, mine[b].angular_velocity = boundaries[b].angular_velocity;
    }
    broadcast_order({.task = Task::step, .step = step, .snapshot = step.snapshot != nullptr}, all_);
    const dem::EngineSums sums = step_rank(*rank_, step, step.snapshot, parts_, all_);
    for (std::size_t b = 0; b < mine.size(); ++b)
      boundaries[b].wrench = mine[b].wrench, boundaries[b].meshes = mine[b].meshes,
      boundaries[b].contacts = mine[b].contacts;
    return sums;
  }

  dem::Bed::State collect(bool contacts) override {
    broadcast_order({.task = contacts ? Task::contacts : Task::spheres}, all_);
    return gather_state(*rank_, contacts, all_);
  }

  int count() const override { return ranks_; }
  void open(const std::filesystem::path& directory, double quantum) override {
    broadcast_order({.task = Task::open_parts, .quantum = quantum}, all_);
    open_parts(parts_, directory.string(), scenario_, quantum, all_);
  }
  std::string write(const sim::PartPlace& place, const sim::Between& between) override {
    broadcast_order({.task = Task::write_parts, .place = place, .between = between}, all_);
    return parts_->write(place, between);
  }
  void publish() override {
    broadcast_order({.task = Task::publish_parts}, all_);
    parts_->publish();
  }
  void drop() override {
    broadcast_order({.task = Task::drop_parts}, all_);
    parts_->drop();
  }
  dem::Snapshot gather() override {
    broadcast_order({.task = Task::instant}, all_);
    return parts_->last_instant();
  }
  /// Not before it is known which process has which spheres.
  void restore(const dem::Snapshot& spheres) override { restored_ = spheres; }

 private:
  void restore_parts() {
    broadcast_order({.task = Task::restore}, all_);
    parts_->restore(*restored_, *rank_);
    restored_.reset();
  }

  MPI_Comm all_;
  const sim::Scenario& scenario_;
  int ranks_ = 1;
  dem::LawTable laws_;
  std::string name_;
  std::unique_ptr<Rank> rank_;
  std::optional<Parts> parts_;  ///< of frames, once they are open
  std::optional<dem::Snapshot> restored_;
};

/// The scenario that rank 0 runs.
struct Likeness {
  sim::Scenario scenario;
  sim::World world;  ///< laws and boundaries, without spheres
};

Likeness build_like_rank_0(MPI_Comm all) {
  std::vector<char> words;
  broadcast(words, all);
  std::vector<dem::SphereSpec> extremes;
  broadcast(extremes, all);
  std::vector<std::string> sets;
  for (std::size_t at = 0; at < words.size(); at += std::strlen(words.data() + at) + 1)
    sets.emplace_back(words.data() + at);
  const std::string scenario = sets.front();
  sets.erase(sets.begin());
  const sim::Loaded loaded = sim::load_scenario(scenario, sets);
  return {loaded.scenario, sim::build_world(loaded, {.threads = 1, .place_soil = false, .restored = extremes})};
}

}  // namespace

std::unique_ptr<dem::BedEngine> make_engine(MPI_Comm all, const sim::RunRequest& request, const sim::Loaded& loaded,
                                            const sim::World& world) {
  if (world.bed->spheres().empty()) throw std::invalid_argument("has no spheres to share out");
  return std::make_unique<MpiEngine>(all, request, loaded.scenario, world);
}

void dismiss(MPI_Comm all) { broadcast_order({.task = Task::dismiss}, all); }

void serve(MPI_Comm all) {
  std::optional<Likeness> like;
  std::unique_ptr<Rank> rank;
  std::optional<Parts> parts;
  dem::Snapshot snapshot;
  for (;;) {
    const Order order = broadcast_order({}, all);
    switch (order.task) {
      case Task::build:
        like = build_like_rank_0(all);
        break;
      case Task::begin:
        rank = begin_rank(all, {}, like->world.laws, boundaries_of(*like->world.bed), {});
        break;
      case Task::step:
        step_rank(*rank, order.step, order.snapshot ? &snapshot : nullptr, parts, all);
        break;
      case Task::spheres:
        gather_state(*rank, false, all);
        break;
      case Task::contacts:
        gather_state(*rank, true, all);
        break;
      case Task::open_parts:
        open_parts(parts, {}, like->scenario, order.quantum, all);
        break;
      case Task::write_parts:
        parts->write(order.place, order.between);
        break;
      case Task::publish_parts:
        parts->publish();
        break;
      case Task::drop_parts:
        parts->drop();
        break;
      case Task::instant:
        parts->last_instant();
        break;
      case Task::restore:
        parts->restore({}, *rank);
        break;
      case Task::end:
        parts.reset(), rank.reset();
        break;
      case Task::dismiss:
        return;
    }
  }
}

}  // namespace subsoil::mpi
