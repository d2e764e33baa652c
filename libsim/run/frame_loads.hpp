#pragma once
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/io/run_writer.hpp"
#include "libsim/setup/world.hpp"

/// What frames show beside spheres and places: forces of single contacts, and what triangles of surfaces have borne.
namespace subsoil::sim {

/// Lines between the spheres of a snapshot; contacts of spheres that are not in it are left out. Across a periodic side
/// a line ends where the second sphere would be beyond it.
ContactLines contact_lines(const std::vector<dem::ContactRecord>& contacts, const dem::Snapshot& spheres,
                           const dem::PeriodicCell& cell = {});
void archive_contacts(std::vector<dem::ContactRecord>& contacts, Archive& a);

/// The triangles of one mesh among those of its boundary. What lies on them changes from step to step, they do not.
struct FacesOfMesh {
  std::size_t first = 0;      ///< triangle of the boundary
  std::vector<double> areas;  ///< m^2 that spheres can meet; empty where the boundary keeps no loads
};
FacesOfMesh faces_of(const World& world, const SurfaceRecord& surface);
/// What lies on them now.
std::span<const dem::FaceLoad> loads_of(const World& world, const SurfaceRecord& surface, const FacesOfMesh& faces);

/// Loads on the triangles of surfaces that keep them: mean pressure over the steps since the frame before, work and
/// wear since the start. Of a frame between two steps they are those of the step's end; further frames within that step
/// have the same.
class FrameLoads {
 public:
  explicit FrameLoads(const World& world) : world_(world) {}
  /// The surface is number `place` of those that frames hold.
  void show(const SurfaceRecord& surface, std::size_t place);
  /// By surface, `count` of them; empty where none keeps loads. `instant`: up to which the loads are summed.
  std::vector<std::vector<FrameField>> take(double instant, std::size_t count);
  /// What the pressure of the next frame counts from. Nothing where no surface keeps loads.
  void archive(Archive& a);

 private:
  struct Shown {
    const SurfaceRecord* surface;
    std::size_t place;
    FacesOfMesh faces;
    std::vector<double> impulse;   ///< N s at the frame before
    std::vector<double> pressure;  ///< Pa, of the frame before
  };
  /// `elapsed`: time of the steps summed since the frame before.
  std::vector<FrameField> fields(Shown& shown, double elapsed) const;

  const World& world_;
  std::vector<Shown> shown_;
  double before_ = 0;  ///< s, instant of the loads in the frame before
};

}  // namespace subsoil::sim
