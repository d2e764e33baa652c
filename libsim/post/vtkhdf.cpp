#include "libsim/post/vtkhdf.hpp"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "libsim/io/joined_frame.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/post/vtkhdf_file.hpp"

namespace subsoil::sim {
namespace {

/// Arrays of a frame by sphere, and of the table of spheres (docs/reference/output-variables.md).
constexpr const char* kMotion[] = {"velocity", "spin", "force", "torque", "contacts", "bonds"};
constexpr const char* kTable[] = {"id", "radius", "density", "material", "clump", "fibre"};

/// Names that are the user's as names of files: letters, digits, `.`, `+` and `-`, of which no two are alike.
std::string file_name(const std::string& name, std::set<std::string>& taken) {
  std::string first;
  for (const char c : name) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.';
    first += plain ? c : '_';
  }
  std::string out = first;
  for (int k = 2; !taken.insert(out).second; ++k) out = fmt::format("{}_{}", first, k);
  return out;
}

class Export {
 public:
  Export(FramesFile frames, const std::filesystem::path& run, const std::filesystem::path& out)
      : frames_(std::move(frames)), source_(h5::open_file(run)), folder_(out) {
    std::filesystem::create_directories(folder_);
    if (frames_.particles() > 0) soil_.emplace(begin("soil", VtkCells::vertices, {}));
    if (frames_.holds(0, "contact forces")) contacts_.emplace(begin("contact forces", VtkCells::lines, {}));
    for (const FrameSurface& s : frames_.surfaces()) surfaces_.push_back(begin_surface(s));
    for (std::size_t k = 0; k < frames_.times().size(); ++k) position_bytes_ = std::max(position_bytes_, bytes_in(k));
    for (std::size_t k = 0; k < frames_.times().size(); ++k) add(k);
  }

  std::vector<std::filesystem::path> finish() {
    if (soil_) soil_->finish(frames_.times());
    if (contacts_) contacts_->finish(frames_.times());
    for (VtkFile& block : surfaces_) block.finish(frames_.times());
    return files_;
  }

 private:
  VtkFile begin(const std::string& name, VtkCells cells, std::vector<std::int64_t> connectivity) {
    files_.push_back(folder_ / (file_name(name, taken_) + ".vtkhdf"));
    return {files_.back(), cells, std::move(connectivity)};
  }
  VtkFile begin_surface(const FrameSurface& s) {
    std::vector<std::int64_t> points;
    for (const auto& t : s.triangles) points.insert(points.end(), t.begin(), t.end());
    if (!points.empty()) return begin(s.name, VtkCells::polygons, std::move(points));
    for (const auto& t : s.segments) points.insert(points.end(), t.begin(), t.end());
    const VtkCells cells = points.empty() ? VtkCells::vertices : VtkCells::lines;
    return begin(s.name, cells, std::move(points));
  }

  static std::string group(std::size_t frame) { return fmt::format("/frames/{:06}", frame); }
  /// @param place of a dataset of the same type and shape
  /// @param from anything that reads arrays by name and by their type
  template <class From>
  VtkNumbers numbers(const std::string& name, const std::string& place, const From& from) const {
    const h5::NumberKind kind = h5::kind_of(source_, place);
    const std::vector<hsize_t> shape = h5::shape(source_, place);
    VtkNumbers out{.name = name, .real = kind.real, .bytes = kind.bytes, .columns = shape.size() > 1 ? shape[1] : 1};
    if (kind.real)
      out.reals = from.template read<double>(name);
    else
      out.wholes = from.template read<std::int64_t>(name);
    return out;
  }
  struct Folder {
    hid_t file;
    std::string path;
    template <class T>
    std::vector<T> read(const std::string& name) const {
      return h5::read<T>(file, path + "/" + name);
    }
  };
  VtkNumbers in_folder(const std::string& folder, const std::string& name) const {
    return numbers(name, folder + "/" + name, Folder{source_, folder});
  }

  int bytes_in(std::size_t frame) const {
    const JoinedFrame joined(source_, group(frame));
    return joined.holds("position") ? h5::kind_of(source_, joined.place("position")).bytes : 0;
  }

  void add(std::size_t frame) {
    if (soil_) add_soil(frame);
    if (contacts_) add_contacts(frame);
    for (std::size_t i = 0; i < surfaces_.size(); ++i) add_surface(frame, i);
  }
  void add_soil(std::size_t frame) {
    const JoinedFrame joined(source_, group(frame));
    if (!joined.holds("position")) throw std::runtime_error(group(frame) + ": holds no positions");
    const auto read = [&](const std::string& name) { return numbers(name, joined.place(name), joined); };
    VtkNumbers position = read("position");
    position.bytes = position_bytes_;  // frames far from the origin have doubles
    soil_->add_step(&position);
    for (const char* name : kMotion)
      if (joined.holds(name)) {
        const VtkNumbers values = read(name);
        soil_->add_point_array(name, &values);
      }
    // A frame that has lost none of the spheres takes what they are from the table, which stands once in the file.
    const bool own = joined.holds("id"), again = !own && table_stands_;
    for (const char* name : kTable) {
      if (own ? !joined.holds(name) : !h5::exists(source_, std::string("/particles/") + name)) continue;
      if (again) {
        soil_->add_point_array(name, nullptr);
        continue;
      }
      const VtkNumbers values = own ? read(name) : in_folder("/particles", name);
      soil_->add_point_array(name, &values);
    }
    table_stands_ = !own;
  }
  void add_contacts(std::size_t frame) {
    const std::string folder = group(frame) + "/contact forces";
    const VtkNumbers points = in_folder(folder, "ends");
    contacts_->add_step(&points);
    for (const std::string& name : h5::names_in(source_, folder))
      if (name != "ends" && name != "lines") {
        const VtkNumbers values = in_folder(folder, name);
        contacts_->add_cell_array(name, &values);
      }
  }
  void add_surface(std::size_t frame, std::size_t i) {
    const FrameSurface& s = frames_.surfaces()[i];
    VtkFile& block = surfaces_[i];
    if (s.moves || frame == 0) {
      const std::string folder = s.moves ? group(frame) + "/surfaces" : "/surfaces/" + s.name;
      const VtkNumbers points = in_folder(folder, s.moves ? s.name : "vertices");
      block.add_step(&points);
    } else {
      block.add_step(nullptr);
    }
    const std::string loads = fmt::format("{}/loads/{}", group(frame), s.name);
    if (!h5::exists(source_, loads)) return;
    for (const std::string& name : h5::names_in(source_, loads)) {
      const VtkNumbers values = in_folder(loads, name);
      block.add_cell_array(name, &values);
    }
  }

  FramesFile frames_;
  h5::Handle source_;
  std::filesystem::path folder_;
  std::set<std::string> taken_;
  std::vector<std::filesystem::path> files_;
  std::optional<VtkFile> soil_, contacts_;
  std::vector<VtkFile> surfaces_;
  bool table_stands_ = false;
  int position_bytes_ = 4;  ///< of the widest frame
};

}  // namespace

VtkhdfReport write_vtkhdf(const VtkhdfRequest& request) {
  const std::filesystem::path run = request.run / "run.h5";
  if (!std::filesystem::exists(run))
    throw std::invalid_argument(request.run.string() + ": holds no run.h5; name the results of a run with frames");
  FramesFile frames(run);
  const std::size_t steps = frames.times().size();
  if (steps == 0)
    throw std::invalid_argument(request.run.string() + ": holds no frames; set output.every in the scenario");
  Export exported(std::move(frames), run, request.out.empty() ? request.run / "vtkhdf" : request.out);
  return {steps, exported.finish()};
}

}  // namespace subsoil::sim
