#include "libsim/fmu/export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>

#include "libsim/base/json.hpp"
#include "libsim/base/version.hpp"
#include "libsim/document/document.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/document/unit_database.hpp"
#include "libsim/document/units.hpp"
#include "libsim/fmu/archive.hpp"
#include "libsim/fmu/icon.hpp"
#include "libsim/fmu/model.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/run/simulation.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {
namespace {

using Role = FmuVariable::Role;
namespace fs = std::filesystem;

std::string random_token() {
  std::random_device source;
  const auto word = [&] { return source() & 0xffffu; };
  return fmt::format("{{{:04x}{:04x}-{:04x}-{:04x}-{:04x}-{:04x}{:04x}{:04x}}}", word(), word(), word(), word(), word(),
                     word(), word(), word());
}

/// The explicit scenario, and the files that it names.
struct Bundle {
  Node document;
  std::vector<std::pair<std::string, fs::path>> files;  ///< name in the resources, file

  /// Files that the scenario names move into the resources; their new names are relative to it.
  void take_files(Node& node) {
    for (Node& item : node.items) take_files(item);
    for (Node::Entry& entry : node.entries) take_files(entry.value);
    if (node.kind != Node::Kind::scalar || node.scalar.empty() || node.scalar[0] != '/') return;
    if (!fs::is_regular_file(node.scalar)) return;
    const std::string name = fmt::format("files/{}-{}", files.size() + 1, fs::path(node.scalar).filename().string());
    files.emplace_back(name, node.scalar);
    node.scalar = name;
  }
};

FmuVariable parameter_of(const Node& document, const std::string& key) {
  const Node* const node = find_path(document, key);
  const std::string cure =
      "; name a key with one number, such as `machine.bodies.NAME.mass` or `contacts.soil-steel.mu`";
  if (key.rfind("parameters.", 0) == 0)
    throw std::invalid_argument("--parameter " + key +
                                ": the FMU's scenario has its parameters put in; name the keys that take this one, "
                                "each by a --parameter of its own");
  if (node == nullptr)
    throw std::invalid_argument("--parameter " + key + ": the scenario with all its defaults has no such key" + cure);
  std::size_t used = 0;
  double value = 0;
  try {
    value = std::stod(node->scalar, &used);
  } catch (const std::exception&) {
    throw std::invalid_argument("--parameter " + key + ": is " + node->one_line() + ", which is no number" + cure);
  }
  std::string unit = node->scalar.substr(used);
  unit.erase(0, unit.find_first_not_of(' ') == std::string::npos ? unit.size() : unit.find_first_not_of(' '));
  if (unit.empty()) unit = "1";
  try {
    parse_unit(unit);
  } catch (const std::exception&) {
    throw std::invalid_argument("--parameter " + key + ": is " + node->one_line() + ", which is not one number" + cure);
  }
  return {
      .name = key, .unit = unit, .description = "of the scenario", .role = Role::parameter, .of = key, .start = value};
}

/// 1, 2 or 5 times a power of ten, at most `value`.
double round_below(double value) {
  const double decade = std::pow(10, std::floor(std::log10(value)));
  for (const double lead : {5.0, 2.0})
    if (lead * decade <= value * (1 + 1e-9)) return lead * decade;
  return decade;
}

/// Communication step and soil step: the one is a whole number of the other.
struct Steps {
  double communication = 0, soil = 0;
};
Steps choose_steps(const Simulation& s, const Scenario& scenario, const FmuRequest& request) {
  constexpr double usual = 20;  // soil steps
  const double longest = s.step_length();
  if (!s.has_bed()) return {request.step.value_or(longest), 0};
  const double window = static_cast<double>(scenario.time.machine.soil_steps) * longest;
  if (scenario.time.soil_step) {
    const double communication = request.step.value_or(std::ceil(usual * longest / window) * window);
    const double steps = communication / window;
    if (std::abs(steps - std::round(steps)) > 1e-6 * steps || steps < 0.5)
      throw std::invalid_argument(
          fmt::format("--step {} s: must be a multiple of {} s, the scenario's soil step times `soil steps`; leave "
                      "`time.soil step` out of the scenario, and it will divide the communication step",
                      communication, window));
    return {communication, longest};
  }
  const double communication = request.step.value_or(round_below(std::max(usual * longest, window)));
  const double windows = std::max(1.0, std::ceil(communication / window - 1e-9));
  return {communication, communication / windows / static_cast<double>(scenario.time.machine.soil_steps)};
}

void add_tools(FmuModel& model, const Simulation& s, const Scenario& scenario) {
  struct Component {
    const char* name;
    const char* unit;
  };
  static constexpr Component in[] = {{"position.x", "m"},
                                     {"position.y", "m"},
                                     {"position.z", "m"},
                                     {"quaternion.w", "1"},
                                     {"quaternion.x", "1"},
                                     {"quaternion.y", "1"},
                                     {"quaternion.z", "1"},
                                     {"velocity.x", "m/s"},
                                     {"velocity.y", "m/s"},
                                     {"velocity.z", "m/s"},
                                     {"angular velocity.x", "rad/s"},
                                     {"angular velocity.y", "rad/s"},
                                     {"angular velocity.z", "rad/s"}};
  static constexpr Component out[] = {{"force.x", "N"},    {"force.y", "N"},    {"force.z", "N"},
                                      {"moment.x", "N m"}, {"moment.y", "N m"}, {"moment.z", "N m"}};
  for (const std::string& tool : model.tools) {
    const dem::Pose pose = s.pose(tool);
    const double start[] = {pose.position.x, pose.position.y, pose.position.z, pose.attitude.w,
                            pose.attitude.x, pose.attitude.y, pose.attitude.z};
    const auto boundary = std::find_if(scenario.boundaries.begin(), scenario.boundaries.end(),
                                       [&](const BoundarySection& b) { return b.name == tool; });
    const Vec3 point = boundary->reference ? pose.to_local(*boundary->reference) : Vec3{};
    for (int c = 0; c < 13; ++c)
      model.variables.push_back({.name = "tools." + tool + "." + in[c].name,
                                 .unit = in[c].unit,
                                 .description = c < 3    ? "origin of the tool's axes, world axes"
                                                : c < 7  ? "from the tool's axes to world axes"
                                                : c < 10 ? "of the origin of the tool's axes, world axes"
                                                         : "world axes",
                                 .role = Role::tool_input,
                                 .of = tool,
                                 .component = c,
                                 .start = c < 7 ? start[c] : 0});
    for (int c = 0; c < 3; ++c)
      model.variables.push_back({.name = "tools." + tool + ".point." + "xyz"[c],
                                 .unit = "m",
                                 .description = "point of the moment, in the tool's axes",
                                 .role = Role::tool_point,
                                 .of = tool,
                                 .component = c,
                                 .start = point[c]});
    for (int c = 0; c < 6; ++c)
      model.variables.push_back({.name = "tools." + tool + "." + out[c].name,
                                 .unit = out[c].unit,
                                 .description = std::string("of the soil on the tool, mean over the communication "
                                                            "step, world axes") +
                                                (c < 3 ? "" : ", about the tool's point"),
                                 .role = Role::tool_output,
                                 .of = tool,
                                 .component = c});
  }
}

void add_machine(FmuModel& model, const Simulation& s) {
  for (const InputInfo& input : s.inputs())
    model.variables.push_back(
        {.name = "inputs." + input.name,
         .unit = input.unit,
         .description = input.name.rfind("machine.drivers.", 0) == 0
                            ? "until it is set, as the scenario has it; reached evenly over a step"
                            : "until it is set, as the scenario has it; constant over a step",
         .role = Role::input,
         .of = input.name,
         .start = input.value});
  static constexpr const char* names[] = {"x", "y", "angle", "vx", "vy", "omega"};
  static constexpr const char* units[] = {"m", "m", "rad", "m/s", "m/s", "rad/s"};
  for (const std::string& body : s.bodies())
    for (int c = 0; c < 6; ++c)
      model.variables.push_back({.name = "bodies." + body + "." + names[c],
                                 .unit = units[c],
                                 .description = c < 2 ? "centre of mass" : "",
                                 .role = Role::body,
                                 .of = body,
                                 .component = c});
}

void add_columns(FmuModel& model, const Simulation& s, const Scenario& scenario) {
  for (const ColumnInfo& column : s.columns()) {
    const auto& all = scenario.output.watch;
    const auto of = [&](const auto& watch) {
      return column.name == watch.name || column.name.rfind(watch.name + ".", 0) == 0;
    };
    if (std::none_of(all.begin(), all.end(), of) || column.of_sum) continue;
    model.variables.push_back({.name = "outputs." + column.name,
                               .unit = column.unit.empty() ? "1" : column.unit,
                               .description = "output variable of the scenario, of the last soil step",
                               .role = Role::column,
                               .of = column.name});
  }
}

std::vector<std::string> tools_of(const FmuRequest& request, const Loaded& loaded) {
  std::vector<std::string> all;
  for (const BoundarySection& b : loaded.scenario.boundaries)
    if (!b.servo) all.push_back(b.name);
  for (const std::string& tool : request.tools)
    if (std::find(all.begin(), all.end(), tool) == all.end())
      throw std::invalid_argument("--tool " + tool + ": the scenario has no such boundary without a servo" +
                                  suggestion(tool, all));
  if (!request.tools.empty()) return request.tools;
  return loaded.scenario.machine ? std::vector<std::string>{} : all;
}

/// A folder that is gone with its scope.
struct ScratchFolder {
  fs::path path;
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "subsoil-fmu-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
    path = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

}  // namespace

FmuReport write_fmu(const FmuRequest& request) {
  Problems problems;
  const Loaded loaded = load_scenario(request.scenario, request.sets);
  if (!loaded.scenario.runs_in_time())
    throw ScenarioError(loaded.where("analysis") + ": is no simulation in time; an FMU steps through time");
  ZipWriter zip(request.out);
  Bundle bundle;
  bundle.document = parse_document(write_scenario(loaded.scenario), "scenario.yaml", {}, problems);
  FmuModel model;
  for (const std::string& key : request.parameters) model.variables.push_back(parameter_of(bundle.document, key));
  model.name = fs::path(request.scenario).stem().string();
  model.description = loaded.scenario.title, model.token = random_token(), model.version = version();
  model.end = loaded.scenario.time.end;
  model.tools = tools_of(request, loaded);
  if (loaded.scenario.machine)
    model.inputs = Simulation::available_inputs(write_scenario(loaded.scenario), request.scenario);
  model.forces_on = request.forces_on;

  SimulationOptions options;
  options.sets = request.sets, options.threads = request.threads;
  options.inputs = model.inputs, options.forces_on = model.forces_on;
  Simulation simulation = Simulation::from_file(request.scenario, options);
  const Steps steps = choose_steps(simulation, loaded.scenario, request);
  model.step = steps.communication;

  std::vector<FmuVariable> parameters = std::move(model.variables);
  model.variables = {{.name = "time", .unit = "s", .description = "", .role = Role::time, .of = ""}};
  add_tools(model, simulation, loaded.scenario);
  add_machine(model, simulation);
  add_columns(model, simulation, loaded.scenario);
  model.variables.insert(model.variables.end(), parameters.begin(), parameters.end());

  bundle.take_files(bundle.document);
  if (steps.soil > 0) {
    if (Node::Entry* time = bundle.document.find("time")) {
      const std::string text = fmt::format("{} s", steps.soil);
      Node::Entry* const known = time->value.find("soil step");
      known != nullptr ? static_cast<void>(known->value = Node::of(text))
                       : static_cast<void>(time->value.add("soil step", Node::of(text)));
    }
  }

  const bool three = request.version == 3;
  zip.add_text("modelDescription.xml", three ? fmi3_description(model) : fmi2_description(model));
  const std::string icon = fmu_icon(simulation.has_machine());
  if (three) {
    zip.add_text("terminalsAndIcons/terminalsAndIcons.xml", fmi3_terminals(model));
    zip.add_text("terminalsAndIcons/icon.png", icon);
  } else {
    zip.add_text("model.png", icon);
  }
  const std::string binaries = three ? "binaries/x86_64-linux/" : "binaries/linux64/";
  zip.add_file(binaries + fmu_identifier + ".so", request.library);
  for (const fs::directory_entry& beside : fs::directory_iterator(request.library.parent_path()))
    if (beside.path().filename().string().rfind("libgomp.so", 0) == 0)
      zip.add_file(binaries + beside.path().filename().string(), beside.path());
  if (const fs::path license = request.library.parent_path() / "license.txt"; fs::exists(license))
    zip.add_file("documentation/licenses/license.txt", license);
  zip.add_text("resources/scenario.yaml", emit(bundle.document));
  zip.add_text("resources/fmu.json", json_text(json_of(model), 1));
  for (const auto& [name, file] : bundle.files) zip.add_file("resources/" + name, file);
  for (const fs::path& file : unit_database()) zip.add_file("resources/" + file.filename().string(), file);
  const ScratchFolder scratch;
  if (simulation.has_bed()) {
    simulation.save().write(scratch.path / "start.h5");
    zip.add_file("resources/start.h5", scratch.path / "start.h5");
  }
  zip.commit();
  for (const std::string& tool : model.tools) {
    const dem::Pose pose = simulation.pose(tool);
    simulation.set_motion(tool, {.position = pose.position, .attitude = pose.attitude});
  }

  FmuReport report{.spheres = simulation.spheres().size(),
                   .tools = model.tools,
                   .warnings = simulation.warnings(),
                   .step = steps.communication,
                   .soil_step = steps.soil,
                   .bytes = fs::file_size(request.out)};
  for (const FmuVariable& v : model.variables)
    report.inputs += v.is_input(), report.outputs += v.is_output(), report.parameters += v.is_parameter();
  return report;
}

}  // namespace subsoil::sim
