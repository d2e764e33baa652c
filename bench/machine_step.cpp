// machine_step: how fast a step of the machine is: the rig 1S-300, alone and as in a coupled run, where the soil's
// wrench on the shovel changes at every step, and pendulum chains; Adams-Moulton of order 4 (two evaluations per step),
// forces and reactions included. One core, no output.
//
//   machine_step [batches]             best of so many (50) short batches of steps, processor time
//   machine_step steps N               N steps of the coupled rig and nothing else, for a profiler

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <utility>

#include "libmbd/joints/revolute.hpp"
#include "tests/tools/rig.hpp"

namespace {

using namespace subsoil;

/// Uniform bars of 1 m hung one on the other, thrown from the horizontal.
mbd::Model chain(int links) {
  mbd::Model m;
  for (int i = 0; i < links; ++i) {
    const int bar = m.add({.name = "bar " + std::to_string(i + 1),
                           .mass = 1,
                           .inertia = 1. / 12,
                           .pose = {0.5 + i, 0, 0},
                           .velocity = {0, 0, 0}});
    m.add("pin " + std::to_string(i + 1),
          mbd::Revolute{.body_a = bar - 1, .body_b = bar, .p_a = {i == 0 ? 0.0 : 0.5, 0}, .p_b = {-0.5, 0}});
  }
  return m;
}

struct Timing {
  double step = 0;  ///< s
  long choices = 0;
};

/// Processor time, so that a busy machine does not count.
double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A machine and what its steps are: of 0.1 ms, with the soil's wrench on a body anew before each (0: none).
struct Case {
  explicit Case(mbd::Model model, int body = 0) : machine(std::move(model)), soil_on(body) {
    body > 0 ? machine.start_from_towing_equilibrium(0.5) : machine.start_from_pose();
  }
  mbd::Machine machine;
  int soil_on;
  long steps = 0;

  void step() {
    if (soil_on > 0) {
      // As the soil of configs/1s300.yaml: some 500 N rearward, 100 N down, jumps of a few N.
      const auto jump = static_cast<double>(steps * 7919 % 13 - 6);
      machine.set_external_wrench(soil_on, -500 + jump, -100 + 0.5 * jump, 40 - 0.1 * jump);
    }
    machine.advance(1e-4);
    ++steps;
  }
};

/// Best of many short batches.
Timing time_steps(Case& c, int batch, int repetitions) {
  Timing best{1e300, 0};
  for (int i = 0; i < 10; ++i) c.step();  // the start by Runge-Kutta
  for (int r = 0; r < repetitions; ++r) {
    const double begin = processor_time();
    for (int i = 0; i < batch; ++i) c.step();
    best.step = std::min(best.step, (processor_time() - begin) / batch);
  }
  best.choices = c.machine.partition_choices();
  return best;
}

void print(const std::string& name, const mbd::Machine& machine, const Timing& t) {
  const int links = machine.system().bodies() - 1;
  std::printf("%-12s %6d bodies %6d coordinates %6d constraints  %9.3f us/step  %7.3f us/step and body  %3ld choices\n",
              name.c_str(), links, machine.system().coordinates(), machine.system().equations(), 1e6 * t.step,
              1e6 * t.step / links, t.choices);
}

}  // namespace

int main(int argc, char** argv) {
  const auto rig = test::make_rig({.raise = 0.125});
  if (argc > 2 && std::string(argv[1]) == "steps") {
    Case c(rig.model, rig.shovel);
    for (long left = std::atol(argv[2]); left > 0; --left) c.step();
    return 0;
  }
  const int repetitions = argc > 1 ? std::max(1, std::atoi(argv[1])) : 50;
  const auto measure = [&](const std::string& name, Case c, int batch) {
    print(name, c.machine, time_steps(c, batch, repetitions));
  };
  measure("rig 1S-300", Case(test::make_rig({.raise = 0.125, .rearward = 500, .downward = 100}).model), 200);
  measure("coupled rig", Case(rig.model, rig.shovel), 200);
  for (const int links : {10, 30, 100, 300}) measure("chain", Case(chain(links)), std::max(4, 1000 / links));
}
