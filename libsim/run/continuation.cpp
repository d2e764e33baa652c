#include "libsim/run/continuation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "libmbd/elements.hpp"
#include "libsim/document/document.hpp"
#include "libsim/scenario/effects.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {
namespace {

/// An item of a list by its name, contacts by their pair, others by their number.
std::string name_of(const Node& item, std::size_t index) {
  if (const auto* name = item.find("name")) return "." + name->value.scalar;
  if (const auto* between = item.find("between"); between != nullptr && between->value.items.size() == 2)
    return "." + between->value.items[0].scalar + "-" + between->value.items[1].scalar;
  return fmt::format("[{}]", index);
}

/// Every value by its path. Lists of numbers and words are one value.
void flatten(const Node& node, const std::string& path, std::map<std::string, std::string>& out) {
  if (node.kind == Node::Kind::mapping) {
    for (const Node::Entry& e : node.entries) flatten(e.value, path.empty() ? e.key : path + "." + e.key, out);
    return;
  }
  const bool mappings =
      node.kind == Node::Kind::sequence && !node.items.empty() && node.items.front().kind == Node::Kind::mapping;
  if (!mappings) {
    out[path] = node.one_line();
    return;
  }
  for (std::size_t i = 0; i < node.items.size(); ++i) flatten(node.items[i], path + name_of(node.items[i], i), out);
}

const std::string kContents = "contents of ";

std::map<std::string, std::string> values_of(const std::string& text) {
  Problems problems;
  std::map<std::string, std::string> out;
  flatten(parse_document(text, "scenario.yaml", {}, problems), "", out);
  for (const auto& [file, sum] : contents_in(text)) out[kContents + file] = sum;
  return out;
}

bool starts(const std::string& key, const char* head) { return key.rfind(head, 0) == 0; }

/// Whether `key` is `head` or below it.
bool within(const std::string& key, const std::string& head) {
  return key == head || (starts(key, head.c_str()) && (key[head.size()] == '.' || key[head.size()] == '['));
}

/// `machine.bodies.tine` of `machine.bodies.tine.mass`: what there is one of in the state.
std::string owner_of(const std::string& key) {
  for (const char* family : {"machine.bodies.", "machine.joints.", "machine.drivers.", "machine.forces.",
                             "machine.surfaces.", "materials.", "boundaries.", "contacts."})
    if (starts(key, family)) return key.substr(0, key.find('.', std::string(family).size()));
  return {};
}

bool has_owner(const std::map<std::string, std::string>& values, const std::string& owner) {
  return std::any_of(values.begin(), values.end(), [&](const auto& v) { return within(v.first, owner); });
}

/// What a driver moves, and not how.
bool is_driven(const std::string& key) {
  if (!starts(key, "machine.drivers.")) return false;
  const std::size_t name = key.find('.', std::string("machine.drivers.").size());
  if (name == std::string::npos) return false;
  const std::string rest = key.substr(name + 1);
  return !within(rest, "position") && !within(rest, "velocity") && !within(rest, "acceleration");
}

Difference::Kind kind_of(const std::string& key) {
  if (starts(key, kContents.c_str())) return Difference::Kind::impossible;
  for (const char* head : {"title", "engine", "simd", "time.end", "time.threads", "output", "limits"})
    if (within(key, head)) return Difference::Kind::harmless;
  for (const char* head :
       {"subsoil", "analysis", "soil.bed", "soil.clumps", "soil.container", "soil.surface", "soil.moving",
        "soil.inlets", "machine.start", "machine.bodies", "machine.joints", "machine.surfaces"})
    if (within(key, head)) return Difference::Kind::impossible;
  if (starts(key, "materials.") && key.size() > 8 && key.substr(key.size() - 8) == ".density")
    return Difference::Kind::impossible;  // spheres have their mass
  if (is_driven(key)) return Difference::Kind::impossible;
  return Difference::Kind::physics;
}

std::string shown(const std::string& value) { return value.empty() ? "left out" : value; }

}  // namespace

std::vector<Difference> differences(const std::string& before, const std::string& now) {
  const auto a = values_of(before), b = values_of(now);
  std::map<std::string, Difference> found;
  for (const auto& [key, value] : a) {
    const auto there = b.find(key);
    if (there == b.end() || there->second != value)
      found[key] = {key, value, there == b.end() ? "" : there->second, kind_of(key)};
  }
  for (const auto& [key, value] : b)
    if (!a.count(key)) found[key] = {key, "", value, kind_of(key)};
  std::vector<Difference> out;
  for (auto& [key, d] : found) {
    // Of another file the name differs itself; the bed of a file lies in the state.
    const auto bed_file = a.find("soil.bed.file");
    if (starts(key, kContents.c_str()) &&
        (d.before.empty() || d.now.empty() || (bed_file != a.end() && key == kContents + bed_file->second)))
      d.kind = Difference::Kind::harmless;
    const std::string owner = owner_of(key);
    // Left out where it has no effect: what took the effect away differs itself.
    const auto conditional = [&](const ConditionalKey& c) { return within(key, c.path); };
    const std::span<const ConditionalKey> all = conditional_keys();
    if ((d.before.empty() || d.now.empty()) && std::any_of(all.begin(), all.end(), conditional))
      d.kind = Difference::Kind::harmless;
    if (!owner.empty() && d.kind != Difference::Kind::harmless && has_owner(a, owner) != has_owner(b, owner))
      d.kind = Difference::Kind::impossible;
    out.push_back(std::move(d));
  }
  return out;
}

void refuse_changes(const std::vector<Difference>& found, const std::vector<std::string>& wished,
                    const std::string& state) {
  std::string text;
  for (const Difference& d : found) {
    if (d.kind == Difference::Kind::harmless) continue;
    const bool asked = std::any_of(wished.begin(), wished.end(), [&](const auto& w) { return within(d.key, w); });
    const std::string line =
        fmt::format("{}: the state was written with {} = {}, now {}: ", state, d.key, shown(d.before), shown(d.now));
    if (d.kind == Difference::Kind::impossible)
      text += line + "the state holds what was made of it; start without --from to change it\n";
    else if (!asked)
      text += line + "if the change is wished for, give `subsoil run` --from and --change " +
              (d.key.find(' ') == std::string::npos ? d.key : "\"" + d.key + "\"") + "\n";
  }
  for (const std::string& w : wished)
    if (std::none_of(found.begin(), found.end(), [&](const Difference& d) { return within(d.key, w); }))
      text += fmt::format(
          "--change {}: does not differ from what the state was written with, or is no key; leave it out\n", w);
  if (text.empty()) return;
  text.pop_back();
  throw ScenarioError(text);
}

void refuse_other_bed(const std::vector<Difference>& found, const std::string& state) {
  std::string text;
  for (const Difference& d : found) {
    const bool of_soil = within(d.key, "soil") || within(d.key, "materials");
    // Where a file lies is another matter in another folder.
    const bool of_file = d.key.ends_with(".file") || d.key.ends_with(".import") || d.key.ends_with(".mesh");
    if (d.kind != Difference::Kind::impossible || !of_soil || of_file) continue;
    text += fmt::format(
        "{}: its bed was made with {} = {}, the scenario has {}; leave `start` out, or make the state again\n", state,
        d.key, shown(d.before), shown(d.now));
  }
  if (text.empty()) return;
  text.pop_back();
  throw ScenarioError(text);
}

const std::string& begun_by(const SavedRun& saved) { return saved.begun_by.empty() ? saved.scenario : saved.begun_by; }

bool drivers_differ(const std::vector<Difference>& found) {
  return std::any_of(found.begin(), found.end(), [](const Difference& d) { return within(d.key, "machine.drivers"); });
}

namespace {

[[noreturn]] void refuse_jump(const std::string& state, const std::string& who, double by, const char* unit,
                              double time, const char* cause) {
  throw ScenarioError(
      fmt::format("{}: {} would jump by {:.4g} {}: {} at {:.6g} s; give a motion that agrees with it "
                  "then",
                  state, who, by, unit, cause, time));
}

bool has_other_motion(const std::vector<Difference>& found, const std::string& driver) {
  return std::any_of(found.begin(), found.end(),
                     [&](const Difference& d) { return within(d.key, "machine.drivers." + driver); });
}

}  // namespace

void continue_drivers(World& world, SavedRun& saved, const std::vector<Difference>& found, const std::string& state) {
  if (!world.machine) return;
  constexpr double close = 1e-4;
  mbd::System& system = world.machine->system();  // which knows what is open, and where joints have latched
  mbd::Snapshot& s = saved.machine.value();
  if (static_cast<int>(s.pose.size()) != system.coordinates() || s.velocity.size() != s.pose.size())
    return;  // of another machine, which restoring refuses
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(s.pose.data(), system.coordinates());
  const Eigen::VectorXd velocity = Eigen::Map<const Eigen::VectorXd>(s.velocity.data(), system.coordinates());
  mbd::Constraints c;
  const auto look = [&] {
    system.restore(s.elements);
    system.set_state(s.time, q, velocity);
    system.constraints(c);
  };
  look();
  for (std::size_t i = 0; i < system.model().drivers.size(); ++i) {
    const auto& driver = system.model().drivers[i];
    if (!has_other_motion(found, driver.name)) continue;
    const int row = system.row_of_driver(i);
    visit(
        [&](const auto& d) {  // Phi = what is driven - f(t)
          if (!d.motion.position.is_set())
            s.elements.drivers[i] = {c.phi[row] + d.motion.value(s.time), c.jacobian.row(row).dot(velocity), s.time};
        },
        driver.element);
  }
  look();
  for (int row = 0; row < system.equations(); ++row) {
    if (std::abs(c.phi[row]) > close)
      refuse_jump(state, system.owner(row), std::abs(c.phi[row]), system.angular_row(row) ? "rad" : "m", s.time,
                  "its motion is elsewhere than the state");
    const double rate = c.jacobian.row(row).dot(velocity) + c.phi_t[row];
    if (system.part(row).kind == mbd::PartName::Kind::driver && has_other_motion(found, system.part(row).name) &&
        std::abs(rate) > close)
      refuse_jump(state, system.owner(row), std::abs(rate), system.angular_row(row) ? "rad/s" : "m/s", s.time,
                  "its motion has another velocity than the state");
  }
}

void refuse_surface_jumps(const World& world, double time, const std::string& state) {
  if (!world.bed) return;
  for (const coupling::GivenMotion& m : world.motions) {
    const double dt = world.step.soil_step;
    const double step = dem::norm(m.pose(time).position - m.pose(time - dt).position);
    dem::Vec3 gap = m.pose(time).position - world.bed->boundary(m.boundary).pose_before.position;
    if (m.servo) gap += m.servo->along * -dem::dot(gap, m.servo->along);  // the way of a servo is in the state
    const double off = dem::norm(gap);
    if (off > 10 * step + 1e-6)
      refuse_jump(state, world.bed->boundary(m.boundary).name, off, "m", time,
                  "its motion is a function of time from 0 on, and elsewhere than the state");
  }
}

}  // namespace subsoil::sim
