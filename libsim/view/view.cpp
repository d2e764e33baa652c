#include "libsim/view/view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "libsim/io/atomic_file.hpp"
#include "libsim/post/chains.hpp"
#include "libsim/post/disturbance.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/post/run_folder.hpp"
#include "libsim/run/output_folder.hpp"
#include "libsim/setup/world.hpp"
#include "libsim/view/packed.hpp"
#include "libsim/view/page.hpp"

namespace subsoil::sim {
namespace {

constexpr std::size_t most_samples = 800;  // of the motion: the slider has about as many pixels
constexpr std::size_t most_rows = 4000;    // of a curve: four for each pixel of its width
constexpr std::size_t most_chains = 2500;  // of a frame, the strongest: more cover each other
constexpr std::size_t most_measured = 8;   // frames of a served run that give the colour scales
constexpr double top_share = 0.998;        // of values up to which a colour scale reaches: single spheres fly off

/// Every so-many-th row, the last one included.
std::vector<std::size_t> thinned_rows(std::size_t rows, std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, (rows + most - 1) / most);
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < rows; i += stride) out.push_back(i);
  if (!out.empty() && out.back() + 1 != rows) out.push_back(rows - 1);
  return out;
}

class SeriesReader {
 public:
  explicit SeriesReader(const Series& series) : series_(series) {}
  bool has(const std::string& name) const { return series_.find(name) >= 0; }
  double at(const std::string& name, std::size_t row) const {
    const int column = series_.find(name);
    return column < 0 ? 0 : series_.values[static_cast<std::size_t>(column)][row];
  }

 private:
  const Series& series_;
};

SceneMotion motion_from(const Series& series, const Scenario& s) {
  const SeriesReader read(series);
  SceneMotion out;
  out.note = "as it ran";
  for (const BoundarySection& b : s.boundaries)
    if (b.is_moved()) out.path_names.push_back(b.name);
  for (const std::size_t row : thinned_rows(series.rows(), most_samples)) {
    const double t = read.at("time", row);
    out.times.push_back(t);
    if (s.machine) {
      Poses poses{mbd::BodyState{}};
      for (const BodySection& b : s.machine->bodies)
        poses.emplace_back(mbd::Vec2{read.at(b.name + ".x", row), read.at(b.name + ".y", row)},
                           read.at(b.name + ".angle", row), mbd::Vec2{}, 0.0);
      out.bodies.push_back(std::move(poses));
    }
    std::vector<dem::Pose> paths;
    for (const BoundarySection& b : s.boundaries) {
      if (!b.is_moved()) continue;
      paths.push_back(motion_of(b)(t));
      if (b.servo && read.has(b.name + ".x"))  // what the load has done to its path
        paths.back().position = {read.at(b.name + ".x", row), read.at(b.name + ".y", row), read.at(b.name + ".z", row)};
    }
    out.paths.push_back(std::move(paths));
  }
  return out;
}

/// Bytes of 0 ... 255 for 0 ... top.
std::string shades(const std::vector<float>& values, const std::vector<std::uint32_t>& index, std::size_t count,
                   double top) {
  std::vector<unsigned char> out(count, 0);
  for (std::size_t i = 0; i < values.size(); ++i)
    out[index[i]] =
        static_cast<unsigned char>(std::lround(255 * std::clamp(static_cast<double>(values[i]) / top, 0.0, 1.0)));
  return packed(out);
}

std::vector<float> sizes_of(const std::vector<float>& vectors) {
  std::vector<float> out;
  for (std::size_t i = 0; i + 2 < vectors.size(); i += 3)
    out.push_back(std::hypot(vectors[i], vectors[i + 1], vectors[i + 2]));
  return out;
}

}  // namespace

/// What coordinates and colours of frames are scaled by.
struct SphereScales {
  dem::Bounds box;
  double speed = 1e-9, force = 1e-9, chain = 1e-9;
};

namespace {

/// The spheres of a run's frames, as pages take them.
class SphereFrames {
 public:
  /// `force`: gives the normal forces of frames that hold no contact forces; their vectors stay empty.
  SphereFrames(const FramesFile& file, RestForce force) : file_(file), force_(std::move(force)) {}

  /// Box of all centres and the tops of the colour scales.
  SphereScales measured(const std::vector<std::size_t>& frames) {
    SphereScales out;
    std::vector<float> speeds, forces;
    for (const std::size_t f : frames) {
      const FrameSpheres s = file_.spheres(f, true);
      include(out.box, s);
      const std::vector<float> v = sizes_of(s.velocity), w = forces_of(f);
      speeds.insert(speeds.end(), v.begin(), v.end()), forces.insert(forces.end(), w.begin(), w.end());
      const std::vector<float>& contacts = strongest(f, s);
      for (std::size_t k = 6; k < contacts.size(); k += 7)
        out.chain = std::max(out.chain, std::abs(static_cast<double>(contacts[k])));
    }
    if (!(out.box.low.x <= out.box.high.x)) out.box.include(Vec3{});
    out.speed = top(speeds), out.force = top(forces);
    return out;
  }
  static void include(dem::Bounds& box, const FrameSpheres& s) {
    for (std::size_t i = 0; i + 2 < s.position.size(); i += 3)
      box.include(Vec3{s.position[i], s.position[i + 1], s.position[i + 2]});
  }
  /// Without frames.
  Json table(const ScenePack& pack, const SphereScales& scales) const {
    Json out = sphere_table(pack, file_.radius(), file_.material(), file_.materials());
    out["speedTop"] = scales.speed, out["forceTop"] = scales.force, out["chainTop"] = scales.chain;
    out["chainNote"] = records_contacts() ? "recorded by the run"
                                          : "normal forces of the law at rest for these positions, without damping, "
                                            "friction and bonds";
    return out;
  }
  Json frame(std::size_t f, ScenePack& pack, const SphereScales& scales) {
    const FrameSpheres s = file_.spheres(f, true);
    Json out{{"time", file_.times()[f]}, {"position", pack.frame(s.position, s.index)}};
    if (file_.is_moving_bed()) out["travelled"] = file_.travelled(f);
    if (!s.velocity.empty()) out["speed"] = shades(sizes_of(s.velocity), s.index, file_.particles(), scales.speed);
    if (const std::vector<float> force = forces_of(f); force.size() == s.index.size() && !force.empty())
      out["force"] = shades(force, s.index, file_.particles(), scales.force);
    if (records_contacts() || force_.known()) out["chains"] = packed_numbers(strongest(f, s));
    return out;
  }

 private:
  static double top(std::vector<float>& values) {
    if (values.empty()) return 1;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(top_share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return std::max(static_cast<double>(*at), 1e-9);
  }
  std::vector<float> forces_of(std::size_t frame) const {
    return file_.holds(frame, "force") ? sizes_of(file_.numbers(frame, "force")) : std::vector<float>{};
  }
  bool records_contacts() const { return !file_.times().empty() && file_.holds(0, "contact forces"); }
  FrameContacts contacts(std::size_t f, const FrameSpheres& s) const {
    if (records_contacts()) return file_.contact_forces(f);
    FrameContacts out;
    if (!force_.known()) return out;
    std::vector<ChainSphere> spheres;
    for (std::size_t i = 0; i < s.index.size(); ++i)
      spheres.push_back({s.position[3 * i], s.position[3 * i + 1], s.position[3 * i + 2], file_.radius()[s.index[i]],
                         file_.material()[s.index[i]]});
    for (const Chain& c : chains(spheres, force_)) {
      for (const std::uint32_t end : {c.a, c.b})
        out.ends.insert(out.ends.end(), &s.position[3 * end], &s.position[3 * end] + 3);
      out.normal.push_back(static_cast<float>(c.size));
    }
    return out;
  }
  /// The strongest contacts: both ends and the normal force, seven floats each.
  const std::vector<float>& strongest(std::size_t f, const FrameSpheres& s) {
    const auto [place, is_new] = strongest_.try_emplace(f);
    if (!is_new) return place->second;
    const FrameContacts contacts = this->contacts(f, s);
    std::vector<std::size_t> order(contacts.normal.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    const std::size_t count = std::min(order.size(), most_chains);
    std::partial_sort(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
        [&](std::size_t a, std::size_t b) { return std::abs(contacts.normal[a]) > std::abs(contacts.normal[b]); });
    std::vector<float>& out = place->second;
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t i = 0; i < 6; ++i) out.push_back(contacts.ends[6 * order[k] + i]);
      out.push_back(contacts.normal[order[k]]);
    }
    return out;
  }

  const FramesFile& file_;
  RestForce force_;
  std::map<std::size_t, std::vector<float>> strongest_;  // by frame
};

/// Of so many frames every so-many-th, and the last.
std::vector<std::size_t> every(std::size_t stride, std::size_t all) {
  std::vector<std::size_t> out;
  for (std::size_t f = 0; f < all; f += stride) out.push_back(f);
  if (!out.empty() && out.back() + 1 != all) out.push_back(all - 1);
  return out;
}

/// All spheres in as many frames as the bytes allow.
Json sphere_film(const FramesFile& file, const Scenario& scenario, double bytes) {
  SphereFrames spheres(file, {scenario, file.materials()});
  for (std::size_t stride = 1;;) {
    const std::vector<std::size_t> frames = every(stride, file.times().size());
    const SphereScales scales = spheres.measured(frames);
    ScenePack pack(file.particles(), scales.box.low, scales.box.high);
    Json out = spheres.table(pack, scales);
    double size = 0;
    for (const std::size_t f : frames) {
      Json frame = spheres.frame(f, pack, scales);
      for (const char* part : {"position", "speed", "force", "chains"})
        if (frame.contains(part)) size += static_cast<double>(frame[part].get_ref<const std::string&>().size());
      out["frames"].push_back(std::move(frame));
    }
    if (size <= bytes || frames.size() <= 2) return out;
    stride = std::max(stride + 1, static_cast<std::size_t>(std::ceil(static_cast<double>(stride) * size / bytes)));
  }
}

/// Soil's force on each body and boundary that feels any.
Json force_arrows(const SceneMaker& maker, const Series& series, const Scenario& s) {
  const SeriesReader read(series);
  Json out = Json::array();
  if (s.machine)
    for (std::size_t i = 0; i < s.machine->bodies.size(); ++i) {
      const std::string& name = s.machine->bodies[i].name;
      if (read.has(name + ".soil.Fx"))
        out.push_back({{"name", "soil on " + name},
                       {"thing", maker.thing("machine.bodies." + name)},
                       {"body", i + 1},
                       {"path", -1},
                       {"columns", {name + ".soil.Fx", name + ".soil.Fy", name + ".soil.Fz"}}});
    }
  int path = 0;
  for (std::size_t i = 0; i < s.boundaries.size(); ++i) {
    const BoundarySection& b = s.boundaries[i];
    if (!b.is_moved()) continue;
    if (read.has(b.name + ".Fx"))
      out.push_back({{"name", "soil on " + b.name},
                     {"thing", maker.thing(fmt::format("boundaries[{}]", i))},
                     {"body", -1},
                     {"path", path},
                     {"columns", {b.name + ".Fx", b.name + ".Fy", b.name + ".Fz"}}});
    ++path;
  }
  return out;
}

/// What curves can show: named monitors, the draft, and the columns that arrows and bodies need.
Json series_json(const Series& series, const Scenario& s, const Json& arrows) {
  std::vector<std::string> wanted;
  for (const SeriesColumn& c : series.columns)
    if (c.is_watch()) wanted.push_back(c.name);
  for (const char* name : {"soil.draft", "soil.lift"}) wanted.push_back(name);
  for (const Json& arrow : arrows)
    for (const Json& column : arrow["columns"]) wanted.push_back(column.get<std::string>());
  if (s.machine)
    for (const BodySection& b : s.machine->bodies)
      for (const char* quantity : {".x", ".y", ".angle"}) wanted.push_back(b.name + quantity);
  const std::vector<std::size_t> rows = thinned_rows(series.rows(), most_rows);
  const auto values = [&](std::size_t column) {
    std::vector<double> out;
    for (const std::size_t row : rows) out.push_back(series.values[column][row]);
    return packed_numbers(out);
  };
  Json columns = Json::array();
  for (const std::string& name : wanted) {
    const int at = series.find(name);
    const auto known = [&](const Json& c) { return c["name"] == name; };
    if (at < 0 || std::any_of(columns.begin(), columns.end(), known)) continue;
    const auto column = static_cast<std::size_t>(at);
    columns.push_back({{"name", name}, {"unit", series.columns[column].unit}, {"values", values(column)}});
  }
  return {{"time", values(static_cast<std::size_t>(series.find("time")))}, {"columns", columns}};
}

Json known(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double v : values) out.push_back(json_rounded(v));
  return out;
}

/// How far the container was moved to bring the bed's surface to its datum: the frames hold its walls.
double container_shift(const FramesFile& file, const Scenario& s) {
  if (!s.soil || !s.soil->container) return 0;
  for (const FrameSurface& surface : file.surfaces()) {
    if (surface.name != wall_name(2) || surface.vertices.empty()) continue;
    float low = surface.vertices[1];
    for (std::size_t i = 1; i < surface.vertices.size(); i += 3) low = std::min(low, surface.vertices[i]);
    return static_cast<double>(low) - s.soil->container->at.y;
  }
  return 0;
}

/// Tool, furrow and container as the frames have them.
void add_pass(SceneMaker& maker, const RunFolder& run, const FramesFile& file, const Scenario& s) {
  maker.add_container(container_shift(file, s));
  if (file.particles() == 0) return;
  const Disturbance found = disturbance_of(file, &s, soil_surface(run.number({"soil", "mean surface [m]"}), &s, file),
                                           run.number({"window", "from [s]"}));
  if (found.tool) maker.add_tool(*found.tool, file.times());
  if (found.furrow)
    maker.json()["furrow"] = {{"z", known(found.furrow->z)},
                              {"before", known(found.furrow->before)},
                              {"after", known(found.furrow->after)},
                              {"across", std::string(1, found.furrow->across)}};
}

/// Motion, curves and arrows of what the series holds so far.
SceneMotion add_series(SceneMaker& maker, const RunFolder& run, const Scenario& s) {
  SceneMotion motion;
  if (run.series) motion = motion_from(*run.series, s);
  if (!run.series && s.machine) motion.times = {0}, motion.bodies = {start_poses(s)};
  maker.add_motion(motion);
  if (run.series) {
    maker.json()["forces"] = force_arrows(maker, *run.series, s);
    maker.json()["series"] = series_json(*run.series, s, maker.json()["forces"]);
  }
  return motion;
}

/// The scene of a run; `add_spheres` puts those into it.
Json run_scene(const std::filesystem::path& folder,
               const std::function<void(SceneMaker&, const FramesFile&)>& add_spheres, const Json& progress) {
  const RunFolder run = read_run_folder(folder);
  const Loaded loaded = load_scenario((folder / "scenario.yaml").string());
  const Scenario& s = loaded.scenario;
  SceneMaker maker(loaded, "view");
  maker.json()["file"] = folder.string();
  maker.add_surfaces(add_series(maker, run, s), 1);
  std::vector<std::string> missing = run.missing;
  if (run.frames) try {
      const FramesFile file(folder / "run.h5");
      if (file.times().empty()) throw std::runtime_error("holds no complete frame");
      if (file.particles() > 0) add_spheres(maker, file);
      add_pass(maker, run, file, s);
    } catch (const std::exception& error) {
      missing.push_back(fmt::format("run.h5: {}; no spheres", error.what()));
    }
  if (progress.is_object()) {
    maker.add_warnings(progress["warnings"].get<std::vector<std::string>>());
    return maker.json();  // what is missing may yet come
  }
  for (const std::string& text : missing) maker.note("missing: " + text);
  if (run.summary.is_object() && run.summary.contains("warnings"))
    maker.add_warnings(run.summary["warnings"].get<std::vector<std::string>>());
  return maker.json();
}

/// What an active run reports of itself; null: none is active.
Json progress_of(const std::filesystem::path& folder) {
  const std::optional<std::string> text = reported_progress(folder);
  if (!text) return nullptr;
  Json out = Json::parse(*text, nullptr, false);
  if (!out.is_object() || !out.contains("warnings")) out = {{"warnings", Json::array()}};
  return out;
}

/// Changes when a file does.
std::string stamp_of(const std::filesystem::path& file) {
  std::error_code fault;
  const auto time = std::filesystem::last_write_time(file, fault);
  if (fault) return "-";
  return fmt::format("{}.{}", time.time_since_epoch().count(), std::filesystem::file_size(file, fault));
}

}  // namespace

Json view_scene(const ViewRequest& request) {
  const auto add_spheres = [&](SceneMaker& maker, const FramesFile& file) {
    Json spheres = sphere_film(file, maker.scenario(), request.bytes);
    if (spheres["frames"].size() < file.times().size())
      maker.note(fmt::format("{} of {} frames: the page stays below {:.0f} MB", spheres["frames"].size(),
                             file.times().size(), request.bytes * 1e-6));
    maker.json()["spheres"] = std::move(spheres);
  };
  return run_scene(request.run, add_spheres, progress_of(request.run));
}

struct ServedRun::Impl {
  std::filesystem::path run;
  std::unique_ptr<FramesFile> file;
  std::string file_stamp;
  std::optional<SphereScales> scales;
  std::optional<RestForce> force;

  SphereFrames spheres(const FramesFile& all) {
    if (!force) force = RestForce(load_scenario((run / "scenario.yaml").string()).scenario, all.materials());
    return {all, *force};
  }
  /// The frames so far; null: none yet.
  const FramesFile* frames() {
    const std::string stamp = stamp_of(run / "run.h5");
    if (stamp == "-") return nullptr;
    if (stamp != file_stamp) file = std::make_unique<FramesFile>(run / "run.h5"), file_stamp = stamp;
    return file->times().empty() || file->particles() == 0 ? nullptr : file.get();
  }
  const SphereScales& scale(const FramesFile& all) {
    const std::size_t count = all.times().size();
    if (!scales) scales = spheres(all).measured(every(std::max<std::size_t>(1, count / most_measured), count));
    return *scales;
  }
};

ServedRun::ServedRun(std::filesystem::path run) : impl_(std::make_unique<Impl>()) {
  read_run_folder(run);  // refuses what holds nothing of a run
  impl_->run = std::move(run);
}
ServedRun::~ServedRun() = default;

Json ServedRun::scene() {
  const auto add_spheres = [&](SceneMaker& maker, const FramesFile& file) {
    impl_->scales.reset();
    const SphereScales& scales = impl_->scale(file);
    Json spheres = impl_->spheres(file).table({file.particles(), scales.box.low, scales.box.high}, scales);
    for (const double t : file.times()) spheres["frames"].push_back({{"time", t}});
    maker.json()["spheres"] = std::move(spheres);
  };
  Json out = run_scene(impl_->run, add_spheres, progress_of(impl_->run));
  out["served"] = true;
  return out;
}

Json ServedRun::frame(std::size_t number) {
  const FramesFile* const file = impl_->frames();
  if (file == nullptr || number >= file->times().size())
    throw std::out_of_range(fmt::format("frame {}: there is none", number));
  SphereScales scales = impl_->scale(*file);
  SphereFrames::include(scales.box, file->spheres(number, false));
  impl_->scales = scales;  // the box only grows
  ScenePack pack(file->particles(), scales.box.low, scales.box.high);
  Json out = impl_->spheres(*file).frame(number, pack, scales);
  out["low"] = {scales.box.low.x, scales.box.low.y, scales.box.low.z};
  out["high"] = {scales.box.high.x, scales.box.high.y, scales.box.high.z};
  out["error"] = pack.error();
  return out;
}

Json ServedRun::state(const std::string& known_stamp) {
  const Json progress = progress_of(impl_->run);
  const std::size_t warnings = progress.is_object() ? progress["warnings"].size() : 0;
  Json out{{"progress", progress},
           {"stamp",
            fmt::format("{}:{}:{}", stamp_of(impl_->run / "series.csv"), stamp_of(impl_->run / "run.h5"), warnings)}};
  if (out["stamp"] == known_stamp) return out;
  const RunFolder run = read_run_folder(impl_->run);
  const Loaded loaded = load_scenario((impl_->run / "scenario.yaml").string());
  SceneMaker maker(loaded, "view");
  add_series(maker, run, loaded.scenario);
  if (progress.is_object()) maker.add_warnings(progress["warnings"].get<std::vector<std::string>>());
  for (const char* part : {"motion", "series", "forces", "warnings"}) out[part] = maker.json()[part];
  const FramesFile* const file = impl_->frames();
  out["frames"] = file == nullptr ? Json::array() : Json(file->times());
  out["count"] = file == nullptr ? 0 : file->particles();
  return out;
}

void write_view(const ViewRequest& request) { write_atomically(request.out, scene_page(view_scene(request))); }

}  // namespace subsoil::sim
