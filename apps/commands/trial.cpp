#include "apps/commands/trial.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <vector>

#include "apps/commands/stopwatch.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/series_writer.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/columns.hpp"
#include "libsim/run/crossings.hpp"
#include "libsim/run/frames.hpp"
#include "libsim/run/machine_fault.hpp"
#include "libsim/run/process.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/run/schedule.hpp"

namespace subsoil::sim {
namespace {

/// A folder that is gone afterwards, also when something is thrown.
struct ScratchFolder {
  ScratchFolder()
      : path(std::filesystem::temp_directory_path() / fmt::format("subsoil-check-{}", static_cast<long>(getpid()))) {
    std::filesystem::create_directories(path);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path path;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Longest settling that is likely: fall of the loose column, the ramp of the staged laws, and the relaxation of the
/// bed, taken as twenty times the time a sphere needs to fall by its radius.
double settling_time(const Scenario& s, const World& world) {
  if (!s.soil || !s.soil->bed) return 0;
  const BedSection& bed = *s.soil->bed;
  if (!bed.settles()) return 0;
  const Settle settle = bed.settle.value_or(Settle{});
  double time = settle.duration.value_or(0);
  const double g = dem::norm(s.gravity);
  if (time == 0 && g > 0 && !world.bed->spheres().empty()) time = 20 * std::sqrt(2 * world.bed->spheres()[0].r / g);
  if (bed.fill == Fill::random && g > 0 && s.soil->container) time += std::sqrt(8 * s.soil->container->size.y / g);
  if (settle.staged(bed.fill)) time += settle.ramp;
  for (const FibreSection& f : bed.fibres)  // they fall by about their length
    if (g > 0) time += settle.duration.value_or(2 * std::sqrt(2 * f.length / g));
  return std::min(time, settle.at_most);
}

/// Times at which something is written over the run.
double count_of(double end, double interval, std::size_t listed) {
  return 1 + (interval > 0 ? std::floor(end / interval) : 0) + static_cast<double>(listed);
}

/// Numbers as the run writes them: a lattice at rest, which stands for a bed that is poured, packs into a fifth of what
/// spheres do that lie and move at random.
void make_irregular(dem::Snapshot& shot) {
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> share(-1, 1);
  const auto vary = [&](std::vector<Vec3>& all, double by) {
    for (Vec3& v : all) v += by * Vec3{share(random), share(random), share(random)};
  };
  const double radius = shot.radius.empty() ? 0 : shot.radius.front();
  vary(shot.position, 0.5 * radius);
  for (auto* column : {&shot.velocity, &shot.angular_velocity, &shot.force, &shot.torque}) {
    double largest = 0;
    for (const Vec3& v : *column) largest = std::max(largest, dem::norm(v));
    vary(*column, largest > 0 ? largest : 1e-3);
  }
}

/// Steps, rows and frames of the run, as far as its end.
class Rehearsal {
 public:
  Rehearsal(const Loaded& loaded, World& world)
      : s_(loaded.scenario),
        world_(world),
        simulation_(world.bed.get(), world.machine.get(), world.body_surfaces, world.motions,
                    {.soil_step = world.step.soil_step,
                     .soil_steps = static_cast<int>(s_.time.machine.soil_steps),
                     .machine_step = world.step.machine_step}),
        columns_(loaded, world, simulation_),
        row_(columns_.list().size(), 0.0),
        series_(scratch_.path / "series.csv", columns_.list(), world.bed ? 9 : csv::exact_digits),
        rows_due_(s_.output.row_interval(), s_.output.series_at, 0),
        steps_(std::max(1L, static_cast<long>(std::ceil(s_.time.end / simulation_.window_length() - 1e-6))) *
               std::lround(simulation_.window_length() / simulation_.step_length())),
        frames_once_(Clock::now()),
        frames_(scratch_.path, s_, world_, simulation_) {
    const Crossings refuses_what_it_cannot_watch(loaded, columns_);
    if (!world.bed) simulation_.end_at(s_.time.end);
  }

  long steps() const { return steps_; }
  std::size_t columns() const { return row_.size(); }

  /// s of all steps, with the rows of a machine alone: of all of them where that takes no longer than the dry run may
  /// or the run is short, else from a middle batch (so that a spell of other work is not taken for the run's own) or
  /// the mean. The steps of a bed cost much the same, those of a machine do not: it gets longer.
  double time_of_steps() {
    const double at_most = world_.bed ? 0.3 : 2, of_batch = 0.1 * at_most;  // s
    std::vector<double> batches;
    const Clock::time_point start = Clock::now();
    while (taken_ < steps_ - 1 && (taken_ < 8 || (seconds_since(start) < at_most && taken_ < 2000))) {
      const Clock::time_point begin = Clock::now();
      const long size = std::min(taken_ < 8 ? 4L : 20L, steps_ - 1 - taken_);
      long count = 0;
      do step({});
      while (++count < size && seconds_since(begin) < of_batch);
      batches.push_back(seconds_since(begin) / static_cast<double>(count));
    }
    const double all = seconds_since(start);
    if (batches.empty()) return 0;
    const bool uneven = world_.bed == nullptr || taken_ >= steps_ - 1;
    per_step_ = uneven ? all / static_cast<double>(taken_) : median(batches);
    return per_step_ * static_cast<double>(steps_);
  }
  double per_step() const { return per_step_; }

  /// s of a row of a bed: its sums over all spheres, of the instants before and after it, and its numbers.
  double time_of_row() {
    if (!world_.bed) return 0;
    columns_.take_instant(row_);
    const Clock::time_point begin = Clock::now();
    for (int k = 0; k < 8; ++k) series_.write(row_);
    return seconds_since(begin) / 8 + per_step_;
  }

  struct Frames {
    double once = 0, each = 0;              // s, once: with all other files that a run writes once
    double bytes_once = 0, bytes_each = 0;  // on the disk
  };
  /// The first frame is put on the disk at once, the others come behind it: of a machine alone, where what names a
  /// frame costs as much as what is in it and grows with their number, as many as the run has.
  /// @param count frames of the run
  Frames frames(long count) {
    constexpr long most = 200, of_bed = 2;
    const long behind = world_.bed ? of_bed : std::clamp(count - 1, 1L, most);
    dem::Snapshot* const shot = frames_.begin(0);
    if (world_.bed) {
      // Lists are built while the memory of the contacts before stands beside them: that is when a run needs most.
      world_.bed->surfaces_changed();
      step({.energy = true, .snapshot = shot, .contacts = frames_.contacts()});
      make_irregular(*shot);
    }
    frames_.write(0, 0);
    Frames out;
    out.once = seconds_since(frames_once_) - seconds_of_steps_;
    const Clock::time_point begin = Clock::now();
    for (long k = 1; k <= behind; ++k) frames_.write(static_cast<double>(k), k);
    out.each = seconds_since(begin) / static_cast<double>(behind);
    out.once += time_of_ends();
    const auto bytes = [&](const char* name) {
      std::error_code none;
      const auto size = std::filesystem::file_size(scratch_.path / name, none);
      return none ? 0.0 : static_cast<double>(size);
    };
    out.bytes_once = bytes("frames/static.h5");
    double all = bytes("run.xdmf") + bytes("run.h5");
    std::error_code none;
    for (const auto& file : std::filesystem::directory_iterator(scratch_.path / "frames", none))
      if (file.path().filename() != "static.h5") all += static_cast<double>(file.file_size());
    out.bytes_each = all / static_cast<double>(1 + behind);
    return out;
  }

 private:
  void step(const dem::Bed::Request& request) {
    const Clock::time_point begin = Clock::now();
    if (columns_.needs_every_step()) columns_.take_instant(row_);
    try {
      simulation_.step(request);
    } catch (const std::exception&) {
      // As in a run: a machine that is not resolved throws the soil about.
      if (const std::string fault = machine_fault(s_, world_); !fault.empty()) throw std::runtime_error(fault);
      throw;
    }
    if (columns_.has_means()) columns_.take_step(row_, false);
    if (!world_.bed && rows_due_.due(simulation_.time(), 0.5 * simulation_.step_length())) {
      columns_.take_instant(row_);
      series_.write(row_);
    }
    ++taken_;
    seconds_of_steps_ += seconds_since(begin);
  }

  /// s of what stands beside the frames and of their publishing: waits for the disk, all but nothing else.
  double time_of_ends() {
    const Clock::time_point begin = Clock::now();
    write_atomically(scratch_.path / "scenario.yaml", write_scenario(s_));
    if (!world_.bed && s_.output.state == State::full) {
      RunProgress progress;
      frames_.publish(progress);
      progress.series_bytes = series_.sync();
      save_run(state_path(scratch_.path, s_.time.end), s_, {}, world_, simulation_, progress);
    }
    frames_.finish();
    constexpr std::size_t summary_bytes = 20000;
    write_atomically(scratch_.path / "summary.json", std::string(summary_bytes, ' '));
    return seconds_since(begin);
  }

  const Scenario& s_;
  World& world_;
  ScratchFolder scratch_;
  coupling::Simulation simulation_;
  Columns columns_;
  std::vector<double> row_;
  SeriesWriter series_;
  Schedule rows_due_;
  long steps_, taken_ = 0;
  double per_step_ = 0, seconds_of_steps_ = 0;
  Clock::time_point frames_once_;
  FrameOutput frames_;
};

/// A state of the bed, as it is in the trial; of one that settles with the contacts that it has then.
struct StateSize {
  double spheres = 0, pairs = 0;

  StateSize(const Scenario& s, const World& world) {
    if (!world.bed || (s.output.state != State::full && !s.output.state_every)) return;
    constexpr double pairs_at_rest = 2.5;  // per sphere, five contacts on each (docs/reference/beds.md)
    spheres = static_cast<double>(world.bed->spheres().size());
    pairs = static_cast<double>(world.bed->touching_pairs());
    if (s.soil && s.soil->bed && s.soil->bed->settles()) pairs = std::max(pairs, pairs_at_rest * spheres);
  }
  double on_disk() const { return 200 * spheres + 130 * pairs; }  ///< bytes; 7.2 MB of 16,084 and 29,800
  /// While it is written, beside the bed: measured as the peak of runs with less that of runs without
  /// `output.state: full`, 40,234 and 152,060 spheres without contacts, 16,084 with 29,800.
  double in_memory() const { return 530 * spheres + 220 * pairs; }
};

double states_of(const Scenario& s) { return 1 + (s.output.state_every ? s.time.end / *s.output.state_every : 0); }

}  // namespace

Trial try_out(const Loaded& loaded, World& world, double spheres, double until_now) {
  const Scenario& s = loaded.scenario;
  const double there = world.bed ? static_cast<double>(world.bed->spheres().size()) : 0;
  const double more = there > 0 ? spheres / there : 1;
  Trial trial;
  trial.spheres = spheres;
  trial.settling = settling_time(s, world);
  Rehearsal rehearsal(loaded, world);
  Estimate& cost = trial.cost;
  cost.steps = rehearsal.steps();
  cost.frames = std::lround(count_of(s.time.end, frame_interval(s), s.output.at.size()));
  const double rows = count_of(s.time.end, s.output.row_interval(), s.output.series_at.size());
  const double stepping = more * rehearsal.time_of_steps(), row = more * rehearsal.time_of_row();
  cost.seconds_per_step = more * rehearsal.per_step();
  const Rehearsal::Frames frame = rehearsal.frames(cost.frames);
  const StateSize state(s, world);
  // A bed settles with the stable step, however fine the run's own is for its impacts.
  const double settling_step =
      world.bed ? s.time.soil_step ? world.step.soil_step : s.time.safety * world.step.limit.step : 1;
  cost.wall_time = until_now + stepping + cost.seconds_per_step * trial.settling / settling_step + rows * row +
                   more * (frame.once + frame.each * static_cast<double>(cost.frames));
  cost.disk =
      more * (frame.bytes_once + frame.bytes_each * static_cast<double>(cost.frames) + states_of(s) * state.on_disk()) +
      rows * (world.bed && s.output.digits == SeriesDigits::nine ? 11.0 : 20.0) *
          static_cast<double>(rehearsal.columns());
  cost.memory = peak_memory();
  if (world.bed) {
    constexpr double bytes = 520;  // of a sphere in a bed that is stepped (docs/performance.md)
    cost.memory += std::max(0.0, spheres - there) * bytes + more * state.in_memory();
    trial.particle_rate = cost.seconds_per_step > 0 ? spheres / cost.seconds_per_step : 0;
  }
  return trial;
}

}  // namespace subsoil::sim
