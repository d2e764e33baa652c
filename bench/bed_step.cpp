/// Rate of the bed's step: wet-particle law with rolling resistance and energy book, as in the 1S-300 scenarios.
///
/// The bed is the rest-pitch lattice, pitch 2r - rest overlap, between a floor and four walls, every sphere with a
/// random velocity of a few mm/s so that springs, dashpots and friction all have work. A lattice and not a settled bed,
/// since LAMMPS can be given the same arrangement of contacts without exchanging files (scripts/bench --lammps).
///
///     bed_step [--spheres N] [--threads 1,2] [--steps S] [--simd auto|avx512|avx2|portable] [--jitter SHARE]
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/bed/placement.hpp"

namespace {

using namespace subsoil::dem;

constexpr double kStep = 2e-5;     // s; the stable step of this bed is about twice as long
constexpr double kRadius = 0.01;   // m
constexpr double kDensity = 1800;  // kg/m3
constexpr long kEnergyEvery = 50;  // steps between readings of the energy book: one sample a millisecond

struct Request {
  double spheres = 130e3;
  std::vector<int> threads{1, 2};
  long steps = 400;
  std::string simd = "auto";
  double jitter = 0;  ///< share of the radius
};

Request parse(int argc, char** argv) {
  Request r;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i], value = argv[i + 1];
    if (key == "--spheres") {
      r.spheres = std::stod(value);
    } else if (key == "--steps") {
      r.steps = std::stol(value);
    } else if (key == "--simd") {
      r.simd = value;
    } else if (key == "--jitter") {
      r.jitter = std::stod(value);
    } else if (key == "--threads") {
      r.threads.clear();
      std::istringstream list(value);
      for (std::string one; std::getline(list, one, ',');) r.threads.push_back(std::stoi(one));
    } else {
      throw std::invalid_argument(key + ": unknown; see the head of bench/bed_step.cpp");
    }
  }
  if (argc % 2 == 0) throw std::invalid_argument(std::string(argv[argc - 1]) + ": a value is missing");
  return r;
}

/// Table 3 of the source in N/m, values of the pair: soil-soil and soil-steel.
LawTable laws() {
  Wet soil;
  soil.K_X = 10000, soil.C_X = 20, soil.K_Y = 8000, soil.C_Y = 20, soil.K_B = 7000, soil.dc = soil.dB = 2e-3;
  soil.friction.mu = 0.5, soil.friction.mu_r = 0.3;
  Wet steel = soil;
  steel.K_X = 16000, steel.K_Y = 12000, steel.K_B = 3000;
  LawTable table;
  table.materials = 2;
  table.index = {0, 1, 1, -1};
  table.laws = {soil.resolved(), steel.resolved()};
  return table;
}

/// Rows along x, y, z of a bed shaped like the source's bin, 99 x 19 x 69 for 130,000 spheres.
std::array<int, 3> rows(double spheres) {
  const double scale = std::cbrt(spheres / (99.0 * 19 * 69));
  const auto n = [&](double full) { return std::max(3, static_cast<int>(std::lround(full * scale))); };
  return {n(99), n(19), n(69)};
}

Bed make_bed(const Request& request, int threads, const std::array<int, 3>& n) {
  BedOptions options;
  options.threads = threads;
  options.simd = request.simd;
  Bed bed(laws(), options);
  const double overlap = 2e-3, pitch = 2 * kRadius - overlap;
  std::mt19937 random(1);
  const auto spread = [&](double half) {
    return half * (2.0 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 1);
  };
  const auto scatter = [&](double half) {
    const double x = spread(half), y = spread(half), z = spread(half);
    return Vec3{x, y, z};
  };
  std::vector<SphereSpec> spheres;
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k)
        spheres.push_back({.position = Vec3{pitch * i, pitch * j, pitch * k} + scatter(request.jitter * kRadius),
                           .velocity = scatter(5e-3),
                           .spin = {},
                           .radius = kRadius,
                           .density = kDensity,
                           .material = 0});
  bed.add(spheres);
  const double at = -(kRadius - overlap);
  const auto wall = [&](const Vec3& point, const Vec3& normal) {
    Boundary b;
    b.name = "wall";
    b.shape = Plane(point, normal);
    b.material = 1;
    bed.add(b);
  };
  wall({0, at, 0}, {0, 1, 0});
  wall({at, 0, 0}, {1, 0, 0}), wall({pitch * (n[0] - 1) - at, 0, 0}, {-1, 0, 0});
  wall({0, 0, at}, {0, 0, 1}), wall({0, 0, pitch * (n[2] - 1) - at}, {0, 0, -1});
  return bed;
}

void measure(const Request& request, int threads) {
  const auto n = rows(request.spheres);
  Bed bed = make_bed(request, threads, n);
  Bed::Request sample;
  sample.energy = true;
  bed.step(kStep, sample);
  const double start = bed.energy().total() - bed.energy().boundary_work;
  for (int i = 0; i < 20; ++i) bed.step(kStep);  // lists built, caches and pages warm

  const long rebuilds = bed.rebuilds();
  const auto from = std::chrono::steady_clock::now();
  for (long i = 1; i <= request.steps; ++i) bed.step(kStep, i % kEnergyEvery == 0 ? sample : Bed::Request{});
  const double wall_time = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();

  bed.step(kStep, sample);
  const BedEnergy& e = bed.energy();
  const double moved = e.lost.damping + e.lost.sliding + e.lost.rolling;
  const double spheres = static_cast<double>(bed.spheres().size()), pairs = static_cast<double>(bed.touching_pairs());
  const double steps = static_cast<double>(request.steps);
  std::printf(
      "%s  %.0f spheres (%d x %d x %d)  %d threads  %.2f M particle-steps/s  %.1f M pairs/s  "
      "%.2f pairs per sphere, %ld rebuilds in %ld steps, energy closes to %.1e of %.3g J lost\n",
      bed.kernel_name(), spheres, n[0], n[1], n[2], threads, spheres * steps / wall_time * 1e-6,
      pairs * steps / wall_time * 1e-6, pairs / spheres, bed.rebuilds() - rebuilds, request.steps,
      std::abs(e.total() - e.boundary_work - start) / moved, moved);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Request request = parse(argc, argv);
    for (const int threads : request.threads) measure(request, threads);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bed_step: %s\n", e.what());
    return 2;
  }
  return 0;
}
