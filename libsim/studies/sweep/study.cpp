#include "libsim/studies/sweep/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "libsim/base/deflate.hpp"
#include "libsim/base/json.hpp"
#include "libsim/base/live_line.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/old_results.hpp"
#include "libsim/post/run_folder.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {
namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// Tells scenarios apart: a checksum of the one that runs, with every default explicit.
std::string mark_of(const Study& study, const SweepPoint& point) {
  const std::string text = write_scenario(load_scenario(study.scenario, point.sets).scenario);
  return fmt::format("{:08x}", crc32(bytes_of(text)));
}

std::optional<Json> read_point(const std::filesystem::path& folder) {
  const Json json = read_json_if_whole(folder / "point.json");
  if (!json.is_object() || !json.contains("end") || !json.contains("mark")) return {};
  return json;
}

/// The last line of a log that says something.
std::string last_line(const std::filesystem::path& log) {
  std::ifstream file(log);
  std::string line, last;
  while (std::getline(file, line))
    if (!line.empty()) last = line;
  return last;
}

std::string cause_of(const std::filesystem::path& folder, int code) {
  try {
    const RunFolder run = read_run_folder(folder);
    if (const std::string failure = run.text({"run", "failure"}); !failure.empty()) return failure;
  } catch (const std::exception&) {
  }
  if (code > 128) return fmt::format("ended by signal {}; was memory short?", code - 128);
  const std::string line = last_line(folder / "log.txt");
  return line.empty() ? fmt::format("exit {}", code) : line;
}

/// Time of the last row of a series that grows; -1 without.
double reached_time(const std::filesystem::path& folder) {
  std::ifstream file(folder / "series.csv", std::ios::binary | std::ios::ate);
  if (!file) return -1;
  const std::streamoff size = file.tellg(), from = std::max<std::streamoff>(0, size - 20000);
  file.seekg(from);
  std::string line;
  double time = -1;
  while (std::getline(file, line)) {
    double t = 0;
    if (!file.eof() && csv::to_number(line.substr(0, line.find(',')), t)) time = t;
  }
  return time;
}

/// Progress of all points: what is done, what runs, how long it will take.
class Progress {
 public:
  Progress(const Study& study, const std::filesystem::path& folder, const std::vector<std::size_t>& points,
           std::size_t places)
      : folder_(folder), points_(points), all_(study.points.size()), places_(places) {
    done_ = all_ - points.size();
    for (const std::size_t p : points)
      ends_.push_back(load_scenario(study.scenario, study.points[p].sets).scenario.time.end);
  }

  void took(double wall_time, bool failed) {
    ++done_, ++finished_;
    failed_ += failed ? 1 : 0;
    spent_ += wall_time;
  }

  void show(const std::vector<std::size_t>& running) {
    if (!line_.due()) return;
    double share = 0;  // of a run, that running ones have behind them
    for (const std::size_t job : running)
      if (const double t = reached_time(point_folder(folder_, points_[job])); t > 0 && ends_[job] > 0)
        share += std::min(1.0, t / ends_[job]);
    std::string text = fmt::format("{} of {} points done{}, {} running", done_, all_,
                                   failed_ > 0 ? fmt::format(" ({} failed)", failed_) : "", running.size());
    const double left = static_cast<double>(points_.size() - finished_) - share;
    // Wall time that one run costs: of those done, before that of what runs so far.
    const double behind = static_cast<double>(finished_) + share;
    const double elapsed = line_.elapsed();
    if (behind > 0.02) {
      const double each = finished_ > 0 ? spent_ / static_cast<double>(finished_)
                                        : elapsed * static_cast<double>(running.size()) / share;
      text += ", remaining " + clock_text(each * left / static_cast<double>(std::min(places_, points_.size())));
    }
    line_.show(text);
  }
  void close() { line_.close(); }

 private:
  const std::filesystem::path& folder_;
  const std::vector<std::size_t>& points_;
  std::size_t all_, places_, done_ = 0, finished_ = 0, failed_ = 0;
  std::vector<double> ends_;
  double spent_ = 0;
  LiveLine line_;
};

}  // namespace

std::filesystem::path point_folder(const std::filesystem::path& folder, std::size_t point) {
  return folder / "points" / fmt::format("{:04}", point + 1);
}

bool point_is_open(const Study& study, const std::filesystem::path& folder, std::size_t k, bool again) {
  const std::optional<Json> json = read_point(point_folder(folder, k));
  if (!json) return true;
  if ((*json)["mark"] != mark_of(study, study.points[k]))
    throw ScenarioError(fmt::format(
        "{}: point {} was run with another scenario, other values or other contents of a file; name another --out",
        folder.string(), k + 1));
  return again && (*json)["end"] == "failed";
}

std::vector<std::size_t> open_points(const Study& study, const std::filesystem::path& folder, bool again) {
  std::vector<std::size_t> open;
  for (std::size_t k = 0; k < study.points.size(); ++k)
    if (point_is_open(study, folder, k, again)) open.push_back(k);
  return open;
}

bool run_points(const Study& study, const std::filesystem::path& folder, const std::vector<std::size_t>& points,
                const PoolOptions& options) {
  std::vector<PoolJob> jobs;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);  // all points together
  for (const std::size_t k : points) {
    const std::filesystem::path place = point_folder(folder, k);
    PoolJob job{{"run", study.scenario, "--out", place.string(), "--force"}, place / "log.txt"};
    job.arguments.insert(job.arguments.end(), {"--threads", std::to_string(options.threads)});
    for (const std::string& set : study.points[k].sets) job.arguments.insert(job.arguments.end(), {"--set", set});
    jobs.push_back(std::move(job));
    std::filesystem::create_directories(place);
    // The run of a killed sweep holds its folder until it has died, too: a moment, on a busy computer. Of one that
    // continues the point says so itself.
    const std::chrono::duration<double> left = until - std::chrono::steady_clock::now();
    await_unlocked(place / "run.lock", left.count());
    // What a kill has left of the point must not be taken for a result of this run.
    for (const char* file : {"point.json", "summary.json", "series.csv"}) std::filesystem::remove(place / file);
  }
  Progress progress(study, folder, points, pool_places(usable_cores(), options).size());
  const bool whole = run_pool(
      jobs, options,
      [&](std::size_t job, const PoolEnd& end) {
        const std::filesystem::path place = point_folder(folder, points[job]);
        Json json{{"mark", mark_of(study, study.points[points[job]])},
                  {"set", study.points[points[job]].sets},
                  {"end", end.code == 0 ? "reached" : "failed"},
                  {"wall time [s]", end.wall_time}};
        if (end.code != 0) json["cause"] = cause_of(place, end.code);
        if (study.keep == Keep::numbers) remove_frames_and_states(place);
        write_atomically(place / "point.json", json_text(json, 1) + "\n");
        progress.took(end.wall_time, end.code != 0);
      },
      [&](const std::vector<std::size_t>& running) { progress.show(running); });
  progress.close();
  return whole;
}

PointResult read_result(const Study& study, const std::filesystem::path& folder, std::size_t k) {
  PointResult r;
  r.value.assign(study.numbers.size(), no_value), r.half_width = r.value;
  r.unit.resize(study.numbers.size());
  const std::optional<Json> json = read_point(point_folder(folder, k));
  if (!json) return r;
  r.end = (*json)["end"] == "reached" ? PointResult::End::reached : PointResult::End::failed;
  r.wall_time = json->value("wall time [s]", no_value);
  r.cause = json->value("cause", std::string());
  if (r.end != PointResult::End::reached) return r;
  try {
    const RunFolder run = read_run_folder(point_folder(folder, k));
    if (run.summary.is_object()) r.warnings = run.summary.value("warnings", r.warnings);
    for (std::size_t n = 0; n < study.numbers.size(); ++n) {
      const NumberOfRun number = take_number(run, study.numbers[n]);
      r.value[n] = number.value, r.half_width[n] = number.half_width;
      r.unit[n] = unit_of(run, study.numbers[n]);
    }
  } catch (const std::exception& error) {
    r.end = PointResult::End::failed, r.cause = error.what();
  }
  return r;
}

std::vector<PointResult> read_results(const Study& study, const std::filesystem::path& folder) {
  std::vector<PointResult> results;
  for (std::size_t k = 0; k < study.points.size(); ++k) results.push_back(read_result(study, folder, k));
  return results;
}

namespace {

std::filesystem::path lock_in(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  return folder / "lock";
}

}  // namespace

StudyLock::StudyLock(const std::filesystem::path& folder) : lock_(lock_in(folder)) {
  // A run that a killed sweep was just starting holds the lock until it has died, too: a moment, on a busy computer.
  constexpr double moment = 3;
  if (!lock_.take(moment))
    throw ScenarioError(folder.string() + ": another subsoil works in it; wait for it, or name another --out");
}

std::vector<SweepNumber> usual_numbers(const Scenario& scenario) {
  std::vector<SweepNumber> out;
  const auto add = [&](const std::string& column) {
    SweepNumber n;
    n.name = n.column = column;
    out.push_back(n);
  };
  for (const Watch& w : scenario.output.watch)
    if (w.name == "draft" || w.name == "pull") add(w.name);
  if (out.empty() && scenario.machine && scenario.has_bed()) add("soil.draft");
  if (out.empty())
    for (const Watch& w : scenario.output.watch) add(w.name);
  return out;
}

}  // namespace subsoil::sim
