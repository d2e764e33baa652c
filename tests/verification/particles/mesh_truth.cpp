#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <string>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/dem_beds.hpp"

/// Faults that users of other programs report of spheres on meshes, each as a case with a closed form
/// (docs/verification/mesh-contacts.md). Every figure is relative to the largest of its kind in the case.
///
/// Tolerance 1e-12 throughout. A coordinate of 50 mm rounds at 7e-18 m; the overlap is a difference of such, and of
/// 1e-4 m it is known to 1e-13. Paths sum some 60,000 such roundings, which go either way and grow as their root.
namespace subsoil::dem::test::mesh_truth {
namespace {

constexpr double kBound = 1e-12;

/// The worst relative error of a case; says it and bounds it.
class Error {
 public:
  explicit Error(std::string what) : what_(std::move(what)) {}
  void take(double ours, double want, double scale) { take(std::abs(ours - want) / scale); }
  void take(const Vec3& ours, const Vec3& want, double scale) { take(norm(ours - want) / scale); }
  double worst() const { return worst_; }
  int taken() const { return taken_; }
  ~Error() {
    std::printf("    %-66s %.1e\n", what_.c_str(), worst_);
    EXPECT_LT(worst_, kBound) << what_;
    EXPECT_GT(taken_, 0) << what_;
  }
  Error(const Error&) = delete;
  Error& operator=(const Error&) = delete;

 private:
  void take(double error) { worst_ = error <= worst_ ? worst_ : error, ++taken_; }  // NaN is kept
  std::string what_;
  double worst_ = 0;
  int taken_ = 0;
};

TEST(MeshTruth, AnErrorIsSeen) {
  EXPECT_NONFATAL_FAILURE(Error("a rounding too many, as it must fail").take(1 + 2e-12, 1.0, 1.0), "too many");
  EXPECT_NONFATAL_FAILURE(Error("no number, as it must fail").take(std::nan(""), 1.0, 1.0), "no number");
  EXPECT_NONFATAL_FAILURE(Error("nothing taken, as it must fail"), "nothing taken");
}

/// Rectangle corner, u, v in n x n cells of two triangles each, with every node at a cell's corner.
void add_panel(std::vector<std::array<Vec3, 3>>& soup, const Vec3& corner, const Vec3& u, const Vec3& v, int n) {
  const auto at = [&](int i, int j) { return corner + (i * (1.0 / n)) * u + (j * (1.0 / n)) * v; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      soup.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
}

/// A box from the origin with its lid as a mesh of its own, so that both are open and the inside acts; 12 n^2
/// triangles.
MeshSurface hollow_box(double size, int n) {
  std::vector<std::array<Vec3, 3>> open, lid;
  const Vec3 x{size, 0, 0}, y{0, size, 0}, z{0, 0, size};
  add_panel(open, {}, z, x, n);
  add_panel(open, {}, x, y, n), add_panel(open, z, x, y, n);
  add_panel(open, {}, y, z, n), add_panel(open, x, y, z, n);
  add_panel(lid, y, z, x, n);
  const std::vector<TriangleMesh> both{welded_mesh(open), welded_mesh(lid)};
  return MeshSurface(both);
}

void add_surface(Bed& bed, Shape shape) {
  Boundary b;
  b.shape = std::move(shape);
  bed.add(std::move(b));
}

/// The engine's steps of a sphere that falls on a linear contact, in closed form. From rest the positions are those of
/// the parabola. In contact with z = y - (r - m g/k) and the velocity of half a step before,
///     (v, z)' = A (v, z),  A = [[1 - c dt/m, -k dt/m], [dt (1 - c dt/m), 1 - k dt^2/m]],
/// whose eigenvalues are q e^{+-i a}, q^2 = det A = 1 - c dt/m, 4 q^2 sin^2 a = 4 det A - (tr A)^2, hence
///     A^n = q^{n-1} (sin(n a) A - q sin((n-1) a) I)/sin a.
class Drop {
 public:
  double mass, radius, k, c, g, dt;

  /// First step whose position touches, from a height of rest.
  long touch(double height) const {
    long n = static_cast<long>(std::sqrt(2 * (height - radius) / g) / dt);
    while (fallen(height, n) < radius) --n;
    while (fallen(height, n) >= radius) ++n;
    return n;
  }
  double fallen(double height, long n) const { return height - 0.5 * g * std::pow(static_cast<double>(n) * dt, 2); }
  /// Speed when it has left again: of the half step after the last one in contact.
  double rebound(double height) const {
    const long first = touch(height);
    const double v = -g * dt * (static_cast<double>(first) - 0.5), rest = radius - mass * g / k;
    long n = 1;
    while (after(v, fallen(height, first) - rest, n)[1] + rest < radius) ++n;
    return after(v, fallen(height, first) - rest, n)[0];
  }

 private:
  std::array<double, 2> after(double v, double z, long steps) const {
    const double damped = 1 - c * dt / mass, kick = k * dt / mass, q = std::sqrt(damped),
                 sum = c * dt / mass + kick * dt, a = std::asin(std::sqrt(4 * kick * dt - sum * sum) / (2 * q)),
                 n = static_cast<double>(steps);
    const double of_a = std::pow(q, n - 1) * std::sin(n * a) / std::sin(a),
                 of_one = -std::pow(q, n) * std::sin((n - 1) * a) / std::sin(a);
    return {of_a * (damped * v - kick * z) + of_one * v, of_a * (dt * damped * v + (1 - kick * dt) * z) + of_one * z};
  }
};

/// DEM-Engine, issue 73: the radius, density, drop, step and box of the report. Its sphere falls on a vertex where six
/// triangles meet.
struct Report {
  double radius = 1e-3, density = 2600, height = 20e-3, restitution = 0.5, dt = 1e-6, size = 50e-3;
  Linear law = grains(1000, 0.5, 0.35, 0);

  double mass() const { return density * 4.0 / 3 * pi * radius * radius * radius; }
  double damping() const {
    const double loss = -std::log(restitution);
    return 2 * loss / std::sqrt(pi * pi + loss * loss) * std::sqrt(mass() * law.k_n);
  }
  Bed box(bool mesh, const Vec3& start) const {
    Bed bed(table(law), quiet({0, -9.81, 0}));
    bed.add(std::vector<SphereSpec>{
        {.position = start, .velocity = {}, .angular_velocity = {}, .radius = radius, .density = density}});
    if (mesh)
      add_surface(bed, hollow_box(size, 10));
    else
      add_bin(bed, size, size), add_plane(bed, {0, size, 0}, {0, -1, 0});
    return bed;
  }
  double rebound(bool mesh, double x, double z) const {
    Bed bed = box(mesh, {x, height, z});
    const double fall = std::sqrt(2 * (height - radius) / 9.81), contact = pi * std::sqrt(mass() / law.k_n);
    const long all = static_cast<long>((fall + 1.5 * contact) / dt);
    double speed = 0;
    for (long n = 0; n < all; ++n) {
      bed.step(dt);
      const double v = bed.spheres()[0].v.y;
      if (speed == 0 && v > 0 && bed.spheres()[0].x.y >= radius) speed = v;
    }
    EXPECT_LT(std::hypot(bed.spheres()[0].x.x - x, bed.spheres()[0].x.z - z), 1e-15) << "it goes straight up";
    return speed;
  }
};

TEST(MeshTruth, ReboundOnAMeshIsThatOnTheAnalyticBox) {
  const Report r;
  const Drop drop{r.mass(), r.radius, r.law.k_n, r.damping(), 9.81, r.dt};
  const double want = drop.rebound(r.height), impact = std::sqrt(2 * 9.81 * (r.height - r.radius));
  // What the steps make of e: damping takes the rate of half a step before, 0.2 us of some 300.
  EXPECT_NEAR(want / impact, r.restitution, 5e-3);
  Error plane("rebound on the analytic box");
  plane.take(r.rebound(false, 10e-3, 10e-3), want, want);
  Error vertex("rebound on the mesh, on a vertex of six triangles");
  vertex.take(r.rebound(true, 10e-3, 10e-3), want, want);
  Error edge("rebound on the mesh, on an edge");
  edge.take(r.rebound(true, 12.5e-3, 10e-3), want, want);
  Error face("rebound on the mesh, on a face");
  face.take(r.rebound(true, 13.1e-3, 11.7e-3), want, want);
}

/// The forces and torques on one fixed sphere at t = 0, and the wrench on the surface about the origin.
struct Felt {
  Vec3 force, torque;
  Wrench surface;
};
Felt felt(const Law& law, const Shape& shape, const Vec3& centre, double radius) {
  Bed bed(table(law), quiet());
  bed.add(std::vector<SphereSpec>{
      {.position = centre, .velocity = {}, .angular_velocity = {}, .radius = radius, .density = 2000}});
  add_surface(bed, shape);
  const Snapshot now = observe(bed, 1e-9);
  return {now.force[0], now.torque[0], bed.boundary(0).wrench};
}

/// lethe, issue 2108: a hopper's wall, y = -x above, meets its outlet pipe, x = 0 below, in a convex edge along z. As
/// an infinite plane the hopper's wall would reach into the pipe.
TEST(MeshTruth, AWallEndsAtItsEdge) {
  const Linear law = grains(1e4, 1, 0, 0);
  const double radius = 5e-3;
  std::vector<std::array<Vec3, 3>> soup;
  add_panel(soup, {0, 0, -0.02}, {-0.03, 0.03, 0}, {0, 0, 0.04}, 4);
  add_panel(soup, {0, -0.03, -0.02}, {0, 0.03, 0}, {0, 0, 0.04}, 4);
  const MeshSurface hopper(welded_mesh(soup));
  Error force("force of a hopper's wall and pipe near their edge");
  int cut = 0, free = 0;
  for (int i = 1; i <= 16; ++i)
    for (int j = -12; j <= 12; ++j) {
      const Vec3 c{i * 0.41e-3, j * 0.37e-3, 1e-3};
      // In closed form: below the edge the pipe, beside it the edge, beyond its other normal the wall.
      const bool wall = c.y >= c.x;
      const Vec3 away = wall ? (0.5 * (c.x + c.y)) * Vec3{1, 1, 0} : Vec3{c.x, std::max(0.0, c.y), 0};
      const double distance = norm(away);
      if (distance < 0.5 * radius) continue;
      const double overlap = std::max(0.0, radius - distance);
      const Vec3 want = (law.k_n * overlap / distance) * away;
      force.take(felt(law, hopper, c, radius).force, want, law.k_n * radius);
      if (!wall && overlap == 0 && (c.x + c.y) / std::sqrt(2.0) < radius) ++cut;
      free += overlap == 0;
    }
  EXPECT_GT(cut, 5) << "where the infinite plane would act and nothing does";
  EXPECT_GT(free, cut);
}

/// A fan of n triangles around a vertex at the origin in the plane y = 0, its corners at uneven angles.
std::vector<std::array<Vec3, 3>> fan(int n, double size, Dice& dice) {
  std::vector<std::array<Vec3, 3>> soup;
  std::vector<Vec3> rim;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * pi * (i + dice.between(0, 0.3)) / n;
    rim.push_back({size * std::cos(angle), 0, size * std::sin(angle)});
  }
  for (int i = 0; i < n; ++i)
    soup.push_back({Vec3{}, rim[static_cast<std::size_t>((i + 1) % n)], rim[static_cast<std::size_t>(i)]});
  return soup;
}

/// PhasicFlow, issue 242: on an edge between coplanar triangles the force depends on how the wall is written. Here
/// triangles in any order, corners from any of theirs, turned either way, the whole in any attitude.
TEST(MeshTruth, CoplanarTrianglesAreOneWall) {
  const Linear law = grains(1e5, 1, 0, 0);
  const double radius = 5e-3, overlap = 1e-3;
  Dice dice(242);
  Error force("force on a vertex or an edge of 3 to 12 coplanar triangles"), moment("moment of it on the wall");
  for (int trial = 0; trial < 200; ++trial) {
    auto soup = fan(3 + trial % 10, 0.03, dice);
    // At the vertex, in the middle of an edge, or a nanometre beside it.
    const Vec3 foot = trial % 3 == 0 ? Vec3{} : 0.5 * soup[0][1] + (trial % 3 == 1 ? Vec3{} : Vec3{1e-9, 0, 0});
    for (auto& t : soup) {
      std::rotate(t.begin(), t.begin() + static_cast<long>(dice.between(0, 3)), t.end());
      if (dice.between(0, 1) < 0.5) std::swap(t[0], t[1]);
    }
    for (std::size_t i = soup.size(); i > 1; --i)
      std::swap(soup[i - 1], soup[static_cast<std::size_t>(dice.between(0, static_cast<double>(i)))]);
    const Quaternion turn = Quaternion::from_rotation_vector(dice.ball(3));
    for (auto& t : soup)
      for (Vec3& corner : t) corner = turn.rotate(corner);
    const Vec3 n = turn.rotate({0, 1, 0}), p = turn.rotate(foot), want = law.k_n * overlap * n;
    const Felt now = felt(law, MeshSurface(welded_mesh(soup)), p + (radius - overlap) * n, radius);
    force.take(now.force, want, law.k_n * overlap);
    moment.take(now.surface.moment, cross(p, -want), law.k_n * overlap * 0.03);
  }
}

/// A sphere so heavy (1e18 times its density) that it keeps its velocity, dragged within Coulomb's limit over many
/// triangles; its normal force k overlap. Spring and dashpot are numbers of the law and know no mass.
struct Dragged {
  Linear law = grains(1e5, 1, 100, 0);
  double radius = 5e-3, overlap = 1e-3, dt = 1e-5;
  Vec3 velocity{0.3, 0, 0.19}, start{-0.02, 4e-3, -0.0151};
  Dragged() { law.friction.c_t = 5; }

  /// Spring k_t v t and dashpot c_t v against the motion; on the sphere, without the normal force.
  Vec3 friction(double t) const { return -(law.k_n * law.stiffness_ratio * t + law.friction.c_t) * velocity; }
  Vec3 normal() const { return {0, law.k_n * overlap, 0}; }
  Bed bed() const {
    std::vector<std::array<Vec3, 3>> soup;
    add_panel(soup, {-0.04, 0, -0.04}, {0, 0, 0.08}, {0.08, 0, 0}, 16);
    Bed bed(table(law), quiet());
    bed.add(std::vector<SphereSpec>{
        {.position = start, .velocity = velocity, .angular_velocity = {}, .radius = radius, .density = 1e21}});
    add_surface(bed, MeshSurface(welded_mesh(soup)));
    return bed;
  }
};
constexpr int kDragSteps = 12000;  // 43 mm over some 17 triangles

/// lethe, pull request 1746: contacts with many triangles of one wall are doubled; its note names what stays open, that
/// the tangential displacement is not always passed from triangle to triangle.
TEST(MeshTruth, TheTangentialSpringGoesOnFromTriangleToTriangle) {
  const Dragged d;
  const double largest = norm(d.friction(kDragSteps * d.dt));
  ASSERT_LT(largest, d.law.friction.mu * norm(d.normal())) << "it sticks all the way";
  Bed bed = d.bed();
  Error force("friction of a sphere dragged over 17 triangles");
  for (int n = 0; n < kDragSteps; ++n) {
    const Snapshot now = observe(bed, d.dt);
    force.take(now.force[0], d.friction(n * d.dt) + d.normal(), largest);
    ASSERT_EQ(now.contacts[0], 1) << n;
  }
}

/// GeoTaichi, issue 16: where a contact is shared among triangles, its moment is reduced twice by the shares.
TEST(MeshTruth, MomentIsArmTimesForceWhicheverTrianglesAreMet) {
  const Dragged d;
  const double largest = norm(d.friction(kDragSteps * d.dt)), arm = d.radius - d.overlap;
  Bed bed = d.bed();
  Error torque("torque on the sphere, whichever triangles it meets"), moment("moment on the mesh");
  for (int n = 0; n < kDragSteps; ++n) {
    const Snapshot now = observe(bed, d.dt);
    const Vec3 friction = d.friction(n * d.dt), point = d.start + (n * d.dt) * d.velocity - Vec3{0, arm, 0};
    torque.take(now.torque[0], cross(Vec3{0, -arm, 0}, friction), largest * arm);
    moment.take(bed.boundary(0).wrench.moment, cross(point, -(friction + d.normal())), largest * 0.04);
  }
}

/// The inside of a tube about z, open at its ends, of n flat sides that touch the circle of the radius.
MeshSurface tube(double radius, double length, int n) {
  std::vector<std::array<Vec3, 3>> soup;
  const double corner = radius / std::cos(pi / n);
  const auto at = [&](int k, double z) {
    const double angle = 2 * pi * (k % n) / n;
    return Vec3{corner * std::cos(angle), corner * std::sin(angle), z};
  };
  for (int k = 0; k < n; ++k) {
    soup.push_back({at(k, 0), at(k + 1, 0), at(k + 1, length)});
    soup.push_back({at(k, 0), at(k + 1, length), at(k, length)});
  }
  return MeshSurface(welded_mesh(soup));
}

/// A round hollow surface has one contact with a sphere, and so has its mesh: of its facets, of which two have a
/// minimum beside each edge on r/(R - r) of all places, the nearest. Its distance is R - d cos(angle to the facet's
/// middle).
TEST(MeshTruth, AHollowRoundSurfaceIsOneContact) {
  const double radius = 0.2, d = 0.15;
  Error distance("distance to the nearest facet of a hollow round surface");
  for (const int n : {36, 144, 2304}) {
    const MeshSurface surface = tube(radius, 1, n);
    for (int k = 0; k < 1000; ++k) {
      const double angle = 2 * pi * (k + 0.5) / 1000, facet = 2 * pi / n;
      const double aside = angle - facet * (std::floor(angle / facet) + 0.5);
      const Vec3 c{d * std::cos(angle), d * std::sin(angle), 0.4321};
      std::vector<std::uint32_t> candidates;
      surface.candidates(c, 0.06, candidates);
      SurfaceContact found[8];
      ASSERT_EQ(surface.contacts(c, 0.06, candidates, found, 8), 1U) << n << " facets, place " << k;
      distance.take(found[0].distance, radius - d * std::cos(aside), radius);
    }
  }
}

/// A corner of two walls keeps both: sides of 12 facets bend by 30 degrees.
TEST(MeshTruth, ACornerKeepsBothItsWalls) {
  const MeshSurface surface = tube(0.2, 1, 12);
  std::vector<std::uint32_t> candidates;
  const Vec3 before_an_edge{0.15, 0, 0.4321};
  surface.candidates(before_an_edge, 0.08, candidates);
  SurfaceContact found[8];
  EXPECT_EQ(surface.contacts(before_an_edge, 0.08, candidates, found, 8), 2U);
}

/// The golfer's dilemma (Gualtieri et al., Am. J. Phys. 74, 497, 2006): a ball that rolls round in an upright tube does
/// not fall out but moves up and down by sqrt(2/7) of its angular velocity Omega about the axis, z = -A (1 -
/// cos(sqrt(2/7) Omega t)), A = 5 g/(2 Omega^2). Seams that bear twice make it fall, by twice its amplitude in 4 s.
void expect_that_a_ball_comes_up_again(const Shape& in, double radius) {
  const double r = 0.05, g = 9.81, speed = 2, omega = speed / (radius - r), rate = std::sqrt(2.0 / 7) * omega;
  Bed bed(table(grains(1e5, 0.5, 1, 0)), quiet({0, 0, -g}));
  const SphereSpec ball{{radius - r, 0, 0.7}, {0, speed, 0}, {0, 0, -speed / r}, r, 2500, 0};
  bed.add(std::span(&ball, 1));
  add_surface(bed, in);
  double deepest = 0, highest = -1;  // after the last but one of the returns
  const double dt = 1e-4, from = 3 * 2 * pi / rate, until = 4 * 2 * pi / rate;
  for (int n = 0; n * dt < until; ++n) {
    bed.step(dt);
    const double z = sphere(bed, 0).x.z - 0.7;
    deepest = std::min(deepest, z);
    if (n * dt > from + 0.5 * pi / rate) highest = std::max(highest, z);
  }
  // The ball presses 0.35 mm deep: its arm is shorter by 0.7 % of r, its circle wider by 0.2 %, and the spring of
  // friction turns with the contact and gives, which takes 1.5 % of its speed in that time.
  const double amplitude = 2.5 * g / (omega * omega);
  std::printf("    depth over 2 A %.3f, height of the fourth return over 2 A %.3f\n", -deepest / (2 * amplitude),
              highest / (2 * amplitude));
  EXPECT_NEAR(deepest, -2 * amplitude, 0.05 * 2 * amplitude);
  EXPECT_NEAR(highest, 0, 0.05 * 2 * amplitude);
}

TEST(MeshTruth, ABallThatRollsRoundInATubeComesUpAgain) { expect_that_a_ball_comes_up_again(tube(0.2, 1, 720), 0.2); }
TEST(CylinderWithABore, ABallThatRollsRoundInItComesUpAgain) {
  expect_that_a_ball_comes_up_again(Cylinder({0, 0, 0.5}, {0, 0, 1}, 0.25, 1, 0.2), 0.2);
}

}  // namespace
}  // namespace subsoil::dem::test::mesh_truth
