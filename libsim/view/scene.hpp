#pragma once
#include <map>
#include <string>
#include <vector>

#include "libsim/base/json.hpp"
#include "libsim/post/tool_path.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/sketch.hpp"

/// A scene is what a picture in three dimensions shows of a scenario: one description for what will run (show.hpp) and
/// for what has run (view.hpp). It is JSON; arrays of numbers are packed (packed.hpp). Its keys and their units stand
/// in page/types.d.ts, which the page's scripts are checked against.
namespace subsoil::sim {

/// Poses of bodies and of surfaces on given paths, sample by sample.
struct SceneMotion {
  std::string note;  ///< what moves the machine here
  std::vector<double> times;
  std::vector<Poses> bodies;                    ///< by sample; ground first
  std::vector<std::string> path_names;          ///< of `boundaries` that move
  std::vector<std::vector<dem::Pose>> paths{};  ///< by sample, then by name
};

class SceneMaker {
 public:
  /// @param mode "show" or "view"
  SceneMaker(const Loaded& loaded, const std::string& mode);

  /// Number of the thing at a path of the scenario ("machine.joints.H8"); -1: none.
  int thing(const std::string& path) const;

  /// Surfaces of bodies and boundaries by the scenario's shapes. @param motion its paths are those of boundaries that
  /// move
  void add_surfaces(const SceneMotion& motion, double plane_size);
  void add_motion(const SceneMotion& motion);
  /// @param up of the container, m, to bring the bed's surface to its datum
  void add_container(double up);
  /// Each points at the things whose name or path it holds.
  void add_warnings(const std::vector<std::string>& texts);
  /// @param times of its samples, s
  void add_tool(const ToolPath& tool, const std::vector<double>& times);
  void note(const std::string& text) { scene_["notes"].push_back(text); }

  const Scenario& scenario() const { return scenario_; }
  double size() const { return scene_.at("size").get<double>(); }
  Json& json() { return scene_; }

 private:
  void add_things();
  int add_thing(const char* kind, const std::string& name, const std::string& path);
  void add_machine();
  void add_symbols(const Sketch& sketch);
  void add_drivers();
  void add_monitors();
  Json symbol(const char* kind, const Sketch::Pair& pair) const;
  void add_mesh(int thing, int body, int path, bool touches, const dem::TriangleMesh& mesh);
  /// Where a monitor is positive; null where it has no direction in the picture.
  Json monitor_arrow(const Watch& watch) const;
  Json arrow_at(const std::string& name, const Vec3& along) const;  ///< of a body or boundary
  Json arrow_of_column(const std::string& column) const;
  Json arrow_of_driver(const std::string& name) const;

  const Loaded& loaded_;
  const Scenario& scenario_;
  std::map<std::string, int> by_path_;
  Sketch sketch_;
  std::map<int, std::vector<Vec2>> pins_;  ///< by body: where it turns against the ground
  Json scene_;
};

/// Spheres of one frame or many. Coordinates are whole numbers of 16 bits in the box of all centres.
class ScenePack {
 public:
  /// @param count of all spheres that any frame may hold
  ScenePack(std::size_t count, const Vec3& low, const Vec3& high);

  /// A frame: x y z of spheres with a place in `index` (empty: all, in order), m; the others are not there.
  std::string frame(std::span<const float> position, std::span<const std::uint32_t> index);
  /// Maximum error of a coordinate, m.
  double error() const;
  Vec3 low() const { return low_; }
  Vec3 high() const { return high_; }

 private:
  std::size_t count_;
  Vec3 low_, high_;
  std::vector<std::uint16_t> last_;
};

/// What never changes about the spheres of a scene.
Json sphere_table(const ScenePack& pack, std::span<const float> radius, std::span<const int> material,
                  const std::vector<std::string>& materials);

}  // namespace subsoil::sim
