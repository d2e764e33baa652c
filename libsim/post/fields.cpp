#include "libsim/post/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "libdem/particles/particles.hpp"
#include "libsim/base/periodic_images.hpp"
#include "libsim/post/disturbance.hpp"
#include "libsim/post/fields_file.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/post/run_folder.hpp"

namespace subsoil::sim {
namespace {

std::vector<std::size_t> chosen_frames(const FramesFile& file, const FieldsRequest& request) {
  const std::vector<double>& times = file.times();
  std::vector<std::size_t> out;
  if (request.all)
    for (std::size_t f = 0; f < times.size(); ++f) out.push_back(f);
  for (const double t : request.times) {
    if (t < times.front() - 1e-9 || t > times.back() * (1 + 1e-9) + 1e-9)
      throw std::invalid_argument(
          fmt::format("--times {} s: frames lie between {} s and {} s", t, times.front(), times.back()));
    std::size_t nearest = 0;
    for (std::size_t f = 1; f < times.size(); ++f)
      if (std::abs(times[f] - t) < std::abs(times[nearest] - t)) nearest = f;
    out.push_back(nearest);
  }
  if (out.empty()) out.push_back(times.size() - 1);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// Over all that the kernels of all chosen frames reach, so that nothing is lost at its rim. Between periodic sides
/// over the cell, in whole parts of it: the far side is the near one, and has no points of its own.
FieldGrid lay_grid(const dem::Bounds& box, const FieldsRequest& request, double spacing, double reach,
                   const dem::PeriodicCell& cell) {
  FieldGrid grid;
  for (int d = 0; d < 3; ++d) {
    std::size_t& n = grid.n[static_cast<std::size_t>(d)];
    grid.low[d] = box.low[d] - reach, grid.spacing[d] = spacing;
    n = static_cast<std::size_t>(std::ceil((box.high[d] - box.low[d] + 2 * reach) / spacing)) + 1;
    if (cell.length[d] > 0) {
      grid.low[d] = cell.low[d];
      n = static_cast<std::size_t>(std::max(1.0, std::round(cell.length[d] / spacing)));
      grid.spacing[d] = cell.length[d] / static_cast<double>(n);
    }
  }
  if (request.section) {
    grid.low[request.section->axis] = request.section->at, grid.spacing[request.section->axis] = spacing;
    grid.n[static_cast<std::size_t>(request.section->axis)] = 1;
  }
  return grid;
}

/// Of a section that no kernel reaches all fields are 0.
void refuse_section_outside(const dem::Bounds& box, const FieldSection& section, double reach,
                            const dem::PeriodicCell& cell) {
  const int d = section.axis;
  const bool periodic = cell.length[d] > 0;
  const double low = periodic ? cell.low[d] : box.low[d] - reach;
  const double high = periodic ? cell.low[d] + cell.length[d] : box.high[d] + reach;
  if (section.at >= low && section.at <= high) return;
  throw std::invalid_argument(
      fmt::format("--section {}={:.6g} m: is outside the bed, whose fields go from {:.4g} to {:.4g} m",
                  static_cast<char>('x' + d), section.at, low, high));
}

FieldGrid grid_over(const dem::Bounds& box, const FieldsRequest& request, double width, double reach,
                    const dem::PeriodicCell& cell) {
  double spacing = request.spacing.value_or(0.5 * width);
  FieldGrid grid = lay_grid(box, request, spacing, reach, cell);
  if (request.spacing) {
    if (static_cast<double>(grid.size()) > 50 * FieldsRequest::most_points)
      throw std::invalid_argument(
          fmt::format("--spacing {} m: makes {} points; at most {:g}: make it wider, or give a "
                      "--section",
                      spacing, grid.size(), 50 * FieldsRequest::most_points));
    return grid;
  }
  while (static_cast<double>(grid.size()) > FieldsRequest::most_points)
    grid = lay_grid(box, request, spacing *= 1.1, reach, cell);
  return grid;
}

/// A kernel that falls between the points of the grid adds up to no mass.
void refuse_narrow_kernel(const FieldGrid& grid, const FieldsRequest& request, double width) {
  double widest = 0;
  for (int d = 0; d < 3; ++d)
    if (!request.section || request.section->axis != d) widest = std::max(widest, grid.spacing[d]);
  if (width >= widest) return;
  throw std::invalid_argument(fmt::format(
      "{} = {:.4g} m: is narrower than the grid, whose points are {:.4g} m apart: kernels fall between them, and the "
      "integral of the density is not the mass; give --width of {:.3g} m or more{}",
      request.width ? "--width" : "the width", width, widest, 1.005 * widest,
      request.spacing ? ", or a smaller --spacing"
                      : fmt::format(", or a --section: the whole bed has {:g} points at most",
                                    static_cast<double>(FieldsRequest::most_points))));
}

double mass_of(const FramesFile& file, std::size_t index) {
  return file.density()[index] * dem::sphere_volume(file.radius()[index]);
}

Vec3 vector_of(const std::vector<float>& of, std::size_t i) {
  return of.empty() ? Vec3{} : Vec3{of[3 * i], of[3 * i + 1], of[3 * i + 2]};
}

/// Forces that a clump passes on inside it. Each of its spheres gets f_k from its contacts and moves with the clump, as
/// m_k/M sum f would make it; what it has less, m_k/M sum f - f_k, comes from the others, along lines from their centre
/// of mass. (Turning is left out: bodies at rest and in translation are balanced exactly.)
/// Across periodic sides spheres of a clump lie apart: all count where they are beside its first one.
void add_clumps(const FramesFile& file, const FrameSpheres& s, const FrameContacts& contacts, const FieldKernel& kernel,
                const dem::PeriodicCell& cell, CoarseGraining& coarse) {
  if (file.clump().empty()) return;
  struct Clump {
    double mass = 0;
    Vec3 first{}, centre{}, force{};
    Vec3 beside(const Vec3& x, const dem::PeriodicCell& of) const { return first + of.shortest(x - first); }
  };
  std::map<std::int32_t, Clump> clumps;
  std::map<std::array<float, 3>, std::size_t> at;  // a contact knows its spheres by their centres
  for (std::size_t i = 0; i < s.index.size(); ++i) {
    const std::int32_t clump = file.clump()[s.index[i]];
    if (clump < 0) continue;
    at[{s.position[3 * i], s.position[3 * i + 1], s.position[3 * i + 2]}] = i;
    const double m = mass_of(file, s.index[i]);
    Clump& c = clumps[clump];
    if (c.mass == 0) c.first = vector_of(s.position, i);
    c.mass += m, c.centre += m * c.beside(vector_of(s.position, i), cell);
  }
  std::vector<Vec3> given(s.index.size());
  for (std::size_t k = 0; k < contacts.force.size() / 3; ++k)
    for (const std::size_t end : {2 * k, 2 * k + 1}) {
      const float* const p = &contacts.ends[3 * end];
      const auto sphere = at.find({p[0], p[1], p[2]});
      if (sphere != at.end()) given[sphere->second] += (end % 2 == 0 ? 1.0 : -1.0) * vector_of(contacts.force, k);
    }
  for (const auto& [place, i] : at) clumps[file.clump()[s.index[i]]].force += given[i];
  for (const auto& [place, i] : at) {
    const Clump& c = clumps[file.clump()[s.index[i]]];
    const Vec3 inner = mass_of(file, s.index[i]) / c.mass * c.force - given[i];
    const Vec3 from = c.beside(vector_of(s.position, i), cell), to = (1 / c.mass) * c.centre;
    dem::Bounds line;
    line.include(from), line.include(to);
    each_image(line.low, line.high, cell, kernel.reach(),
               [&](const Vec3& shift) { coarse.add_contact(from + shift, to + shift, inner); });
  }
}

GrainFields fields_of(const FramesFile& file, std::size_t frame, const FieldGrid& grid, const FieldKernel& kernel,
                      const FieldsHeld& held, const dem::PeriodicCell& cell) {
  CoarseGraining coarse(grid, kernel);
  const FrameSpheres s = file.spheres(frame, held.velocity);
  const std::vector<std::int32_t> contacts =
      held.contacts && !s.index.empty() ? file.counts(frame, "contacts") : std::vector<std::int32_t>(s.index.size());
  for (std::size_t i = 0; i < s.index.size(); ++i) {
    FieldGrain grain{.position = vector_of(s.position, i),
                     .velocity = vector_of(s.velocity, i),
                     .mass = mass_of(file, s.index[i]),
                     .volume = file.volume(s.index[i]),
                     .contacts = static_cast<double>(contacts.at(i))};
    each_image(grain.position, grain.position, cell, kernel.reach(), [&](const Vec3& shift) {
      FieldGrain image = grain;
      image.position += shift;
      coarse.add(image);
    });
  }
  if (held.stress) {
    const FrameContacts c = file.contact_forces(frame);
    for (std::size_t k = 0; k < c.force.size() / 3; ++k) {
      const Vec3 from = vector_of(c.ends, 2 * k), to = vector_of(c.ends, 2 * k + 1), force = vector_of(c.force, k);
      const Vec3 low{std::min(from.x, to.x), std::min(from.y, to.y), std::min(from.z, to.z)};
      const Vec3 high{std::max(from.x, to.x), std::max(from.y, to.y), std::max(from.z, to.z)};
      each_image(low, high, cell, kernel.reach(),
                 [&](const Vec3& shift) { coarse.add_contact(from + shift, to + shift, force); });
    }
    add_clumps(file, s, c, kernel, cell, coarse);
  }
  return coarse.finish();
}

}  // namespace

FieldsReport write_fields(const FieldsRequest& request) {
  if (!std::filesystem::exists(request.run / "run.h5"))
    throw std::invalid_argument(request.run.string() + ": holds no run.h5; name the results of a run with frames");
  const FramesFile file(request.run / "run.h5");
  if (file.times().empty() || file.particles() == 0)
    throw std::invalid_argument(request.run.string() + ": its frames hold no spheres, so there are no fields");
  const std::vector<std::size_t> frames = chosen_frames(file, request);
  const RunFolder run = read_run_folder(request.run);
  const dem::PeriodicCell cell = periodic_cell(run.scenario ? &*run.scenario : nullptr);
  const std::string sides = run.scenario ? "" : run.missing.front();
  const dem::Bounds box = file.extent(frames, false);
  double diameter = 0;
  for (const float r : file.radius()) diameter += 2.0 * r / static_cast<double>(file.particles());
  if (box.empty()) throw std::invalid_argument("the frames hold no spheres any more; choose others");
  const double width = request.width.value_or(diameter);
  const FieldKernel kernel(request.kernel, width);
  const FieldsHeld held{.velocity = file.holds(frames.front(), "velocity"),
                        .contacts = file.holds(frames.front(), "contacts"),
                        .stress = file.holds(frames.front(), "contact forces")};
  if (request.section) refuse_section_outside(box, *request.section, kernel.reach(), cell);
  const FieldGrid grid = grid_over(box, request, width, kernel.reach(), cell);
  refuse_narrow_kernel(grid, request, width);
  const std::string about =
      fmt::format("{}, width {:.9g} m, zero from {:.9g} m on",
                  request.kernel == FieldKernel::Kind::lucy ? "Lucy" : "Gaussian", width, kernel.reach());
  FieldsFile out(request.out.empty() ? request.run / "fields" : request.out, grid, held, about);
  for (const std::size_t f : frames) out.add(file.times()[f], fields_of(file, f, grid, kernel, held, cell));
  return {out.finish(), width, kernel.reach(), grid, frames.size(), held.velocity, held.contacts, held.stress, sides};
}

}  // namespace subsoil::sim
