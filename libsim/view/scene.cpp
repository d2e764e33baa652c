#include "libsim/view/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/drivers/distance_driver.hpp"
#include "libmbd/drivers/slide_driver.hpp"
#include "libsim/base/version.hpp"
#include "libsim/document/document.hpp"
#include "libsim/setup/shapes.hpp"
#include "libsim/view/packed.hpp"
#include "libsim/view/symbols.hpp"

namespace subsoil::sim {
namespace {

constexpr std::uint16_t absent = 65535;  // of a coordinate: the sphere is not in the frame
constexpr double steps = 65534;          // of a coordinate over the box

Json array_of(const Vec2& p) { return {p[0], p[1]}; }
Json array_of(const Vec3& p) { return {p.x, p.y, p.z}; }

/// The scenario as a tree of values with units, without lists of spheres, which no panel shows.
Node values_of(Scenario scenario) {
  if (scenario.soil && scenario.soil->bed) scenario.soil->bed->particles.clear(), scenario.soil->bed->placed.clear();
  Problems problems;
  return parse_document(write_scenario(scenario), "scenario", {}, problems);
}

/// The node at a path such as `machine.joints.H8` or `boundaries[0]`; null: none.
const Node* node_at(const Node& root, const std::string& path) {
  const Node* node = &root;
  std::size_t from = 0;
  while (from < path.size()) {
    if (path[from] == '.') ++from;
    if (path[from] == '[') {
      const std::size_t index = std::stoul(path.substr(from + 1));
      if (index >= node->items.size()) return nullptr;
      node = &node->items[index];
      from = path.find(']', from) + 1;
      continue;
    }
    // Names may hold a point: the longest key that the rest of the path begins with.
    const Node::Entry* best = nullptr;
    for (const Node::Entry& e : node->entries) {
      const std::size_t end = from + e.key.size();
      if (path.compare(from, e.key.size(), e.key) != 0) continue;
      if (end < path.size() && path[end] != '.' && path[end] != '[') continue;
      if (best == nullptr || e.key.size() > best->key.size()) best = &e;
    }
    if (best == nullptr) return nullptr;
    node = &best->value;
    from += best->key.size();
  }
  return node;
}

/// Whether a text holds a name as a word of its own.
bool names(const std::string& text, const std::string& name) {
  const auto part_of_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if ((at == 0 || !part_of_word(text[at - 1])) && (end == text.size() || !part_of_word(text[end]))) return true;
  }
  return false;
}

/// Edges of one triangle only, two vertices each.
std::vector<std::uint32_t> open_edges(const dem::TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  for (const dem::Triangle& t : mesh.triangles())
    for (std::size_t k = 0; k < 3; ++k) ++count[std::minmax(t[k], t[(k + 1) % 3])];
  std::vector<std::uint32_t> out;
  for (const auto& [edge, triangles] : count)
    if (triangles == 1) out.push_back(edge.first), out.push_back(edge.second);
  return out;
}

const char* monitor_words(const Watch& w) {
  switch (w.kind) {
    case Watch::Kind::column:
      return "column ";
    case Watch::Kind::driver:
      return "along the driven coordinate, on the driven body: driver ";
    case Watch::Kind::force:
      return "first value of force ";
    case Watch::Kind::joint:
      return "what the joint puts on its first body, along the arrow: joint ";
    case Watch::Kind::soil_force:
      return "force of the soil along the arrow on ";
    case Watch::Kind::soil_moment:
      return "moment of the soil about the arrow on ";
    case Watch::Kind::formula:
      return "formula ";
    default:
      return "over time of ";
  }
}

std::string unit_of(const Watch& w) {
  switch (w.kind) {
    case Watch::Kind::joint:
    case Watch::Kind::soil_force:
      return "N";
    case Watch::Kind::soil_moment:
      return "N m";
    case Watch::Kind::formula:
      return w.unit;
    default:
      return "";
  }
}

}  // namespace

SceneMaker::SceneMaker(const Loaded& loaded, const std::string& mode) : loaded_(loaded), scenario_(loaded.scenario) {
  const auto& title = scenario_.title;
  scene_ = {{"format", "subsoil scene 1"},
            {"mode", mode},
            {"title", title.empty() ? "scenario without a title" : title},
            {"file", ""},
            {"version", version()},
            {"gravity", array_of(scenario_.gravity)},
            {"size", 1.0}};
  for (const char* list : {"things", "bodies", "meshes", "symbols", "warnings", "monitors", "notes", "forces"})
    scene_[list] = Json::array();
  for (const char* part : {"container", "bed", "spheres", "tool", "series", "furrow"}) scene_[part] = nullptr;
  scene_["motion"] = {
      {"note", ""}, {"times", Json::array()}, {"bodies", nullptr}, {"paths", Json::array()}, {"poses", nullptr}};
  add_things();
  if (scenario_.machine) add_machine();
  add_monitors();
}

int SceneMaker::thing(const std::string& path) const {
  const auto at = by_path_.find(path);
  return at == by_path_.end() ? -1 : at->second;
}

int SceneMaker::add_thing(const char* kind, const std::string& name, const std::string& path) {
  const std::string where = loaded_.where(path), place = where.substr(0, where.size() - path.size() - 1);
  const int number = static_cast<int>(scene_["things"].size());
  scene_["things"].push_back({{"kind", kind}, {"name", name}, {"path", path}, {"place", place}, {"values", ""}});
  by_path_[path] = number;
  return number;
}

void SceneMaker::add_things() {
  if (const auto& m = scenario_.machine) {
    for (const BodySection& b : m->bodies) add_thing("body", b.name, "machine.bodies." + b.name);
    for (const NamedJoint& j : m->joints) add_thing("joint", j.name, "machine.joints." + j.name);
    for (const NamedDriver& d : m->drivers) add_thing("driver", d.name, "machine.drivers." + d.name);
    for (const NamedForce& f : m->forces) add_thing("force", f.name, "machine.forces." + f.name);
    for (const mbd::Marker& k : m->markers) add_thing("marker", k.name, "machine.markers." + k.name);
    for (const Surface& s : m->surfaces) add_thing("surface", s.name, "machine.surfaces." + s.name);
    for (const NamedMeasure& k : m->measures) add_thing("monitor", k.name, "machine.measures." + k.name);
  }
  for (std::size_t i = 0; i < scenario_.boundaries.size(); ++i)
    add_thing("boundary", scenario_.boundaries[i].name, fmt::format("boundaries[{}]", i));
  if (scenario_.soil && scenario_.soil->container) add_thing("container", "container", "soil.container");
  if (scenario_.soil && scenario_.soil->bed) add_thing("bed", "bed", "soil.bed");
  for (const Watch& w : scenario_.output.watch) add_thing("monitor", w.name, "output.monitor." + w.name);
  const Node values = values_of(scenario_);
  for (Json& t : scene_["things"])
    if (const Node* node = node_at(values, t["path"].get<std::string>())) t["values"] = emit(*node);
}

void SceneMaker::add_machine() {
  const MachineSection& m = *scenario_.machine;
  scene_["bodies"].push_back({{"thing", -1}, {"mass", 0}});
  for (const BodySection& b : m.bodies)
    scene_["bodies"].push_back({{"thing", thing("machine.bodies." + b.name)}, {"mass", b.mass}});
  sketch_ = sketch_of(scenario_);
  const Sketch& sketch = sketch_;
  scene_["size"] = sketch.size;
  add_symbols(sketch);
  add_drivers();
  for (Json& one : element_symbols(scenario_, sketch, [this](const std::string& path) { return thing(path); }))
    scene_["symbols"].push_back(std::move(one));
  for (const mbd::Marker& k : m.markers)
    scene_["symbols"].push_back({{"kind", "marker"},
                                 {"thing", thing("machine.markers." + k.name)},
                                 {"a", k.body},
                                 {"b", k.body},
                                 {"pa", array_of(k.p)},
                                 {"pb", array_of(k.p)}});
}

Json SceneMaker::symbol(const char* kind, const Sketch::Pair& pair) const {
  return {{"kind", kind}, {"thing", thing(pair.element)}, {"a", pair.a},
          {"b", pair.b},  {"pa", array_of(pair.p_a)},     {"pb", array_of(pair.p_b)}};
}

void SceneMaker::add_symbols(const Sketch& sketch) {
  Json& out = scene_["symbols"];
  std::vector<char> towed(sketch.names.size(), 0);  // bodies that a driver draws along x: what they carry is the hitch
  for (const NamedDriver& d : scenario_.machine->drivers)
    if (const auto* c = d.element.get_if<mbd::CoordinateDriver>(); c != nullptr && c->coordinate == mbd::Coordinate::x)
      towed[static_cast<std::size_t>(c->body)] = 1;
  for (const Sketch::Pair& p : sketch.pins) {
    Json pin = symbol("pin", p);
    if (p.a == mbd::ground) pins_[p.b].push_back(p.p_b);
    if (p.b == mbd::ground) pins_[p.a].push_back(p.p_a);
    pin["hitch"] = p.a != mbd::ground && p.b != mbd::ground &&
                   towed[static_cast<std::size_t>(p.a)] != towed[static_cast<std::size_t>(p.b)];
    out.push_back(pin);
  }
  for (const Sketch::Pair& p : sketch.welds) out.push_back(symbol("weld", p));
  for (const Sketch::Slide& s : sketch.slides) {
    Json slide = symbol("slide", s);
    slide["angle"] = s.angle_a, slide["block"] = s.block, slide["below"] = s.below;
    out.push_back(slide);
  }
  for (const Sketch::Link& l : sketch.links)
    out.push_back(symbol(l.kind == Sketch::Link::Kind::spring   ? "spring"
                         : l.kind == Sketch::Link::Kind::damper ? "damper"
                                                                : "rod",
                         l));
  const auto of_body = [&](const char* kind, int body, const Vec2& p, const std::string& element) {
    const int owner = thing(element);
    const int carrier =
        body == mbd::ground ? -1 : thing("machine.bodies." + sketch.names[static_cast<std::size_t>(body)]);
    return Json{{"kind", kind},      {"thing", owner >= 0 ? owner : carrier},
                {"a", body},         {"b", body},
                {"pa", array_of(p)}, {"pb", array_of(p)}};
  };
  for (const Sketch::Disk& d : sketch.disks) {
    Json disk = of_body("disk", d.body, d.centre, "");
    disk["radius"] = d.radius;
    out.push_back(disk);
  }
  for (const Sketch::Outline& o : sketch.outlines) {
    if (o.from_surface) continue;  // its mesh is shown
    Json outline = of_body("outline", o.body, {0, 0}, "");
    outline["closed"] = o.closed;
    for (const Vec2& p : o.points) outline["points"].push_back(p[0]), outline["points"].push_back(p[1]);
    out.push_back(outline);
  }
  for (const Sketch::Side& s : sketch.sides) {
    Json side = of_body("side", s.body, s.point, s.element);
    side["angle"] = s.angle;
    out.push_back(side);
  }
}

void SceneMaker::add_drivers() {
  for (const NamedDriver& d : scenario_.machine->drivers) {
    Json out{{"kind", "driver"}, {"thing", thing("machine.drivers." + d.name)}, {"a", 0}, {"b", 0}, {"pa", {0, 0}},
             {"pb", {0, 0}}};
    // A turning driver is drawn at the pin that it turns about, where there is one.
    const auto turning = [&](int body) {
      out["what"] = "angle";
      if (const auto at = pins_.find(body); at != pins_.end()) out["pb"] = array_of(at->second.front());
    };
    if (const auto* c = d.element.get_if<mbd::CoordinateDriver>()) {
      out["b"] = c->body;
      out["what"] = c->coordinate == mbd::Coordinate::x ? "x" : "y";
      if (c->coordinate == mbd::Coordinate::angle) turning(c->body);
    } else if (const auto* a = d.element.get_if<mbd::AngleDriver>()) {
      out["a"] = a->body_a(), out["b"] = a->body_b();
      turning(a->body_b());
    } else if (const auto* ram = d.element.get_if<mbd::DistanceDriver>()) {
      out["a"] = ram->first, out["b"] = ram->second;
      out["pa"] = array_of(ram->p_a), out["pb"] = array_of(ram->p_b), out["what"] = "distance";
    } else if (const auto* slide = d.element.get_if<mbd::SlideDriver>()) {
      out["a"] = slide->body_a(), out["b"] = slide->body_b();
      out["pa"] = array_of(slide->p_a), out["pb"] = array_of(slide->p_b), out["what"] = "slide";
      out["angle"] = slide->angle_a;
    }
    scene_["symbols"].push_back(out);
  }
}

Json SceneMaker::arrow_at(const std::string& name, const Vec3& along) const {
  if (scenario_.machine)
    for (std::size_t i = 0; i < scenario_.machine->bodies.size(); ++i)
      if (scenario_.machine->bodies[i].name == name)
        return {{"body", i + 1}, {"point", {0, 0}}, {"along", array_of(along)}};
  for (std::size_t i = 0; i < scenario_.boundaries.size(); ++i)
    if (scenario_.boundaries[i].name == name)
      return {{"body", -1},
              {"point", {0, 0}},
              {"thing", thing(fmt::format("boundaries[{}]", i))},
              {"along", array_of(along)}};
  return nullptr;
}

Json SceneMaker::arrow_of_column(const std::string& column) const {
  const std::size_t dot = column.rfind('.');
  if (dot == std::string::npos) return nullptr;
  const std::string quantity = column.substr(dot + 1);
  std::string of = column.substr(0, dot);
  if (of.ends_with(".soil")) of.resize(of.size() - 5);
  static const std::map<std::string, Vec3> along{
      {"x", {1, 0, 0}},  {"vx", {1, 0, 0}}, {"ax", {1, 0, 0}}, {"Fx", {1, 0, 0}}, {"y", {0, 1, 0}},
      {"vy", {0, 1, 0}}, {"ay", {0, 1, 0}}, {"Fy", {0, 1, 0}}, {"z", {0, 0, 1}},  {"Fz", {0, 0, 1}}};
  if (const auto found = along.find(quantity); found != along.end()) return arrow_at(of, found->second);
  Json turning = quantity == "angle" || quantity == "omega" || quantity == "alpha" || quantity == "Mz"
                     ? arrow_at(of, {0, 0, 1})
                     : Json();
  if (!turning.is_null()) turning["turn"] = 1;
  return turning;
}

Json SceneMaker::arrow_of_driver(const std::string& name) const {
  const std::string path = "machine.drivers." + name;
  for (const NamedDriver& d : scenario_.machine->drivers) {
    if (d.name != name) continue;
    const int number = thing(path);
    for (const Json& s : scene_.at("symbols")) {
      if (s.at("kind") != "driver" || s.at("thing") != number) continue;
      Json out{{"body", s.at("b")}, {"point", s.at("pb")}};
      const std::string what = s.at("what");
      if (what == "angle")
        out["turn"] = 1;
      else if (what == "distance")
        out["from"] = {{"body", s.at("a")}, {"point", s.at("pa")}};
      else if (what == "slide")
        out["line"] = {{"body", s.at("a")}, {"angle", s.at("angle")}};
      else
        out["along"] = what == "x" ? Json{1, 0, 0} : Json{0, 1, 0};
      return out;
    }
  }
  return nullptr;
}

Json SceneMaker::monitor_arrow(const Watch& w) const {
  switch (w.kind) {
    case Watch::Kind::soil_force:
      return arrow_at(w.of, w.along);
    case Watch::Kind::soil_moment: {
      Json out = arrow_at(w.of, w.along);
      if (!out.is_null() && w.along.z != 0) out["turn"] = w.along.z > 0 ? 1 : -1;
      return out;
    }
    case Watch::Kind::column:
      return arrow_of_column(w.of);
    default:
      break;
  }
  if (!scenario_.machine) return nullptr;
  if (w.kind == Watch::Kind::driver) return arrow_of_driver(w.of);
  if (w.kind == Watch::Kind::force) {
    for (const NamedForce& f : scenario_.machine->forces)
      if (f.name == w.of) return positive_sense(f.element, sketch_);
  }
  if (w.kind == Watch::Kind::joint) {
    const int number = thing("machine.joints." + w.of);
    for (const Json& s : scene_.at("symbols"))
      if (number >= 0 && s.at("thing") == number)
        return {{"body", s.at("b")}, {"point", s.at("pb")}, {"along", array_of(w.along)}};
  }
  return nullptr;
}

void SceneMaker::add_monitors() {
  for (const Watch& w : scenario_.output.watch)
    scene_["monitors"].push_back({{"thing", thing("output.monitor." + w.name)},
                                  {"name", w.name},
                                  {"unit", unit_of(w)},
                                  {"words", monitor_words(w) + w.of},
                                  {"arrow", monitor_arrow(w)}});
  if (!scenario_.machine) return;
  for (const NamedMeasure& k : scenario_.machine->measures)
    scene_["monitors"].push_back({{"thing", thing("machine.measures." + k.name)},
                                  {"name", k.name},
                                  {"unit", ""},
                                  {"words", "measure of the machine"},
                                  {"arrow", nullptr}});
}

void SceneMaker::add_mesh(int number, int body, int path, bool touches, const dem::TriangleMesh& mesh) {
  std::vector<float> vertices;
  for (const Vec3& v : mesh.vertices())
    for (const double x : {v.x, v.y, v.z}) vertices.push_back(static_cast<float>(x));
  std::vector<std::uint32_t> triangles;
  for (const dem::Triangle& t : mesh.triangles()) triangles.insert(triangles.end(), t.begin(), t.end());
  const std::vector<std::uint32_t> open = open_edges(mesh);
  scene_["meshes"].push_back({{"thing", number},
                              {"body", body},
                              {"path", path},
                              {"touches", touches},
                              {"vertices", packed_numbers(vertices)},
                              {"triangles", packed_numbers(triangles)},
                              {"open", open.empty() ? Json() : Json(packed_numbers(open))}});
}

void SceneMaker::add_surfaces(const SceneMotion& motion, double plane_size) {
  if (scenario_.machine)
    for (const Surface& s : scenario_.machine->surfaces)
      if (is_bounded(s.shape))
        add_mesh(thing("machine.surfaces." + s.name), s.body_index, -1, s.touches_soil,
                 drawn_mesh(s, *scenario_.machine));
  for (std::size_t i = 0; i < scenario_.boundaries.size(); ++i) {
    const BoundarySection& b = scenario_.boundaries[i];
    const auto path = std::find(motion.path_names.begin(), motion.path_names.end(), b.name);
    const bool moves = path != motion.path_names.end();
    const dem::Pose place = moves ? dem::Pose{} : placement(b.at, b.rotation);
    add_mesh(thing(fmt::format("boundaries[{}]", i)), -1,
             moves ? static_cast<int>(path - motion.path_names.begin()) : -1, true,
             drawing_of(contact_shape(b.shape, place), plane_size));
  }
}

void SceneMaker::add_motion(const SceneMotion& motion) {
  Json& out = scene_["motion"];
  out["note"] = motion.note;
  for (const double t : motion.times) out["times"].push_back(t);
  std::vector<float> bodies, paths;
  for (const Poses& sample : motion.bodies)
    for (const mbd::BodyState& b : sample)
      for (const double v : {b.r.x, b.r.y, b.angle}) bodies.push_back(static_cast<float>(v));
  for (const std::vector<dem::Pose>& sample : motion.paths)
    for (const dem::Pose& p : sample)
      for (const double v :
           {p.position.x, p.position.y, p.position.z, p.attitude.w, p.attitude.x, p.attitude.y, p.attitude.z})
        paths.push_back(static_cast<float>(v));
  if (!bodies.empty()) out["bodies"] = packed_numbers(bodies);
  if (!paths.empty()) out["poses"] = packed_numbers(paths);
  for (const std::string& name : motion.path_names) out["paths"].push_back({{"name", name}});
}

void SceneMaker::add_container(double up) {
  if (!scenario_.soil || !scenario_.soil->container) return;
  const Soil& soil = *scenario_.soil;
  const Container& c = *soil.container;
  Json faces = Json::array();
  for (std::size_t face = 0; face < face_names.size(); ++face) {
    const char* state = c.periodic[face / 2]                          ? "periodic"
                        : soil.moving && face / 2 == 0                ? "moving"
                        : c.open[face] || c.open_after_settling[face] ? "open"
                                                                      : "wall";
    faces.push_back({{"name", face_names[face]}, {"state", state}});
  }
  scene_["container"] = {{"thing", thing("soil.container")},
                         {"low", array_of(c.at + Vec3{0, up, 0})},
                         {"high", array_of(c.at + c.size + Vec3{0, up, 0})},
                         {"faces", faces}};
  if (!scenario_.machine) scene_["size"] = std::max({c.size.x, c.size.y, c.size.z});
}

void SceneMaker::add_warnings(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    Json things = Json::array();
    for (std::size_t i = 0; i < scene_["things"].size(); ++i) {
      const Json& t = scene_["things"][i];
      const auto path = t["path"].get<std::string>(), name = t["name"].get<std::string>();
      // `soil.bed.radius` means the bed; the words `bed` and `container` alone mean no particular thing.
      const bool by_name = t["kind"] != "bed" && t["kind"] != "container" && names(text, name);
      if (by_name || text.find(path) != std::string::npos) things.push_back(i);
    }
    scene_["warnings"].push_back({{"text", text}, {"things", things}});
  }
}

void SceneMaker::add_tool(const ToolPath& tool, const std::vector<double>& times) {
  scene_["tool"] = {{"times", times},      {"names", tool.names},         {"surface", tool.soil_surface},
                    {"axis", tool.axis},   {"direction", tool.direction}, {"middle", tool.middle},
                    {"width", tool.width}, {"depth", tool.depth},         {"tip", tool.tip},
                    {"speed", tool.speed}, {"rakeLow", tool.rake_low},    {"rakeHigh", tool.rake_high}};
}

ScenePack::ScenePack(std::size_t count, const Vec3& low, const Vec3& high)
    : count_(count), low_(low), high_(high), last_(3 * count, 0) {}

std::string ScenePack::frame(std::span<const float> position, std::span<const std::uint32_t> index) {
  std::vector<std::uint16_t> now(3 * count_, absent);
  const double low[3] = {low_.x, low_.y, low_.z}, high[3] = {high_.x, high_.y, high_.z};
  for (std::size_t i = 0; i < position.size() / 3; ++i) {
    const std::size_t sphere = index.empty() ? i : index[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const double share = (static_cast<double>(position[3 * i + k]) - low[k]) / std::max(high[k] - low[k], 1e-9);
      now[3 * sphere + k] = static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * steps));
    }
  }
  std::vector<unsigned char> planes(6 * count_);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < count_; ++i) {
      const auto change = static_cast<std::uint16_t>(now[3 * i + k] - last_[3 * i + k]);
      planes[2 * k * count_ + i] = static_cast<unsigned char>(change & 255U);
      planes[(2 * k + 1) * count_ + i] = static_cast<unsigned char>(change >> 8U);
    }
  last_ = std::move(now);
  return packed(planes);
}

double ScenePack::error() const {
  return 0.5 / steps * std::max({high_.x - low_.x, high_.y - low_.y, high_.z - low_.z});
}

Json sphere_table(const ScenePack& pack, std::span<const float> radius, std::span<const int> material,
                  const std::vector<std::string>& materials) {
  Json out{{"count", radius.size()},
           {"low", array_of(pack.low())},
           {"high", array_of(pack.high())},
           {"error", pack.error()},
           {"materials", materials},
           {"speedTop", 1.0},
           {"forceTop", 1.0},
           {"chainTop", 1.0},
           {"frames", Json::array()}};
  const auto [least, most] = std::minmax_element(radius.begin(), radius.end());
  const double low = radius.empty() ? 0 : *least, high = radius.empty() ? 0 : *most;
  std::vector<unsigned char> radii, kinds;
  for (const float r : radius)
    radii.push_back(
        static_cast<unsigned char>(std::lround(255 * (static_cast<double>(r) - low) / std::max(high - low, 1e-12))));
  for (const int m : material) kinds.push_back(static_cast<unsigned char>(std::clamp(m, 0, 255)));
  out["radius"] = {{"low", low}, {"high", high}, {"bytes", high > low ? Json(packed(radii)) : Json()}};
  out["material"] = materials.size() > 1 ? Json(packed(kinds)) : Json();
  return out;
}

}  // namespace subsoil::sim
