#include "libsim/post/disturbance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/base/json.hpp"
#include "libsim/post/run_folder.hpp"

namespace subsoil::sim {
namespace {

Json known(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double v : values) out.push_back(json_number(v));
  return out;
}

Json layers_json(const Furrow& f) {
  Json out = Json::array();
  for (const LayerMotion& l : f.layers) {
    Json into;
    for (std::size_t k = 0; k < f.layers.size(); ++k) into[f.layers[k].name] = json_number(l.into.at(k));
    out.push_back({{"name", l.name},
                   {"spheres", l.spheres},
                   {"mean rise [m]", l.rise},
                   {"mean way along the travel [m]", l.forward},
                   {"mean way aside [m]", l.aside},
                   {"share in another layer", l.moved_out},
                   {"shares by layer", into}});
  }
  return out;
}

}  // namespace

double soil_surface(double of_summary, const Scenario* scenario, const FramesFile& file) {
  if (std::isfinite(of_summary)) return of_summary;
  if (scenario != nullptr && scenario->soil && scenario->soil->surface) return *scenario->soil->surface;
  const FrameSpheres s = file.spheres(0, false);
  std::vector<float> y;
  for (std::size_t i = 0; i < s.index.size(); ++i) y.push_back(s.position[3 * i + 1] + file.radius()[s.index[i]]);
  if (y.empty()) return 0;
  const auto at = y.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(y.size() - 1));
  std::nth_element(y.begin(), at, y.end());
  return *at;
}

dem::PeriodicCell periodic_cell(const Scenario* scenario) {
  const bool known = scenario != nullptr && scenario->soil && scenario->soil->container;
  return known ? periodic_cell(*scenario->soil->container) : dem::PeriodicCell{};
}

Disturbance disturbance_of(const FramesFile& file, const Scenario* scenario, double surface, double steady_from) {
  std::map<std::string, std::string> body_of;
  if (scenario != nullptr && scenario->machine)
    for (const Surface& s : scenario->machine->surfaces) body_of[s.name] = s.body;
  Disturbance out;
  if (file.particles() > 0) out.tool = tool_path(file, surface, body_of, periodic_cell(scenario));
  if (scenario != nullptr && scenario->output.region)
    out.why = "`output.region` leaves soil out of the frames";
  else if (out.tool)
    out.furrow = furrow(file, *out.tool, steady_from, periodic_cell(scenario), out.why);
  else
    out.why = "no moving surface comes below the soil's surface";
  return out;
}

Disturbance disturbance_of(const std::filesystem::path& path) {
  const RunFolder run = read_run_folder(path);
  const FramesFile file(path / "run.h5");
  if (file.times().empty()) return {{}, {}, "run.h5 holds no complete frame"};
  const Scenario* const scenario = run.scenario ? &*run.scenario : nullptr;
  return disturbance_of(file, scenario, soil_surface(run.number({"soil", "mean surface [m]"}), scenario, file),
                        run.number({"window", "from [s]"}));
}

SpecificDraft specific_draft(const ToolPath& tool, const Furrow& furrow, const std::vector<ToolDraft>& drafts,
                             const TimeWindow& window) {
  const SpecificDraft none{std::nan(""), std::nan("")};
  double sum = 0, variance = 0;
  bool any = false;
  for (const ToolDraft& one : drafts) {
    if (one.direction.empty()) continue;
    for (const ToolDraft& other : drafts)
      if (other.direction.size() == 2 && other.direction[1] == one.direction[1] &&
          other.direction[0] != one.direction[0])
        return none;
    any = true, sum += one.mean, variance += one.half_width * one.half_width;
  }
  if (!any || !(furrow.disturbed_area > 0) || tool.share_out(window.from, window.until) > most_out_of_soil) return none;
  return {sum / furrow.disturbed_area, std::sqrt(variance) / furrow.disturbed_area};
}

Json disturbance_json(const Disturbance& d, const std::vector<ToolDraft>& drafts, const TimeWindow& window) {
  Json out;
  if (d.tool) {
    out["tool"] = d.tool->names;
    out["greatest depth of the tip [m]"] = *std::max_element(d.tool->depth.begin(), d.tool->depth.end());
    out["width in the soil [m]"] = d.tool->width;
  }
  if (!d.furrow) {
    out["none"] = d.why;
    return out;
  }
  const Furrow& f = *d.furrow;
  out[fmt::format("stretch from {} [m]", f.along)] = f.from;
  out[fmt::format("stretch until {} [m]", f.along)] = f.until;
  out["of steady work"] = f.steady;
  out["cell [m]"] = f.cell;
  out["furrow area below the surface [m2]"] = f.furrow_area;
  out["furrow depth [m]"] = f.depth, out["furrow width [m]"] = f.width;
  out["heap area above the surface [m2]"] = f.heap_area;
  out["largest heave [m]"] = f.heave;
  out["ridge to ridge [m]"] = json_number(f.ridge_to_ridge);
  out["disturbed area [m2]"] = f.disturbed_area;
  out["disturbed: mean displacement above [m]"] = f.threshold;
  out["loosened area [m2]"] = f.loosened_area;
  out["loosened: rise of porosity above"] = Furrow::loosening;
  out["swell"] = f.swell;
  if (f.disturbed_area > 0) {
    const SpecificDraft specific = specific_draft(*d.tool, f, drafts, window);
    out["specific draft [N/m2]"] = json_number(specific.value);
    out["specific draft, interval 95 % [N/m2]"] = json_number(specific.half_width);
  }
  out["layers"] = layers_json(f);
  out["profile"] = {{fmt::format("{} [m]", f.across), known(f.z)},
                    {"surface before [m]", known(f.before)},
                    {"surface after [m]", known(f.after)}};
  return out;
}

}  // namespace subsoil::sim
