#pragma once
#include <span>
#include <string>
#include <vector>

#include "libdem/packing/settle.hpp"
#include "libsim/studies/laboratory/sample.hpp"

namespace subsoil::sim {

/// Walls of a test: of the walls' material, or frictionless, so that they carry nothing along themselves.
enum class Wall { rough, smooth };

/// One packing of a sample in its box, stepped by a test that moves walls. Single-threaded: specimens run side by side.
class Specimen {
 public:
  /// `speed`: the maximum that a test expects beside the grains' own fall, m/s. Throws std::invalid_argument when the
  /// given step is above the stable one.
  Specimen(const Sample& sample, double speed = 0);

  int plane(const std::string& name, const Vec3& point, const Vec3& normal, Wall wall);
  int surface(const std::string& name, std::span<const dem::TriangleMesh> meshes, Wall wall);
  int surface(const std::string& name, const dem::TriangleMesh& mesh, Wall wall) {
    return surface(name, std::span(&mesh, 1), wall);
  }
  /// Floor and four walls of a box, minimum corner at the origin; indices in the order -x +x floor -z +z.
  struct BoxWalls {
    int left, right, floor, front, back;
  };
  BoxWalls box(double length, double width, Wall sides = Wall::smooth);

  /// Rains a packing into the region and lets it come to rest with its surface at `depth`.
  dem::SettleReport fill(const dem::Bounds& region, double depth, std::uint64_t seed);
  /// Bonds form, of grains whose law has any: called once, when the specimen is ready to be tested.
  void cement() { bed_.form_bonds(); }
  /// Until it is at rest as it stands; throws when it is not in time.
  void rest();

  /// One step; then `move` and `turn` carry surfaces on to where they stand at its end.
  void step() { bed_.step(dt_); }
  void move(int boundary, const Vec3& velocity);
  /// About the boundary's own place.
  void turn(int boundary, const Vec3& angular_velocity);

  double dt() const { return dt_; }
  /// Steps of each of `rows` rows that share out a way (m) at a speed (m/s), the way to a step; throws
  /// std::invalid_argument where there are fewer steps than rows.
  std::vector<long> steps_of_rows(double way, double speed, int rows) const;
  dem::Bed& bed() { return bed_; }
  const dem::Bed& bed() const { return bed_; }
  const Sample& sample() const { return sample_; }
  /// Force of the grains on a surface at the last step, N.
  const Vec3& force(int boundary) const { return bed_.boundary(boundary).wrench.force; }
  double height(int boundary) const { return bed_.boundary(boundary).pose.position.y; }
  /// Height of a grain's centre, m: of a clump that a sphere belongs to, else of the sphere.
  double height_of(const dem::Sphere& s) const {
    const long clump = bed_.clump_of(s);
    return clump < 0 ? s.x.y : bed_.clumps()[static_cast<std::size_t>(clump)].position.y;
  }
  double mass() const;  ///< of all grains, kg
  double top() const;   ///< of the highest grain, m
  double rms_speed() const;

 private:
  dem::SettlePlan plan(bool staged) const;

  const Sample& sample_;
  dem::Bed bed_;
  double dt_;
};

/// A horizontal lid that carries a load: one degree of freedom,
///     m v' = F - P - alpha |F - P| sign v,   alpha = 0.7
/// F the grains' force on it, P the load, m the mass of half the grains; local damping (Cundall 1987) is nothing at
/// rest and nothing in steady motion, so that F = P there. |v| is limited to sqrt(g d)/10.
class Lid {
 public:
  /// Placed a tenth of a diameter above the highest grain.
  Lid(Specimen& specimen, Wall wall);
  /// After each step of the specimen.
  void follow(double load);
  /// Steps the specimen under the load until the lid carries it within 1 % for a fall time. Throws std::runtime_error.
  void consolidate(double load);
  /// Given speed instead of a load.
  void drive(double speed) { specimen_.move(boundary_, {0, speed, 0}); }

  double force() const { return specimen_.force(boundary_).y; }
  double height() const { return specimen_.height(boundary_); }
  int boundary() const { return boundary_; }

 private:
  Specimen& specimen_;
  int boundary_;
  double mass_, speed_ = 0, largest_speed_;
};

}  // namespace subsoil::sim
