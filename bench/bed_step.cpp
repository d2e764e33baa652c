/// Rate of the bed's step in one case: a settled bed at rest, ploughed by a tool, or pouring. scripts/bench runs it.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/bed_case.hpp"
#include "bench/peer_files.hpp"
#include "libsim/base/memory.hpp"

namespace {

using namespace subsoil;

struct Request : bench::CaseRequest {
  int threads = 1;
  long steps = 500;
  long energy_every = 50;  ///< steps between readings of the energy balance: one a millisecond
  double skin = 0;         ///< m; 0: the engine's own
  std::string simd = "auto";
  dem::Precision precision = dem::Precision::doubles;
  std::string peer_files;  ///< folder; empty: time the case
  bool idle_tool = false;  ///< the tool's hole stays, the tool touches nothing: what the tool costs is the difference
  bool json = false;
};

struct Times {
  std::vector<double> plain, with_rebuild;  ///< s of each step
  double total = 0;
};

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double median(std::vector<double> v) {
  if (v.empty()) return 0;
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

void step(dem::Bed& bed, const bench::Case& c, int tool, const dem::Bed::Request& sample) {
  bed.step(c.step, sample);
  if (tool >= 0) bed.boundary(tool).pose.position += c.tool.velocity * c.step;
}

Times run(dem::Bed& bed, const bench::Case& c, int tool, const Request& r) {
  step(bed, c, tool, {});  // builds the lists
  dem::Bed::Request sample;
  sample.energy = true;
  Times t;
  for (long i = 2; i <= r.steps; ++i) {
    const long before = bed.rebuilds();
    const double from = now();
    step(bed, c, tool, i % r.energy_every == 0 ? sample : dem::Bed::Request{});
    const double took = now() - from;
    (bed.rebuilds() > before ? t.with_rebuild : t.plain).push_back(took);
    t.total += took;
  }
  step(bed, c, tool, sample);  // energies and contacts at the end of the run asked for
  return t;
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

dem::BedOptions options_of(const Request& r) {
  dem::BedOptions options;
  options.threads = r.threads, options.simd = r.simd, options.skin = r.skin;
  options.precision = r.precision;
  return options;
}

/// What the program takes with hardly any spheres, bytes: the peak is measured against it.
double memory_of_small_bed(const Request& r) {
  bench::CaseRequest one_block = r;
  one_block.spheres = 1;
  bench::Case c = bench::make_case(one_block);
  c.spheres.resize(1000);
  c.has_tool = false;
  dem::Bed bed(c.laws, options_of(r));
  bench::fill(bed, c);
  for (int i = 0; i < 5; ++i) bed.step(c.step);
  return peak_memory();
}

/// ns per particle-step by phase, on the clock, from further steps: what is timed above is not measured so closely.
nlohmann::ordered_json phases_of(dem::Bed& bed, const bench::Case& c, int tool, const Request& r) {
  const long steps = std::min(r.steps, 500L);
  bed.measure_phases(true);
  for (long i = 0; i < steps; ++i) step(bed, c, tool, {});
  const dem::Phases p = bed.phases();
  const double each = 1e9 / (static_cast<double>(steps) * static_cast<double>(bed.spheres().size()) * bed.threads());
  return {{"phase search", each * p.search},
          {"phase pairs, force and gather", each * p.pairs},
          {"phase boundaries", each * p.surfaces},
          {"phase integrate", each * p.move},
          {"phase wait and sums", each * p.rest}};
}

nlohmann::ordered_json report(const dem::Bed& bed, const Times& t, const Request& r, double small_bed) {
  const double spheres = static_cast<double>(bed.spheres().size()), pairs = static_cast<double>(bed.touching_pairs());
  const double steps = static_cast<double>(r.steps - 1), rate = spheres * steps / t.total;
  const double plain = median(t.plain), rebuild = t.with_rebuild.empty() ? 0 : median(t.with_rebuild) - plain;
  const double fastest = t.plain.empty() ? 0 : *std::min_element(t.plain.begin(), t.plain.end());
  const double rebuilds = static_cast<double>(t.with_rebuild.size());
  return {{"simd", bed.kernel_name()},
          {"precision", r.precision == dem::Precision::mixed ? "mixed" : "double"},
          {"threads", bed.threads()},
          {"spheres", spheres},
          {"steps", r.steps},
          {"particle-steps per s", rate},
          {"pair-steps per s", rate * pairs / spheres},
          {"pairs per sphere", pairs / spheres},
          {"ns per particle-step", 1e9 / rate},
          {"ns without rebuild", 1e9 * plain / spheres},
          {"ns of the fastest step", 1e9 * fastest / spheres},
          {"rebuilds", rebuilds},
          {"ns of a rebuild", 1e9 * rebuild / spheres},
          {"share of rebuilds", rebuilds * rebuild / t.total},
          {"bytes per particle", (peak_memory() - small_bed) / spheres},
          {"kinetic energy", bed.energy().kinetic},
          {"spin energy", bed.energy().rotational},
          {"pairs", pairs},
          {"largest overlap", bed.max_overlap()}};
}

void measure(const Request& r) {
  const double small_bed = memory_of_small_bed(r);
  bench::Case c = bench::make_case(r);
  dem::Bed bed(c.laws, options_of(r));
  const int tool = bench::fill(bed, c);
  c.spheres = {};
  if (!r.peer_files.empty()) return bench::write_peer_files(r.peer_files, c, bed);
  if (tool >= 0 && r.idle_tool) bed.boundary(tool).active = false;
  bed.let_bonds_form();
  const Times t = run(bed, c, tool, r);
  auto result = report(bed, t, r, small_bed);
  result.update(phases_of(bed, c, tool, r));
  if (r.json) {
    std::printf("%s\n", result.dump().c_str());
    return;
  }
  for (const auto& [name, value] : result.items()) std::printf("%-22s %s\n", name.c_str(), value.dump().c_str());
}

}  // namespace

int main(int argc, char** argv) {
  sim::recycle_arrays();
  CLI::App app("Rate of the bed's step in one case");
  Request r;
  r.tiles = std::filesystem::path(argv[0]).parent_path().string();
  const auto name_of = [](auto map) { return CLI::CheckedTransformer(map, CLI::ignore_case).description(""); };
  app.add_option("--case", r.kind, "rest, plough, pour")
      ->transform(name_of(std::map<std::string, bench::Kind>{
          {"rest", bench::Kind::rest}, {"plough", bench::Kind::plough}, {"pour", bench::Kind::pour}}));
  app.add_option("--law", r.law,
                 "linear, hertz, rolling, cohesive, wet, hysteretic, luding, eepa, variable, jkr, bridge, bonded")
      ->transform(name_of(std::map<std::string, bench::LawName>{{"linear", bench::LawName::linear},
                                                                {"hertz", bench::LawName::hertz},
                                                                {"rolling", bench::LawName::rolling},
                                                                {"cohesive", bench::LawName::cohesive},
                                                                {"wet", bench::LawName::wet},
                                                                {"hysteretic", bench::LawName::hysteretic},
                                                                {"luding", bench::LawName::luding},
                                                                {"eepa", bench::LawName::eepa},
                                                                {"variable", bench::LawName::variable},
                                                                {"jkr", bench::LawName::jkr},
                                                                {"bridge", bench::LawName::bridge},
                                                                {"bonded", bench::LawName::bonded}}));
  app.add_option("--spheres", r.spheres, "about; whole blocks of 13,000");
  app.add_option("--triangles", r.triangles, "of the plough's tool: 740, 20000, or 0 for none");
  app.add_option("--threads", r.threads);
  app.add_option("--steps", r.steps)->check(CLI::Range(2L, 1000000000L));
  app.add_option("--energy-every", r.energy_every, "steps between readings of the energy balance");
  app.add_option("--skin", r.skin, "m; 0: the engine's own");
  app.add_option("--simd", r.simd);
  app.add_option("--precision", r.precision, "double, mixed")
      ->transform(name_of(std::map<std::string, dem::Precision>{{"double", dem::Precision::doubles},
                                                                {"mixed", dem::Precision::mixed}}));
  app.add_option("--tiles", r.tiles, "folder of the settled blocks; made there when missing");
  app.add_option("--peer-files", r.peer_files, "write the case for LAMMPS and LIGGGHTS into this folder; no timing");
  app.add_flag("--idle-tool", r.idle_tool, "the plough's tool touches nothing: its cost is the difference");
  app.add_flag("--json", r.json, "one line of JSON");
  CLI11_PARSE(app, argc, argv);
  try {
    measure(r);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bed_step: %s\n", e.what());
    return 2;
  }
  return 0;
}
