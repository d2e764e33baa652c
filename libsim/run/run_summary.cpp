#include "libsim/run/run_summary.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "libsim/base/json.hpp"
#include "libsim/base/version.hpp"
#include "libsim/post/disturbance.hpp"
#include "libsim/run/process.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/setup/container.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {

Json energy_balance(const EnergyStart& start, const World& world, const coupling::Simulation& simulation,
                    const mbd::MachineEnergy& of_machine) {
  Json e;
  double error = 0, put_in = 0;
  const auto take_in = [&](const char* name, double work) {
    e[name] = work;
    put_in += std::abs(work);
  };
  if (world.bed) {
    const dem::BedEnergy& b = world.bed->energy();
    const double closure = b.total() - b.work() - start.bed;
    double given = 0;
    for (const coupling::GivenMotion& m : world.motions) given += world.bed->boundary(m.boundary).work;
    take_in("work of given motions [J]", given);  // servos are among them
    double of_surfaces = 0, size = 0;
    for (int i = 0; i < world.bed->boundary_count(); ++i)
      of_surfaces += world.bed->boundary(i).work, size += std::abs(world.bed->boundary(i).work);
    const double of_fixed = b.boundary_work - of_surfaces;
    if (std::abs(of_fixed) > 1e-12 * size) take_in("work of fixed spheres that move [J]", of_fixed);
    double came = 0;
    if (world.moving) came = world.moving->window.entered().gravity - world.moving->window.left().gravity;
    double poured = 0, poured_kinetic = 0;
    for (const PouredSoil& one : world.inlets) {
      came += one.inlet.poured().gravity, poured_kinetic += one.inlet.poured().kinetic;
      poured += one.inlet.poured().energy();
    }
    take_in("gravity on the soil [J]", start.bed_gravity - b.gravity + came);
    if (!world.bed->forces().empty()) take_in("work of forces on spheres [J]", b.force_work);
    if (!world.inlets.empty()) take_in("kinetic energy of poured spheres [J]", poured_kinetic);
    // Of a moving bed it is what blocks bring and take, which `window` lists.
    const double left = -(b.removed + poured);  // of which sums of many spheres leave rounding
    if (!world.moving && std::abs(left) > 1e-12 * std::abs(poured))
      take_in("round a period or with spheres removed [J]", left);
    e["damped [J]"] = b.lost.damping;
    e["slid [J]"] = b.lost.sliding;
    e["rolled [J]"] = b.lost.rolling;
    if (world.bed->has_bonding_laws()) {
      e["broken bonds [J]"] = b.lost.breaking;
      e["yielded bonds [J]"] = b.lost.yielding;
    }
    if (world.bed->freezes()) e["frozen [J]"] = b.frozen;
    e["bed closure [J]"] = closure;
    error += closure;
  }
  if (world.machine) {
    take_in("work of drivers [J]", of_machine.driver_work);
    take_in("work of applied forces [J]", of_machine.force_work);
    take_in("gravity on the machine [J]", start.machine_potential - of_machine.potential);
    e["lost in the machine [J]"] = of_machine.lost;
    e["machine closure [J]"] = of_machine.balance();
    e["machine energy there or moved [J]"] = of_machine.moved;
    e["machine closure over energy there or moved"] = of_machine.closure();
    error += of_machine.balance();
  }
  if (world.bed && world.machine) {
    const coupling::InterfaceWork work = simulation.interface_work();
    e["interface, on the soil [J]"] = work.on_soil;
    e["interface, on the machine [J]"] = work.on_machine;
    e["interface error [J]"] = work.error();
    error += work.error();
  }
  e["closure [J]"] = error;
  e["work put in [J]"] = put_in;
  e["there at the start [J]"] = start.there;
  const double size = put_in + start.there;
  e["closure over energy there or put in"] = size > 0 ? error / size : 0.0;
  return e;
}

namespace {

void write_bonds(Summary& summary, const World& world) {
  const dem::BondCount n = world.bed->bonds();
  summary.section("bonds") = {{"formed", n.formed},
                              {"intact", n.intact()},
                              {"broken in tension", n.broken_in_tension},
                              {"broken in shear", n.broken_in_shear},
                              {"cut by edges", n.cut},
                              {"removed with spheres", n.removed}};
  spdlog::info("bonds: {} formed, {} intact, {} broken in tension, {} in shear, {} cut by edges", n.formed, n.intact(),
               n.broken_in_tension, n.broken_in_shear, n.cut);
}

}  // namespace

void write_run_section(Summary& summary, const RunFacts& facts, const Scenario& scenario, const RunRequest& request,
                       const World& world) {
  const int code = facts.code;
  auto& r = summary.section("run");
  r["version"] = version();
  r["scenario"] = std::filesystem::absolute(request.scenario).string();
  r["title"] = scenario.title;
  if (!request.sets.empty()) r["set"] = request.sets;
  r["end"] = code == exit_ok ? "reached" : code == exit_failed ? "failed" : "interrupted";
  if (!facts.failure.empty()) r["failure"] = facts.failure;
  r["simulated [s]"] = facts.reached;
  r["wall time [s]"] = facts.wall_time;
  r["peak memory [bytes]"] = peak_memory();
  r["steps"] = facts.steps;
  r["frames"] = facts.frames;
  if (world.machine) r["machine step [s]"] = world.step.machine_step;
  if (scenario.analysis != Analysis::dynamics)
    r["analysis"] = analysis_names[static_cast<std::size_t>(scenario.analysis)];
  if (!world.bed) return;
  r["instruction set"] = world.bed->kernel_name();
  if (world.bed->engine_name() != nullptr) r["engine"] = world.bed->engine_name();
  r["precision"] = world.bed->options().precision == dem::Precision::mixed ? "mixed" : "double";
  r["threads"] = world.bed->threads();
  r["soil step [s]"] = world.step.soil_step;
  r["soil step over stable step"] = world.step.soil_step / world.step.limit.step;
  r["stable step set by"] = world.step.limit.cause;
  r["neighbour builds"] = world.bed->rebuilds();
  r["largest overlap [share of a radius]"] = facts.deepest;
  r["particle-steps per second"] =
      static_cast<double>(world.bed->spheres().size()) * static_cast<double>(facts.steps) / facts.wall_time;
  auto& b = summary.section("soil");
  b["spheres"] = world.soil.spheres;
  if (world.soil.clumps > 0) b["clumps"] = world.soil.clumps;
  b["mass [kg]"] = world.soil.mass;
  if (acts_down(scenario.gravity)) {
    b["bulk density [kg/m3]"] = world.soil.bulk_density;
    b["mean surface [m]"] = world.soil.surface_mean;
    b["spread of the surface [m]"] = world.soil.surface_spread;
  }
  b["contacts per sphere"] = world.soil.coordination;
  // A moving bed repeats a period, of which its layers are told.
  const char* const spheres_of_layer = world.moving ? "spheres of a period" : "spheres";
  const char* const mass_of_layer = world.moving ? "mass of a period [kg]" : "mass [kg]";
  for (const auto& [material, layer] : world.soil.layers)
    b["layers"].push_back({{"material", material},
                           {spheres_of_layer, layer.spheres},
                           {mass_of_layer, layer.mass},
                           {"top [m]", layer.top},
                           {"spread of the top [m]", layer.spread},
                           {"thickness [m]", layer.thickness}});
  for (const DepthRow& row : world.soil.by_depth)
    b["by depth"].push_back({{"depth [m]", row.depth},
                             {"bulk density [kg/m3]", row.density},
                             {"contacts per sphere", row.coordination},
                             {"vertical stress [Pa]", row.vertical_stress},
                             {"horizontal over vertical stress", row.stress_ratio}});
  if (!world.soil.by_depth.empty()) {
    double sum = 0;
    for (const DepthRow& row : world.soil.by_depth) sum += row.stress_ratio;
    b["horizontal over vertical stress"] = sum / static_cast<double>(world.soil.by_depth.size());
  }
  b["settled for [s]"] = world.soil.settled_for;
  b["carved for the machine"] = world.soil.carved;
  if (world.soil.displaced > 0) b["left out for fibres"] = world.soil.displaced;
  b["fallen out and removed"] = world.bed->removed_count();
  b["outside the container at the end"] = spheres_beyond({true, true, true, false, true, true}, scenario,
                                                         world);  // over the rim and through an open side too
  if (world.bed->has_bonding_laws()) write_bonds(summary, world);
}

namespace {

/// Of spheres without contacts.
Json free_json(const dem::CarriedSoil& c) {
  return {{"spheres", c.spheres},
          {"mass [kg]", c.mass},
          {"momentum [N s]", {c.momentum.x, c.momentum.y, c.momentum.z}},
          {"kinetic [J]", c.kinetic},
          {"gravity [J]", c.gravity}};
}

Json carried_json(const dem::CarriedSoil& c) {
  Json json = free_json(c);
  json["stored in contacts [J]"] = c.stored;
  return json;
}

}  // namespace

namespace {

Json fibre_json(const FibreFacts& f) {
  const double mass = f.mass > 0 ? f.mass : 1;
  Json json{{"mass [kg]", f.mass},
            {"on the surface [kg]", f.on_surface()},
            {"buried [kg]", f.buried},
            {"buried share", f.buried / mass},
            {"mean depth of what is buried [m]", f.mean_depth}};
  for (std::size_t k = 0; k < f.by_depth.size(); ++k) {
    const double from = static_cast<double>(k) * f.band;
    json["by depth"].push_back({{"from [m]", from},
                                {"to [m]", k + 1 < f.by_depth.size() ? Json(from + f.band) : Json()},
                                {"mass [kg]", f.by_depth[k]},
                                {"share", f.by_depth[k] / mass}});
  }
  json["angle to the horizontal [rad]"] = f.to_horizontal;
  json["angle to x [rad]"] = f.to_x;
  json["nematic order"] = f.order;
  json["intact bonds"] = f.segments;
  json["broken bonds"] = f.broken;
  json["cut by edges"] = f.cut;
  return json;
}

}  // namespace

void write_fibres(Summary& summary, const World& world, const FibreDrag& drag) {
  if (world.fibres.empty()) return;
  const std::vector<FibreFacts> now = fibre_facts(world);
  auto& section = summary.section("fibres");
  const bool window = std::isfinite(summary.window_from()) && summary.window_until() > summary.window_from();
  const double from = window ? summary.window_from() : 0, until = window ? summary.window_until() : 1e300;
  for (std::size_t k = 0; k < world.fibres.size(); ++k) {
    const FibreGroup& group = world.fibres[k];
    section[group.name] = {{world.moving ? "fibres of a period" : "fibres", group.count},
                           {"spheres of a fibre", group.per_fibre()},
                           {"length [m]", group.shape.chain_length()},
                           {"diameter [m]", group.shape.diameter},
                           {"mass of a fibre [kg]", group.shape.mass()},
                           {"at the end", fibre_json(now[k])}};
    if (k < world.soil.fibres.size()) section[group.name]["at the start"] = fibre_json(world.soil.fibres[k]);
    for (const FibreDrag::Mean& mean : drag.means(k, from, until))
      section[group.name]["force on surfaces [N]"][mean.surface] = {
          {"mean of frames", {mean.force.x, mean.force.y, mean.force.z}}, {"frames", mean.frames}};
    spdlog::info("fibres {}: {:.1f} % of {:.3g} kg buried, {} bonds broken", group.name,
                 now[k].mass > 0 ? 100 * now[k].buried / now[k].mass : 0.0, now[k].mass, now[k].broken);
  }
}

void write_inlets(Summary& summary, const World& world) {
  for (const PouredSoil& one : world.inlets) {
    const dem::Inlet& inlet = one.inlet;
    Json json = free_json(inlet.poured());
    json[inlet.plan().counts ? "spheres asked for" : "mass asked for [kg]"] = inlet.asked(world.bed->time());
    json["intervals without room"] = inlet.waited();
    summary.section("inlets")[one.name] = std::move(json);
  }
}

void write_window(Summary& summary, const World& world) {
  if (!world.moving) return;
  const dem::MovingBed& window = world.moving->window;
  const FreeSoil free = free_soil(*world.bed);
  auto& json = summary.section("moving bed");
  json["blocks gone on"] = window.advanced();
  json["period of the packing [m]"] = window.block().length;
  json["way of the window [m]"] = window.way();
  json["length held beyond each end [m]"] = window.held_length();
  json["spheres of a period"] = window.block().size();
  json["entered"] = carried_json(window.entered());
  json["left"] = carried_json(window.left());
  json["left over the end ahead"] = window.pushed_out();
  json["spheres in the window at the end"] = free.spheres;
  json["mass in the window at the end [kg]"] = free.mass;
}

void write_restitution_error(Summary& summary, double error) { summary.section("run")["error of restitution"] = error; }

void write_step_error(Summary& summary, const mbd::StepError& error) {
  summary.section("run")["machine step error"] = {{"largest of a step", error.largest}, {"sum", error.sum()}};
}

void write_servos(Summary& summary, const World& world, const coupling::Simulation& simulation) {
  for (std::size_t i = 0; i < world.motions.size(); ++i) {
    const coupling::GivenMotion& m = world.motions[i];
    if (!m.servo) continue;
    const coupling::ServoState& s = simulation.servo(i);
    const dem::Boundary& b = world.bed->boundary(m.boundary);
    summary.section("servos")[b.name] = {{"load at the end [N]", s.load},
                                         {"resistance at the end [N]", s.force},
                                         {"travel [m]", s.travel},
                                         {"speed at the end [m/s]", s.velocity},
                                         {"gain [m/(N s)]", s.began ? s.gain : m.servo->gain},
                                         {"work on the soil [J]", b.work}};
  }
}

void write_exchange(Summary& summary, const coupling::ExchangeCount& count) {
  const double windows = static_cast<double>(std::max(count.windows, 1L));
  summary.section("run")["coupling"] = {
      {"machine steps", count.windows},
      {"iterations per machine step", static_cast<double>(count.evaluations) / windows},
      {"machine steps without agreement", count.open},
      {"widest disagreement [m]", count.widest}};
}

void write_events(Summary& summary, const mbd::Machine& machine) {
  const std::vector<mbd::Event>& events = machine.events();
  summary.section("run")["events"] = events.size();
  if (events.empty()) return;
  spdlog::info("{} events, the first at {:.9g} s: {} {}", events.size(), events.front().t, events.front().name,
               events.front().word());
  auto& list = summary.section("events");
  list = Json::array();
  for (const mbd::Event& e : events) list.push_back({{"time [s]", e.t}, {"of", e.name}, {"direction", e.word()}});
}

namespace {

/// Force of the soil on a tool along an axis, from its columns Fx, Fy, Fz.
struct Along {
  const char* name;
  std::string column;
  double sign;
};
std::vector<Along> axes_of(const Tool& tool) {
  const Vec3 d = tool.direction();
  const bool x = d.x != 0;
  return {{"draft", tool.column + (x ? ".Fx" : ".Fz"), x ? -d.x : -d.z},
          {"lift", tool.column + ".Fy", 1.0},
          {"sideways", tool.column + (x ? ".Fz" : ".Fx"), 1.0}};
}

/// "+x", "-z"; empty of a tool that does not travel.
std::string direction_text(const Tool& tool) {
  if (!tool.travels()) return {};
  const Vec3 d = tool.direction();
  return std::string(d.x + d.z < 0 ? "-" : "+") + (d.x != 0 ? "x" : "z");
}

std::string mean_text(const std::string& name, const BlockMean& mean, double sign, const std::string& unit) {
  std::string text = fmt::format("  {:<28} {:>10.4g} {}", name, sign * mean.mean() + 0.0, unit);
  if (std::isfinite(mean.interval())) text += fmt::format(" +- {:.2g} {}", mean.interval(), unit);
  if (!mean.steady() && unit.front() == 'N')
    text +=
        fmt::format("   not steady: changes by {:.2g} {} over the window; lengthen the run or open output.window later",
                    sign * mean.trend(), unit);
  return text + "\n";
}

}  // namespace

void write_tools(Summary& summary, const ToolProgress& progress) {
  for (const Tool& tool : progress.tools()) {
    Json json;
    json["touched soil"] = tool.touched;
    if (const std::string direction = direction_text(tool); !direction.empty()) json["direction"] = direction;
    json["greatest depth [m]"] = tool.depth;
    json["travelled in soil [m]"] = tool.travel(tool.direction());
    if (tool.travels()) json["share of the window out of the soil"] = tool.share_out();
    for (const Along& a : axes_of(tool)) {
      const BlockMean& mean = summary.over_window(a.column);
      json[std::string(a.name) + " [N]"] = {{"mean", json_number(a.sign * mean.mean())},
                                            {"interval, 95 %", json_number(mean.interval())},
                                            {"change over the window", json_number(a.sign * mean.trend())},
                                            {"steady", steady_json(mean)}};
    }
    summary.section("tools")[tool.name] = std::move(json);
  }
}

void write_disturbance(Summary& summary, const ToolProgress& progress, const std::filesystem::path& folder,
                       const Scenario& scenario, std::optional<bool> reaches_wall) {
  if (!progress.any_passes()) return;
  std::vector<ToolDraft> drafts;
  for (const Tool& tool : progress.tools()) {
    const Along along = axes_of(tool).front();
    const BlockMean& mean = summary.over_window(along.column);
    drafts.push_back({tool.name, direction_text(tool), along.sign * mean.mean(), mean.interval()});
  }
  auto& section = summary.section("disturbance");
  try {
    const FramesFile file(folder / "run.h5");
    if (file.times().size() < 2) {
      section = {{"none", "frames tell it: the run has fewer than two; set output.every"}};
      return;
    }
    const double surface = summary.section("soil").value("mean surface [m]", std::nan(""));
    section = disturbance_json(disturbance_of(file, &scenario, surface, summary.window_from()), drafts,
                               {summary.window_from(), summary.window_until(), {}});
    section[reaches_wall_key] = reaches_wall ? Json(*reaches_wall) : Json();
  } catch (const std::exception& error) {
    section = {{"none", fmt::format("the frames could not be read: {}", error.what())}};
  }
}

std::string means_text(const Summary& summary, const ToolProgress& progress, const Scenario& scenario) {
  std::string text;
  for (const Tool& tool : progress.tools())
    for (const Along& a : axes_of(tool)) {
      const BlockMean& mean = summary.over_window(a.column);
      if (mean.duration() > 0) text += mean_text(tool.name + ", " + a.name, mean, a.sign, "N");
    }
  for (const Watch& w : scenario.output.watch) {
    const BlockMean& mean = summary.over_window(w.name);
    if (mean.duration() > 0) text += mean_text(w.name, mean, 1, summary.unit(w.name));
  }
  if (text.empty()) return text;
  return fmt::format("means from {:.4g} s to {:.4g} s, with intervals of 95 %:\n{}", summary.window_from(),
                     summary.window_until(), text);
}

}  // namespace subsoil::sim
