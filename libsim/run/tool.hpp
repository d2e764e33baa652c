#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// What passes through the soil: the surfaces of one body that touch it, or a boundary on a given path.
struct Tool {
  std::string name;
  std::string column;                     ///< owner of its force in the series: `tine.soil`, or the boundary's name
  std::vector<std::size_t> surfaces;      ///< in World::surfaces
  std::vector<std::vector<Vec3>> points;  ///< of each surface, in its axes
  bool passes = true;  ///< travels along the soil by more than a sphere: of a given path that is known
  bool touched = false;
  bool touches = false;  ///< in the last step

  // along its way, as far as it was followed
  std::optional<Vec3> entry;  ///< its place when it first stood in the soil, and what it has gone out of it since
  Vec3 last;                  ///< its place when it was followed last in the soil
  bool in_soil = false;       ///< below the soil's surface within the bed, or in contact up to a diameter above it
  long looks = 0, out = 0;    ///< in the window of the means, from its entry on; of them those that find it not in soil
  double reached = 0;         ///< m along its way, the farthest in the window so far
  double gained = 0;          ///< m of it, in the window
  double fell_back = 0;       ///< m, the most that it came back from there
  long stands = 0;            ///< looks since it came farther
  Vec3 began;                 ///< horizontal unit vector along x or z of what it first moved by at all
  Vec3 along;                 ///< the same of where it has come farthest; zero until it has moved by a sphere's radius
  Vec3 gone;                  ///< m in soil from its entry to where it was followed last there, horizontal
  double farthest = 0;        ///< m, of the length of `gone`
  Vec3 ahead, behind;         ///< m, of `gone` along +x and +z, and along -x and -z: the farthest so far
  double depth = 0;           ///< m below the soil's mean surface, the greatest so far
  Vec3 size;                  ///< m along x and z of what is below the surface, the longest so far
  double room = 0;            ///< m from its foremost point below the surface to the end of the soil

  /// Along x or z: where it has come to since its entry, else where it began to go. What resists it acts against this.
  Vec3 direction() const;
  /// It goes along the soil.
  bool travels() const { return passes && dem::norm(along) > 0; }
  /// m in soil from the entry in a direction along x or z, the farthest so far: to and fro count once.
  double travel(const Vec3& direction) const;
  double length() const { return along.x != 0 ? size.x : size.z; }  ///< m along its way
  /// Share of the window of the means, from its entry on, in which it is not in soil.
  double share_out() const { return looks > 0 ? static_cast<double>(out) / static_cast<double>(looks) : 0; }
  /// Share of the window in which it has come no farther, at its end.
  double share_standing() const { return looks > 0 ? static_cast<double>(stands) / static_cast<double>(looks) : 0; }
  void archive(Archive& a) {
    a("reached", reached)("gained", gained)("fell back", fell_back)("stands", stands);
    a("touched", touched)("touches", touches)("entry", entry)("last", last)("in soil", in_soil)("looks", looks)("out",
                                                                                                                out);
    a("began", began)("along", along)("gone", gone)("farthest", farthest)("ahead", ahead)("behind", behind);
    a("depth", depth)("size", size)("room", room);
  }
};

/// Follows the tools and reports when their work is steady.
///
/// What a tool travels out of the soil, lifted or past the end of the bed, is no travel in soil.
///
/// A tool works steadily from when it has travelled, in the soil, its own length below the surface plus its depth: then
/// the soil ahead of it and beside it has been sheared along its whole length. Its window ends when its foremost point
/// is one depth from the end of the soil, where the end wall begins to be felt. Both are looked at along the way that
/// it has really gone. With several tools the window is the time in which all that are in the soil work steadily; one
/// that enters later opens it again.
class ToolProgress {
 public:
  /// The scenario outlives it. Where inlets pour it measures the surface in `world` until a tool moves in the soil.
  ToolProgress(World& world, const coupling::Simulation& simulation, const Scenario& scenario);

  const std::vector<Tool>& tools() const { return tools_; }
  bool any_passes() const;
  bool any_travelled() const;  ///< in soil, by more than a sphere
  /// Two tools that pass through the soil in opposite directions; nullptr: all go one way.
  std::pair<const Tool*, const Tool*> opposed() const;
  /// Where the tools are now.
  void follow();
  /// Counts this look in the window of the means.
  void count_look();
  /// The window opens again.
  void forget_looks();
  /// Whether soil touches them in this step: a contact may be shorter than a row.
  void look_for_touch();
  std::size_t entered() const;  ///< that have stood in the soil
  bool steady() const;          ///< all that are in the soil have travelled far enough
  bool at_the_end() const;      ///< one has come to the end of the soil
  /// In the last follow() one that travels has come farther in another direction than in the one before.
  bool turned() const { return turned_; }
  void archive(Archive& a) {
    for (Tool& tool : tools_) a("tool", tool);
    a("low", low_)("high", high_)("radius", radius_);
  }

 private:
  void add(const std::string& name, const std::string& column, std::size_t surface);
  /// @param measured in this look: what it was below the surface before counts no more
  void follow(Tool& tool, bool measured);
  void take_soil();
  void measure_poured_soil();
  double length_of_path(const SurfaceRecord& surface, double end) const;

  World& world_;
  const coupling::Simulation& simulation_;
  const Scenario& scenario_;
  std::vector<Tool> tools_;
  Vec3 low_, high_;  ///< box of the soil
  double radius_ = 0;
  bool turned_ = false;
};

/// The period after which the given motions and forces of a scenario repeat themselves: harmonic and periodic ones, and
/// what turns steadily from `from` (s) on: their first common multiple, up to 20 of the longest. 0 when nothing is
/// periodic, NaN without one.
double period_of(const Scenario& scenario, double from);

}  // namespace subsoil::sim
