#include "bench/settled_tile.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "bench/writable_file.hpp"
#include "libdem/packing/settle.hpp"

namespace subsoil::bench {
namespace {

using dem::Vec3;

/// Ten times softer spheres fall and pack with a step three times as long; the last stage takes the law as it is.
constexpr double kSofter = 0.1;
constexpr double kSoftStep = 1e-4, kStep = 4e-5;  // s

dem::LawTable smooth(dem::GivenLaw law) {
  std::visit([](auto& l) { l.friction.mu = l.friction.mu_r = 0; }, law);
  return with_mirror(law);
}

/// Takes the last motion out by dropping all velocities again and again. What is left is the creep of a frictionless
/// packing, some hundredths of its weight, which friction holds.
void quench(dem::Bed& bed) {
  for (int round = 0; round < 100; ++round) {
    bed.freeze();
    for (int i = 0; i < 50; ++i) bed.step(kStep);
  }
}

dem::GivenLaw softer(dem::GivenLaw law) {
  if (auto* linear = std::get_if<dem::Linear>(&law)) linear->k_n *= kSofter;
  if (auto* hertz = std::get_if<dem::HertzMindlin>(&law)) hertz->E_eff *= kSofter, hertz->G_eff *= kSofter;
  return law;
}

std::vector<Vec3> settle(double side, const dem::GivenLaw& law) {
  dem::Bed bed(smooth(softer(law)), {});
  for (const auto& [point, normal] : {std::pair<Vec3, Vec3>{{}, {0, 1, 0}},
                                      {{}, {1, 0, 0}},
                                      {{}, {0, 0, 1}},
                                      {{side, 0, 0}, {-1, 0, 0}},
                                      {{0, 0, side}, {0, 0, -1}}}) {
    dem::Boundary wall;
    wall.name = "wall", wall.shape = dem::Plane(point, normal), wall.material = 1;
    bed.add(std::move(wall));
  }
  dem::RandomFill fill;
  fill.region = {{0, 0, 0}, {side, 1, side}};
  fill.radius = dem::EqualRadius{kRadius};
  fill.of = {.density = kDensity, .material = 0};
  fill.count = kTileSpheres;
  dem::SettlePlan plan;
  plan.step = kSoftStep;
  plan.until_speed = 0.02;
  plan.staged = std::holds_alternative<dem::Wet>(law);
  dem::fill_at_random(bed, smooth(softer(law)), fill, plan);
  bed.set_laws(smooth(law));
  quench(bed);
  std::vector<Vec3> centres(bed.spheres().size());
  for (const dem::Sphere& s : bed.spheres()) centres.at(s.id) = s.x;
  return centres;
}

/// Under a name of its own first: two programs may look for the file at once.
void write(const std::string& file, const std::vector<Vec3>& centres) {
  const std::string draft = file + "." + std::to_string(getpid());
  std::FILE* out = std::fopen(draft.c_str(), "w");
  if (out == nullptr) throw std::runtime_error(draft + ": cannot be written");
  std::fprintf(out, "x [m],y [m],z [m],radius [m]\n");
  for (const Vec3& c : centres) std::fprintf(out, "%.17g,%.17g,%.17g,%g\n", c.x, c.y, c.z, kRadius);
  if (std::fclose(out) != 0) throw std::runtime_error(draft + ": the disk is full");
  std::filesystem::rename(draft, file);
}

dem::Law ready(const dem::GivenLaw& law) {
  return std::visit([](const auto& given) { return dem::Law(given); }, law);
}

}  // namespace

dem::LawTable with_mirror(const dem::GivenLaw& law) {
  dem::GivenLaw mirror = law;
  if (auto* linear = std::get_if<dem::Linear>(&mirror)) {
    linear->k_n *= 2;
    linear->bond = {};
  } else if (auto* hertz = std::get_if<dem::HertzMindlin>(&mirror)) {
    hertz->E_eff *= 2, hertz->G_eff *= 2;
  } else if (auto* jkr = std::get_if<dem::Jkr>(&mirror)) {
    jkr->E_eff *= 2, jkr->G_eff *= 2, jkr->work /= 2;
  } else if (auto* wet = std::get_if<dem::Wet>(&mirror)) {
    wet->K_X *= 2, wet->K_Y *= 2, wet->K_B *= 2;
    wet->dc /= 2, wet->dB /= 2, wet->D /= 2;
  } else if (auto* hysteretic = std::get_if<dem::Hysteretic>(&mirror)) {
    hysteretic->K1 *= 2;
  } else if (auto* luding = std::get_if<dem::Luding>(&mirror)) {
    luding->k1 *= 2, luding->k2 *= 2, luding->k_c *= 2, luding->phi_f /= 4;
  } else if (auto* eepa = std::get_if<dem::Eepa>(&mirror)) {
    eepa->E_eff *= 2;
  } else if (auto* variable = std::get_if<dem::VariableRestitution>(&mirror)) {
    variable->map.lambda_c = variable->map.critical_lambda({.E_eff = variable->E_eff});
    variable->E_eff *= 2, variable->map.density *= 4;  // half the speed, the same Ce
  } else {
    throw std::invalid_argument("bench: no mirror is known for this law");
  }
  return {.materials = 2, .index = {0, 1, 1, -1}, .laws = {ready(law), ready(mirror)}};
}

Tile settled_tile(const std::string& file, double side, const dem::GivenLaw& law) {
  if (!std::filesystem::exists(file)) {
    require_writable(file);
    std::fprintf(stderr, "settling %zu spheres once, into %s\n", kTileSpheres, file.c_str());
    write(file, settle(side, law));
  }
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  Tile tile{side, {}};
  while (std::getline(in, line)) {
    Vec3 c;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &c.x, &c.y, &c.z) != 3)
      throw std::runtime_error(file + ": '" + line + "' is not x,y,z; delete the file");
    tile.centres.push_back(c);
  }
  if (tile.centres.size() != kTileSpheres)
    throw std::runtime_error(file + ": not the " + std::to_string(kTileSpheres) + " spheres expected; delete the file");
  return tile;
}

std::vector<Vec3> Tile::mirrored(int along, int across) const {
  const auto at = [&](double x, int block) { return side * block + (block % 2 == 0 ? x : side - x); };
  std::vector<Vec3> bed;
  bed.reserve(centres.size() * static_cast<std::size_t>(along * across));
  for (int i = 0; i < along; ++i)
    for (int k = 0; k < across; ++k)
      for (const Vec3& c : centres) bed.push_back({at(c.x, i), c.y, at(c.z, k)});
  return bed;
}

}  // namespace subsoil::bench
