/// Work and precision of the machine integrators: global error against computing time for ten mechanisms.
///
/// Error: largest difference of any coordinate from the reference at twenty outputs, lengths over the machine's length,
/// angles in rad. Reference: cvode at 1e-13; what it is worth is said by adams-moulton of order 6 with the finest
/// steps, which shares no step control with it, as the mechanism's first line (`reference`). Time: the thread's own CPU
/// time, the least of four runs in one process, which a start-up or a cold cache is no part of; a step of the machine
/// uses one thread.
///
///     work_precision [mechanism ...] > work-precision.csv      (drawn by scripts/work_precision.py)
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/integrators/adaptive.hpp"
#include "tests/tools/mechanisms.hpp"
#include "tests/tools/rig.hpp"

namespace {

using namespace subsoil;
using mbd::IntegratorKind;

constexpr int outputs = 20;

struct Mechanism {
  std::string name;
  mbd::Model model;
  double end;        ///< s
  long steps;        ///< of the coarsest fixed step
  double towed = 0;  ///< m/s; above 0 it starts from the towing equilibrium
};

mbd::Model rig_under_load() {
  auto rig = test::make_rig({.raise = 0.125});
  rig.model.add("wrench",
                mbd::AppliedForce{.body = rig.shovel,
                                  .fx = mbd::HarmonicFunction{.mean = -500, .amplitude = 200, .frequency = 2.3},
                                  .fy = mbd::HarmonicFunction{.mean = -150, .amplitude = 100, .frequency = 1.1},
                                  .moment = mbd::HarmonicFunction{.amplitude = 40, .frequency = 3.1}});
  return rig.model;
}

/// IFToMM benchmark A01: a point of 1 kg on a massless link of 1 m, let go from the horizontal.
mbd::Model point_pendulum() {
  mbd::Model m;
  m.add({.name = "mass", .mass = 1, .inertia = 1e-12, .pose = {1, 0, 0}});
  m.add("pivot", mbd::Revolute{.body_a = mbd::ground, .body_b = 1, .p_b = {-1, 0}});
  return m;
}

/// IFToMM benchmark A02: N four-bar windows of uniform links of 1 m and 1 kg, upright, thrown at 1 m/s; they pass their
/// flat pose, where every window gains a freedom.
mbd::Model windows(int count) {
  const auto numbered = [](std::string name, int i) { return name.append(std::to_string(i)); };
  mbd::Model m;
  std::vector<int> cranks;
  for (int i = 0; i <= count; ++i) {
    cranks.push_back(test::add_rod(m, numbered("crank ", i), {1.0 * i, 0}, {1.0 * i, 1}, 1));
    m.bodies.back().velocity = {0.5, 0, -1};
    m.add(numbered("A", i), test::pin_at(m, mbd::ground, cranks.back(), {1.0 * i, 0}));
  }
  for (int i = 1; i <= count; ++i) {
    const int coupler = test::add_rod(m, numbered("coupler ", i), {i - 1.0, 1}, {1.0 * i, 1}, 1);
    m.bodies.back().velocity = {1, 0, 0};
    const auto at = [&](int k) { return cranks[static_cast<std::size_t>(k)]; };
    m.add(numbered("B left ", i), test::pin_at(m, at(i - 1), coupler, {i - 1.0, 1}));
    m.add(numbered("B right ", i), test::pin_at(m, coupler, at(i), {1.0 * i, 1}));
  }
  return m;
}

std::vector<Mechanism> mechanisms() {
  return {{"pendulum", test::make_chain(1), 5, 400},
          {"double pendulum", test::make_chain(2), 2, 400},
          {"slider-crank", test::make_slider_crank(), 1, 400},
          {"four-bar", test::make_four_bar(), 2, 800},
          {"squeezer", test::make_squeezer(), 0.03, 600},
          {"rig", rig_under_load(), 1, 200, 0.5},
          {"chain of 10", test::make_chain(10, 0.1, 0.1), 0.5, 200},
          {"point pendulum (A01)", point_pendulum(), 10, 1000},
          {"two windows (A02)", windows(2), 10, 2000},
          {"chain of 30", test::make_chain(30, 0.1, 0.1), 0.3, 400}};
}

double cpu_time() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Result {
  double seconds = 0;
  long steps = 0, evaluations = 0;  ///< of methods with steps of their own
  std::vector<Eigen::VectorXd> poses;
};

Result run(const Mechanism& m, const mbd::MachineOptions& options, long steps) {
  mbd::Machine machine(m.model, options);
  if (m.towed > 0)
    machine.start_from_towing_equilibrium(m.towed);
  else
    machine.start_from_pose();
  Result result;
  const double begin = cpu_time();
  for (int i = 0; i < outputs; ++i) {
    const long parts = std::max(1L, steps / outputs);
    for (long k = 0; k < parts; ++k) machine.advance(m.end / static_cast<double>(outputs * parts));
    result.poses.push_back(machine.integrator().state().q);
  }
  result.seconds = cpu_time() - begin;
  if (const auto* own = dynamic_cast<const mbd::Adaptive*>(&machine.integrator()))
    result.steps = own->steps(), result.evaluations = own->evaluations();
  return result;
}

double error_of(const Mechanism& m, const Result& a, const Result& b) {
  const mbd::System system(m.model);
  const Eigen::VectorXd scale = mbd::coordinate_scale(system) / system.length_scale();
  double worst = 0;
  for (std::size_t i = 0; i < a.poses.size(); ++i)
    worst = std::max(worst, scale.cwiseProduct(a.poses[i] - b.poses[i]).cwiseAbs().maxCoeff());
  return worst;
}

void measure(const Mechanism& m, const Result& reference, const std::string& method, const std::string& parameter,
             const mbd::MachineOptions& options, long steps) {
  try {
    Result best = run(m, options, steps);  // warms caches and branch predictors up
    for (int again = 0; again < 3; ++again) best.seconds = std::min(best.seconds, run(m, options, steps).seconds);
    std::printf("%s,%s,%s,%.3e,%.4e,%ld,%ld\n", m.name.c_str(), method.c_str(), parameter.c_str(),
                error_of(m, best, reference), best.seconds, best.steps ? best.steps : steps,
                best.evaluations ? best.evaluations : 2 * steps);
    std::fflush(stdout);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s, %s %s: %s\n", m.name.c_str(), method.c_str(), parameter.c_str(), error.what());
  }
}

void measure_all(const Mechanism& m) {
  const auto cvode = [](double tolerance) {
    return mbd::MachineOptions{.integrator = IntegratorKind::cvode, .cvode = {.rtol = tolerance, .atol = tolerance}};
  };
  const Result reference = run(m, cvode(1e-13), outputs);
  measure(m, reference, "reference", "adams-moulton 6", {.adams_moulton = {.order = 6}}, 64 * m.steps);
  for (const int order : {2, 4, 6})
    for (long steps = m.steps; steps <= 32 * m.steps; steps *= 2)
      measure(m, reference, "adams-moulton " + std::to_string(order), std::to_string(steps),
              {.adams_moulton = {.order = order}}, steps);
  for (int digits = 4; digits <= 11; ++digits) {
    const double tolerance = std::pow(10.0, -digits);
    const std::string text = "1e-" + std::to_string(digits);
    measure(m, reference, "cvode", text, cvode(tolerance), outputs);
    if (digits > 10) continue;
    mbd::MachineOptions ida{.integrator = IntegratorKind::ida, .ida = {.rtol = tolerance, .atol = tolerance}};
    measure(m, reference, "ida", text, ida, outputs);
    ida.ida.formulation = mbd::IdaFormulation::index_1;
    measure(m, reference, "ida index 1", text, ida, outputs);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> wanted(argv + 1, argv + argc);
  std::printf("mechanism,method,parameter,error,seconds,steps,evaluations\n");
  for (const Mechanism& m : mechanisms())
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), m.name) != wanted.end()) measure_all(m);
}
