// machine_step: how fast a step of the machine is: the rig 1S-300 and pendulum chains, Adams-Moulton of order 4 (two
// evaluations per step), forces and reactions included. One core, no output.
//
//   machine_step [batches]     best of so many (50) short batches of steps, processor time

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

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

/// Best of many short batches.
Timing time_steps(mbd::Machine& machine, double h, int batch, int repetitions) {
  Timing best{1e300, 0};
  for (int i = 0; i < 10; ++i) machine.advance(h);  // the start by Runge-Kutta
  for (int r = 0; r < repetitions; ++r) {
    const double begin = processor_time();
    for (int i = 0; i < batch; ++i) machine.advance(h);
    best.step = std::min(best.step, (processor_time() - begin) / batch);
  }
  best.choices = machine.partition_choices();
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
  const int repetitions = argc > 1 ? std::max(1, std::atoi(argv[1])) : 50;
  {
    const auto rig = test::make_rig({.raise = 0.125, .rearward = 500, .downward = 100});
    mbd::Machine machine(rig.model);
    machine.start_from_pose();
    const Timing t = time_steps(machine, 1e-4, 200, repetitions);
    print("rig 1S-300", machine, t);
  }
  for (const int links : {10, 30, 100, 300}) {
    mbd::Machine machine(chain(links));
    machine.start_from_pose();
    print("chain", machine, time_steps(machine, 1e-4, std::max(4, 1000 / links), repetitions));
  }
}
