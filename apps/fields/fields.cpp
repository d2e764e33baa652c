#include "apps/fields/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "apps/fields/fields_file.hpp"
#include "apps/report/frames_file.hpp"

namespace subsoil::app {
namespace {

struct Box {
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void take(const float* p) {
    for (int d = 0; d < 3; ++d) {
      low[d] = std::min(low[d], static_cast<double>(p[d]));
      high[d] = std::max(high[d], static_cast<double>(p[d]));
    }
  }
};

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

/// Over all that the kernels of all chosen frames reach, so that nothing is lost at its rim.
FieldGrid grid_over(const Box& box, const FieldsRequest& request, double width, double reach) {
  FieldGrid grid;
  grid.spacing = request.spacing.value_or(0.5 * width);
  const auto lay = [&] {
    grid.low = box.low - Vec3{reach, reach, reach};
    for (int d = 0; d < 3; ++d)
      grid.n[static_cast<std::size_t>(d)] =
          static_cast<std::size_t>(std::ceil((box.high[d] - box.low[d] + 2 * reach) / grid.spacing)) + 1;
    if (!request.section) return;
    grid.low[request.section->axis] = request.section->at;
    grid.n[static_cast<std::size_t>(request.section->axis)] = 1;
  };
  lay();
  if (request.spacing) {
    if (static_cast<double>(grid.size()) > 50 * FieldsRequest::most_points)
      throw std::invalid_argument(
          fmt::format("--spacing {} m: makes {} points; at most {:g}: make it wider, or give a "
                      "--section",
                      grid.spacing, grid.size(), 50 * FieldsRequest::most_points));
    return grid;
  }
  for (; static_cast<double>(grid.size()) > FieldsRequest::most_points; lay()) grid.spacing *= 1.1;
  return grid;
}

GrainFields fields_of(const FramesFile& file, std::size_t frame, const FieldGrid& grid, const FieldKernel& kernel,
                      const FieldsHeld& held) {
  CoarseGraining coarse(grid, kernel);
  const FrameSpheres s = file.spheres(frame, held.velocity);
  const std::vector<std::int32_t> contacts =
      held.contacts ? file.counts(frame, "contacts") : std::vector<std::int32_t>(s.index.size());
  const auto vector = [](const std::vector<float>& of, std::size_t i) {
    return of.empty() ? Vec3{} : Vec3{of[3 * i], of[3 * i + 1], of[3 * i + 2]};
  };
  for (std::size_t i = 0; i < s.index.size(); ++i) {
    const double r = file.radius()[s.index[i]], volume = 4.0 / 3.0 * M_PI * r * r * r;
    coarse.add({.position = vector(s.position, i),
                .velocity = vector(s.velocity, i),
                .mass = file.density()[s.index[i]] * volume,
                .volume = volume,
                .contacts = static_cast<double>(contacts.at(i))});
  }
  if (held.stress) {
    const FrameContacts c = file.contact_forces(frame);
    for (std::size_t k = 0; k < c.force.size() / 3; ++k)
      coarse.add_contact(vector(c.ends, 2 * k), vector(c.ends, 2 * k + 1), vector(c.force, k));
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
  Box box;
  double diameter = 0;
  for (const float r : file.radius()) diameter += 2.0 * r / static_cast<double>(file.particles());
  for (const std::size_t f : frames) {
    const FrameSpheres s = file.spheres(f, false);
    for (std::size_t i = 0; i < s.index.size(); ++i) box.take(&s.position[3 * i]);
  }
  if (box.low.x > box.high.x) throw std::invalid_argument("the frames hold no spheres any more; choose others");
  const double width = request.width.value_or(diameter);
  const FieldKernel kernel(request.kernel, width);
  const FieldsHeld held{.velocity = file.holds(frames.front(), "velocity"),
                        .contacts = file.holds(frames.front(), "contacts"),
                        .stress = file.holds(frames.front(), "contact forces")};
  const FieldGrid grid = grid_over(box, request, width, kernel.reach());
  const std::string about =
      fmt::format("{}, width {:.9g} m, zero from {:.9g} m on",
                  request.kernel == FieldKernel::Kind::lucy ? "Lucy" : "Gaussian", width, kernel.reach());
  FieldsFile out(request.out.empty() ? request.run / "fields" : request.out, grid, held, about);
  for (const std::size_t f : frames) out.add(file.times()[f], fields_of(file, f, grid, kernel, held));
  return {out.finish(),  width,         kernel.reach(), grid.spacing, grid,
          frames.size(), held.velocity, held.contacts,  held.stress};
}

}  // namespace subsoil::app
