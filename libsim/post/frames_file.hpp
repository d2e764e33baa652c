#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "libdem/geometry/bounds.hpp"
#include "libsim/io/hdf5.hpp"

namespace subsoil::sim {

/// What is not known of a run: NaN.
inline constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// A surface of run.h5 as pictures need it.
struct FrameSurface {
  std::string name;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> segments;
  std::vector<float> vertices;  ///< x y z, m; world axes where it stands still, else in its own
  bool moves = false;
  bool wall = false;  ///< of the container, that goes with a moving bed
};

/// Surfaces and where their vertices are, sample by sample: of the frames of a run, or as predicted.
class SurfaceSamples {
 public:
  virtual ~SurfaceSamples() = default;
  virtual const std::vector<double>& times() const = 0;  ///< s
  virtual const std::vector<FrameSurface>& surfaces() const = 0;
  /// World vertices of a surface that moves, one of surfaces(); empty where the sample has none.
  virtual std::vector<double> surface(std::size_t sample, const FrameSurface& s) const = 0;
};

/// The spheres of a frame, in rising id.
struct FrameSpheres {
  std::vector<std::uint32_t> index;  ///< into the particle table
  std::vector<float> position;       ///< x y z, m
  std::vector<float> velocity;       ///< m/s; empty where the run did not keep it
};

/// Contacts that carry a force.
struct FrameContacts {
  std::vector<float> ends;    ///< x y z of both ends of each, m
  std::vector<float> force;   ///< x y z of the force on the sphere at the first end, N
  std::vector<float> normal;  ///< normal force of each, compression positive, N
};

/// Reads run.h5 frame by frame: memory holds one frame. A file that a killed run left is read up to its last frame.
class FramesFile final : public SurfaceSamples {
 public:
  /// Throws std::runtime_error when the file cannot be opened or is no output of a run.
  explicit FramesFile(const std::filesystem::path& path);

  const std::vector<double>& times() const override { return times_; }  ///< s, of the complete frames
  std::size_t particles() const { return radius_.size(); }
  const std::vector<float>& radius() const { return radius_; }    ///< m, by index
  const std::vector<float>& density() const { return density_; }  ///< kg/m^3, by index
  /// Solid volume that a sphere stands for, m^3: of a clump's its share of the clump's, in which overlaps count once.
  double volume(std::size_t index) const;
  /// Number of the clump that a sphere belongs to, by index, -1 for none; empty in a bed without clumps.
  const std::vector<std::int32_t>& clump() const { return clump_; }
  /// Number of the fibre that a sphere belongs to, by index, -1 for none; empty in a bed without fibres.
  const std::vector<std::int32_t>& fibre() const { return fibre_; }
  const std::vector<std::int32_t>& material() const { return material_; }
  const std::vector<std::string>& materials() const { return materials_; }
  const std::vector<FrameSurface>& surfaces() const override { return surfaces_; }

  FrameSpheres spheres(std::size_t frame, bool with_velocity) const;
  /// Box around the spheres of some frames; without their radii, around their centres.
  dem::Bounds extent(std::span<const std::size_t> frames, bool with_radii) const;
  /// Of a moving bed, of which a frame holds what lies in the window then: where its spheres lay before anything
  /// disturbed them; and the x of the window's ends, m, the one behind first.
  bool is_moving_bed() const { return !at_rest_.empty(); }
  FrameSpheres undisturbed(std::size_t frame) const;
  std::array<double, 2> window(std::size_t frame) const;
  double travelled(std::size_t frame) const;  ///< by the window since the first frame, along x, m; 0 without
  /// Places (x y z, m) as seen from the window where it was in the first frame.
  void put_in_window(std::size_t frame, std::vector<float>& places) const;
  /// Whole numbers by sphere of the frame, such as `contacts`.
  std::vector<std::int32_t> counts(std::size_t frame, const std::string& name) const;
  /// Likewise numbers such as `force`, three of each sphere.
  std::vector<float> numbers(std::size_t frame, const std::string& name) const;
  /// Of frames that hold `contact forces`.
  FrameContacts contact_forces(std::size_t frame) const;
  std::vector<double> surface(std::size_t frame, const FrameSurface& s) const override;
  /// What a frame holds under this name.
  bool holds(std::size_t frame, const std::string& name) const;

 private:
  std::string group(std::size_t frame) const;
  void read_particles();
  void read_surfaces();
  void repeat_period();
  h5::Handle file_;
  std::vector<double> times_;
  std::vector<std::int64_t> id_;
  std::vector<float> radius_, density_;
  std::vector<double> volume_;  ///< empty in a bed without clumps
  std::vector<std::int32_t> material_, clump_, fibre_;
  std::vector<std::string> materials_;
  std::vector<double> at_rest_;  ///< x y z of the spheres of a period, m
  double period_ = 0;            ///< m
  double first_rear_ = 0;        ///< x of the window's rear end in the first frame, m
  std::vector<FrameSurface> surfaces_;
};

}  // namespace subsoil::sim
