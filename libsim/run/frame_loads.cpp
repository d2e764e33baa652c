#include "libsim/run/frame_loads.hpp"

#include <algorithm>

#include "libdem/particles/cell_area.hpp"
#include "libsim/run/wear.hpp"

namespace subsoil::sim {
namespace {

/// Row of a sphere in a snapshot, which is in rising id; -1: not there.
std::ptrdiff_t row_of(const dem::Snapshot& spheres, std::uint32_t id) {
  const auto found = std::lower_bound(spheres.id.begin(), spheres.id.end(), id);
  return found == spheres.id.end() || *found != id ? -1 : found - spheres.id.begin();
}

}  // namespace

ContactLines contact_lines(const std::vector<dem::ContactRecord>& contacts, const dem::Snapshot& spheres,
                           const dem::PeriodicCell& cell) {
  ContactLines out;
  FrameField force{"force", "N", 3, {}}, normal{"normal force", "N", 1, {}};
  for (const dem::ContactRecord& c : contacts) {
    const std::ptrdiff_t i = row_of(spheres, c.i), j = c.at_surface ? 0 : row_of(spheres, c.j);
    if (i < 0 || j < 0) continue;
    const dem::Vec3& centre = spheres.position[static_cast<std::size_t>(i)];
    dem::Vec3 end = c.at_surface ? c.point : spheres.position[static_cast<std::size_t>(j)];
    if (cell.any()) end = centre + cell.shortest(end - centre);
    out.ends.push_back(centre), out.ends.push_back(end);
    out.ids.push_back(c.i), out.ids.push_back(c.at_surface ? -1 : static_cast<std::int64_t>(c.j));
    force.values.insert(force.values.end(), {c.force.x, c.force.y, c.force.z});
    normal.values.push_back(dem::dot(c.force, c.normal));
  }
  out.fields = {std::move(normal), std::move(force)};
  return out;
}

void archive_contacts(std::vector<dem::ContactRecord>& contacts, Archive& a) {
  std::size_t count = contacts.size();
  a("count", count);
  contacts.resize(count);
  for (dem::ContactRecord& c : contacts)
    a("i", c.i)("j", c.j)("at surface", c.at_surface)("point", c.point)("normal", c.normal)("force", c.force)(
        "velocity", c.velocity);
}

FacesOfMesh faces_of(const World& world, const SurfaceRecord& surface) {
  const dem::Boundary& b = world.bed->boundary(surface.boundary);
  FacesOfMesh out;
  if (!b.loads || !surface.wear) return out;
  const std::vector<dem::TriangleMesh> meshes = dem::drawing(b.shape, 1.0);
  for (std::size_t m = 0; m < surface.mesh; ++m) out.first += meshes[m].triangles().size();
  const dem::TriangleMesh& mesh = meshes[surface.mesh];
  const dem::PeriodicCell& cell = world.bed->options().periodic;
  out.areas = dem::areas_met(cell.any() ? mesh.placed(b.pose) : mesh, cell);
  return out;
}

std::span<const dem::FaceLoad> loads_of(const World& world, const SurfaceRecord& surface, const FacesOfMesh& faces) {
  if (faces.areas.empty()) return {};
  return std::span(world.bed->boundary(surface.boundary).loads->faces).subspan(faces.first, faces.areas.size());
}

void FrameLoads::show(const SurfaceRecord& surface, std::size_t place) {
  if (!surface.wear) return;
  FacesOfMesh faces = faces_of(world_, surface);
  std::vector<double> impulse, pressure(faces.areas.size(), 0.0);
  for (const dem::FaceLoad& f : loads_of(world_, surface, faces)) impulse.push_back(f.impulse);
  before_ = world_.bed->time();
  shown_.push_back({&surface, place, std::move(faces), std::move(impulse), std::move(pressure)});
}

std::vector<std::vector<FrameField>> FrameLoads::take(double instant, std::size_t count) {
  if (shown_.empty()) return {};
  std::vector<std::vector<FrameField>> out(count);
  for (Shown& s : shown_) out[s.place] = fields(s, instant - before_);
  before_ = instant;
  return out;
}

std::vector<FrameField> FrameLoads::fields(Shown& shown, double elapsed) const {
  // A surface that moves along a periodic direction shows the spheres another part of itself.
  if (world_.bed->options().periodic.any()) shown.faces = faces_of(world_, *shown.surface);
  const std::span<const dem::FaceLoad> loads = loads_of(world_, *shown.surface, shown.faces);
  const WearSection& wear = *shown.surface->wear;
  FrameField pressure{"mean pressure", "Pa", 1, {}}, normal{"normal work", "J/m^2", 1, {}},
      shear{"shear work", "J/m^2", 1, {}}, archard{"Archard wear depth", "m", 1, {}},
      finnie{"Finnie wear depth", "m", 1, {}};
  for (std::size_t t = 0; t < loads.size(); ++t) {
    const dem::FaceLoad& f = loads[t];
    const double area = shown.faces.areas[t], per_area = area > 0 ? 1 / area : 0;  // 0: beyond a periodic side
    if (elapsed > 0) shown.pressure[t] = (f.impulse - shown.impulse[t]) / elapsed * per_area;
    shown.impulse[t] = f.impulse;
    normal.values.push_back(f.normal_work * per_area), shear.values.push_back(f.shear_work * per_area);
    archard.values.push_back(archard_volume(wear, f) * per_area);
    finnie.values.push_back(finnie_volume(wear, f) * per_area);
  }
  pressure.values.assign(shown.pressure.begin(), shown.pressure.end());
  std::vector<FrameField> out{std::move(pressure), std::move(normal), std::move(shear)};
  if (wear.has_archard()) out.push_back(std::move(archard));
  if (wear.has_finnie()) out.push_back(std::move(finnie));
  return out;
}

void FrameLoads::archive(Archive& a) {
  if (shown_.empty()) return;
  a("before", before_);
  for (Shown& s : shown_) a("impulse", s.impulse);
}

}  // namespace subsoil::sim
