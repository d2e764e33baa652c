#include "bench/bed_case.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/packing/carve.hpp"
#include "libdem/packing/placement.hpp"

namespace subsoil::bench {
namespace {

using dem::Vec3;

constexpr double kFriction = 0.5, kRollingFriction = 0.3;

dem::Linear linear() {
  dem::Linear l;
  l.k_n = kStiffness, l.restitution = 0.5, l.friction.mu = kFriction;
  return l;
}

dem::Linear rolling() {
  dem::Linear l = linear();
  l.friction.mu_r = kRollingFriction;
  return l;
}

/// As stiff as the linear law at an overlap of 0.01 mm, which the bed's weight makes: it rests with the same overlaps.
dem::HertzMindlin hertz() {
  constexpr double overlap = 1e-5, r_eff = kRadius / 2, poisson = 0.25;
  dem::HertzMindlin h;
  h.E_eff = kStiffness / (4.0 / 3.0 * std::sqrt(r_eff * overlap));
  const double young = h.E_eff * 2 * (1 - poisson * poisson);
  h.take_materials(young, poisson, young, poisson);
  h.restitution = 0.5, h.friction.mu = kFriction;
  return h;
}

/// Table 3 of the source of the 1S-300 scenarios, in N/m.
dem::Wet wet() {
  dem::Wet w;
  w.K_X = 10000, w.C_X = 20, w.K_Y = 8000, w.C_Y = 20, w.K_B = 7000, w.dc = w.dB = 2e-3;
  w.friction.mu = kFriction, w.friction.mu_r = kRollingFriction;
  return w;
}

/// Laws with memory that load as the linear one, or as Hertz's.
dem::Hysteretic hysteretic() {
  dem::Hysteretic h;
  h.K1 = kStiffness, h.restitution = 0.5, h.friction.mu = kFriction;
  return h;
}
dem::Luding luding() {
  dem::Luding l;
  l.k1 = kStiffness, l.k2 = 4 * kStiffness, l.k_c = 0.2 * kStiffness, l.phi_f = 0.05, l.restitution = 0.5;
  l.friction.mu = kFriction;
  return l;
}
dem::Eepa eepa() {
  dem::Eepa e;
  e.E_eff = hertz().E_eff, e.plasticity = 0.6, e.w = 0.1, e.restitution = 0.5, e.friction.mu = kFriction;
  return e;
}
dem::VariableRestitution variable() {
  dem::VariableRestitution v;
  v.E_eff = hertz().E_eff, v.map.S_y = 1e-3 * v.E_eff, v.map.density = kDensity, v.friction.mu = kFriction;
  return v;
}

/// The wet law with the linear law's repulsion and damping from overlap 0 on and a film of 10 um: it rests where that
/// one does.
dem::Wet cohesive() {
  const dem::Linear dry = linear();
  const double m_eff = 0.5 * kDensity * dem::sphere_volume(kRadius);
  const dem::StiffnessBound of_dry = dry.bound({.m_eff = m_eff, .r_eff = kRadius / 2, .r_min = kRadius, .speed = 0});
  dem::Wet w = wet();
  w.K_X = of_dry.k_n, w.C_X = of_dry.c_n, w.K_Y = of_dry.k_t, w.C_Y = of_dry.c_t;
  w.dc = w.dB = 1e-5, w.D = -w.dc;
  return w;
}

/// As hertz(), with a pull-off of a hundredth of a sphere's weight: it rests with the same overlaps.
double weak_adhesion() {
  return 0.01 * kDensity * dem::sphere_volume(kRadius) * 9.81 / (2 * std::numbers::pi * kRadius);
}
dem::Jkr jkr() {
  const dem::HertzMindlin dry = hertz();
  dem::Jkr j;
  j.E_eff = dry.E_eff, j.G_eff = dry.G_eff, j.restitution = dry.restitution, j.work = weak_adhesion();
  j.friction = dry.friction;
  return j;
}
dem::HertzMindlin bridge() {
  dem::HertzMindlin h = hertz();
  h.cohesion.kind = dem::Cohesion::Kind::liquid_bridge;
  h.cohesion.tension = weak_adhesion(), h.cohesion.angle = 0, h.cohesion.volume = 1e-12;
  return h;
}

/// As linear(), cemented with a tenth of the contact's stiffness, E pi r/2, and so strong that it holds 50 um of
/// stretch: the law reaches as far, and an endless strength would pair all spheres.
dem::Linear bonded() {
  dem::Linear l = linear();
  l.bond.kind = dem::Bond::Kind::parallel;
  l.bond.modulus = 0.1 * kStiffness / (0.5 * std::numbers::pi * kRadius);
  l.bond.tensile = l.bond.shear = l.bond.modulus / (2 * kRadius) * 5e-5;
  return l;
}

/// Blocks along x and z, about twice as many along.
std::array<int, 2> blocks(double spheres) {
  const double all = std::max(1.0, std::round(spheres / static_cast<double>(kTileSpheres)));
  const double across = std::max(1.0, std::round(std::sqrt(all / 2)));
  return {static_cast<int>(std::lround(all / across)), static_cast<int>(across)};
}

/// Grid points of one face of a box, and its triangles, seen from outside.
void add_face(std::vector<Vec3>& vertices, std::vector<dem::Triangle>& triangles, const Vec3& corner, const Vec3& u,
              const Vec3& v, int nu, int nv) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (int i = 0; i <= nu; ++i)
    for (int j = 0; j <= nv; ++j) vertices.push_back(corner + u * (double(i) / nu) + v * (double(j) / nv));
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * (nv + 1) + j); };
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
}

/// 4 (ab + bc + ca) triangles with a, b, c divisions along x, y, z: 740 of 5, 10, 9 and 20,000 of 25, 50, 50.
dem::TriangleMesh divided_box(const Vec3& size, int triangles) {
  const bool fine = triangles > 5000;
  const int a = fine ? 25 : 5, b = fine ? 50 : 10, c = fine ? 50 : 9;
  const Vec3 x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z}, low = -0.5 * size, high = 0.5 * size;
  std::vector<Vec3> vertices;
  std::vector<dem::Triangle> sides;
  add_face(vertices, sides, low, y, x, b, a), add_face(vertices, sides, high, -x, -y, a, b);
  add_face(vertices, sides, low, z, y, c, b), add_face(vertices, sides, high, -y, -z, b, c);
  add_face(vertices, sides, low, x, z, a, c), add_face(vertices, sides, high, -z, -x, c, a);
  std::vector<std::array<Vec3, 3>> soup;
  for (const dem::Triangle& t : sides) soup.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
  return dem::welded_mesh(soup);
}

}  // namespace

dem::GivenLaw law_of(LawName name) {
  switch (name) {
    case LawName::linear:
      return linear();
    case LawName::hertz:
      return hertz();
    case LawName::rolling:
      return rolling();
    case LawName::cohesive:
      return cohesive();
    case LawName::wet:
      return wet();
    case LawName::hysteretic:
      return hysteretic();
    case LawName::luding:
      return luding();
    case LawName::eepa:
      return eepa();
    case LawName::variable:
      return variable();
    case LawName::jkr:
      return jkr();
    case LawName::bridge:
      return bridge();
    case LawName::bonded:
      return bonded();
  }
  return linear();
}

namespace {

/// The block at rest under the request's law: laws that load alike share one. A block that settled under another law
/// moves for thousands of steps, and its contacts slip.
Tile resting_tile(const CaseRequest& request, double side) {
  switch (request.law) {
    case LawName::wet:
      return settled_tile(request.tiles + "/tile-wet.csv", side, wet());
    case LawName::hertz:
    case LawName::jkr:
    case LawName::bridge:
    case LawName::eepa:
    case LawName::variable:
      return settled_tile(request.tiles + "/tile-hertz.csv", side, hertz());
    default:
      return settled_tile(request.tiles + "/tile-linear.csv", side, linear());
  }
}

}  // namespace

Case make_case(const CaseRequest& request) {
  Case c;
  c.laws = with_mirror(law_of(request.law));
  // A wet sphere rests with 2 mm of overlap: the same packing of spheres a tenth smaller.
  const bool is_wet = request.law == LawName::wet;
  const double side = is_wet ? 0.468 : 0.52;
  const auto [along, across] = blocks(request.spheres);
  c.length = side * along, c.width = side * across;

  dem::RandomNumbers random(1);
  if (request.kind == Kind::pour) {
    dem::LoosePlacer placer({{0, 0, 0}, {c.length, 1, c.width}}, dem::EqualRadius{kRadius}, dem::ShareOf::number, 1,
                            {.density = kDensity, .material = 0});
    c.spheres = placer.place(kTileSpheres * static_cast<std::size_t>(along * across), 0);
    for (dem::SphereSpec& s : c.spheres) s.velocity = 0.3 * random.in_unit_ball() - Vec3{0, 2, 0};
  } else {
    const Tile tile = resting_tile(request, side);
    for (const Vec3& x : tile.mirrored(along, across))
      c.spheres.push_back({.position = x,
                           .velocity = 5e-3 * random.in_unit_ball(),
                           .angular_velocity = {},
                           .radius = kRadius,
                           .density = kDensity,
                           .material = 0});
  }
  c.has_tool = request.kind == Kind::plough && request.triangles > 0;
  if (c.has_tool) {
    c.tool.centre = {0.25 * c.length, 0.21, 0.5 * c.width};
    c.tool.mesh = divided_box(c.tool.size, request.triangles);
  }
  return c;
}

int fill(dem::Bed& bed, const Case& c) {
  bed.add(c.spheres);
  const auto wall = [&](const Vec3& point, const Vec3& normal) {
    dem::Boundary b;
    b.name = "wall", b.shape = dem::Plane(point, normal), b.material = 1;
    bed.add(std::move(b));
  };
  wall({}, {0, 1, 0});
  wall({}, {1, 0, 0}), wall({c.length, 0, 0}, {-1, 0, 0});
  wall({}, {0, 0, 1}), wall({0, 0, c.width}, {0, 0, -1});
  if (!c.has_tool) return -1;
  dem::Boundary b;
  b.name = "tool", b.shape = dem::MeshSurface(c.tool.mesh), b.material = 1;
  b.pose.position = c.tool.centre, b.velocity = c.tool.velocity;
  const int tool = bed.add(std::move(b));
  dem::carve(bed, std::array{tool});
  return tool;
}

}  // namespace subsoil::bench
