#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libdem/laws/law.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

/// A sphere of a frame.
struct ChainSphere {
  float x, y, z, r;       ///< m
  std::int32_t material;  ///< index into the frames' list of materials
};

/// What the scenario's laws give for two spheres at rest: the elastic and attractive force along their normal, N,
/// compression positive, without damping, friction and cement. Laws that remember answer as if loaded for the first
/// time, which is the most that this overlap can have carried.
class RestForce {
 public:
  /// Empty: no law is known.
  RestForce() = default;
  /// `materials`: names in the order of the indices. A pair without law gives 0.
  RestForce(const Scenario& scenario, const std::vector<std::string>& materials);

  bool known() const { return !laws_.empty(); }
  /// Maximum gap across which one of the laws acts between spheres up to this radius, m.
  double reach(double radius) const;
  /// `overlap` negative across a gap, m.
  double operator()(const ChainSphere& a, const ChainSphere& b, double overlap) const;

 private:
  std::size_t materials_ = 0;
  std::vector<std::optional<dem::Law>> laws_;  // material x material
};

/// Two spheres that press or pull each other. `size`: N, or where no law is known the overlap over the smaller radius.
struct Chain {
  std::uint32_t a, b;
  double size;
};

/// All between these spheres, found on a grid.
std::vector<Chain> chains(const std::vector<ChainSphere>& spheres, const RestForce& force);

}  // namespace subsoil::sim
