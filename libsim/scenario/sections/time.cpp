#include "libsim/scenario/sections/time.hpp"

#include <fmt/format.h>

#include "libmbd/controllers/pid.hpp"
#include "libmbd/integrators/events.hpp"
#include "libsim/base/input_limits.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

void describe(Fields& v, MachineTime& t) {
  v.choice(
      "integrator", t.integrator,
      {{"auto", IntegratorWord::automatic},
       {"adams-moulton", IntegratorWord::adams_moulton},
       {"cvode", IntegratorWord::cvode},
       {"ida", IntegratorWord::ida}},
      "auto: cvode for a machine alone, ida where it has beams; with soil adams-moulton, cvode where it has hydraulic "
      "cylinders; adams-moulton where `step` or `order` is given. adams-moulton: fixed step on partitioned "
      "coordinates, "
      "its error monitored; cvode: SUNDIALS CVODE on the same, steps and orders of its own, Adams or where the motion "
      "is stiff backward differences; ida: SUNDIALS IDA on the whole system");
  v.count("order", t.order, "[1, 6]", "of adams-moulton; left out: 4, with beams 2, which is the most there");
  v.quantity("rtol", t.rtol, "1", "(0, 0.1]",
             "relative tolerance of cvode and ida; left out: 1e-12 of cvode, 1e-8 of ida");
  v.quantity("atol", t.atol, "1", "(0, 0.1]",
             "absolute tolerance of cvode and ida, in m, rad, m/s and rad/s; left out: 1e-12 of cvode, 1e-10 of ida");
  v.choice("formulation", t.formulation,
           {{"stabilised index 2", mbd::IdaFormulation::stabilised_index_2}, {"index 1", mbd::IdaFormulation::index_1}},
           "equations of ida: constraints on position and velocity level, or on the level of accelerations");
  v.flag("locate events", t.locate_events,
         "contacts that close or open are located in time and the integration begins anew there; no: steps pass over "
         "them");
  v.count("soil steps per machine step", t.soil_steps, "[1, 1000]", "the machine step with soil is so many soil steps");
  v.quantity("step", t.step, "s", "(0, inf)",
             "machine step without soil, fixed, of cvode and ida their output interval; left out: steps of the "
             "integrator's own, for adams-moulton 1 ms");
}

void describe(Fields& v, StopSection& s) {
  v.text("column", s.column, "a column of the series, a monitor or a measure");
  v.level("above", s.above, "ends the run where the column comes above this value, given with the column's unit: 5 kN");
  v.level("below", s.below, "the same where it comes below; one of both");
  v.quantity("for", s.held, "s", "(0, inf)", "how long it must stay there without a break; left out: not at all");
}

void describe(Fields& v, Time& t) {
  v.derived("end", t.end, "s", "(0, inf)", "simulated time; needed by dynamics and kinematics");
  v.quantity_or("soil step", t.soil_step, "auto", "s", "(0, inf)",
                "auto: the smaller of `safety` times the stable step, from the stiffest contact, and the accurate one, "
                "by `accuracy`; a step above the stable limit is refused");
  v.quantity("safety", t.safety, "1", "(0, 1)", "the automatic step over the stable limit");
  v.quantity("accuracy", t.accuracy, "1", "(0, 1]",
             "error of the restitution of an impact that the automatic step allows, at the speed at which bodies may "
             "meet; a contact gets 0.4/accuracy steps at least. Large for beds that only creep: stability alone");
  v.choice("coupling", t.coupling, {{"explicit", CouplingWord::once}, {"iterated", CouplingWord::iterated}},
           "explicit: the soil moves the machine once per machine step; iterated: both repeat the step until the "
           "machine ends where the soil took it to end, for bodies that are light against stiff soil");
  v.quantity("coupling tolerance", t.coupling_tolerance, "m", "(0, 0.001]",
             "of iterated: how far surfaces may end from where the soil took them to end");
  v.count("coupling iterations", t.coupling_iterations, "[2, 1000]",
          "of iterated: at most so many per machine step; a step that does not agree by then is counted and the run "
          "warns");
  v.section("machine", t.machine, "integration of the machine");
  v.named("stop when", t.stop_when,
          "conditions that end the run before `end`, in order and with exit code 0, by name: {stuck: {column: pull, "
          "above: 20 kN, for: 0.1 s}}; the summary names the one that did");
  v.count("threads", t.threads, "[0, 1024]",
          "0: one per 1,000 spheres, at most as many as there are; results do not depend on it");
}

namespace {

struct TimeChecks : Checks {
  const Scenario& s;

  void time() {
    if (s.runs_in_time() && !places.contains("time.end")) refuse("time.end", "is missing: simulated time, in s");
    if (s.analysis != Analysis::dynamics && (s.has_bed() || !s.machine)) {
      refuse("analysis", analysis_names[static_cast<std::size_t>(s.analysis)],
             "looks at a machine without soil and boundaries; take `dynamics`, or leave soil and boundaries out");
    }
    if (s.machine && (s.analysis == Analysis::equilibrium || s.analysis == Analysis::modes))
      for (const NamedController& c : s.machine->controllers)
        if (const auto* pid = c.element.get_if<mbd::PidController>(); pid != nullptr && pid->sampled())
          refuse("machine.controllers." + c.name + ".sample time",
                 std::string(analysis_names[static_cast<std::size_t>(s.analysis)]) +
                     " is of continuous equations, a sampled controller acts from instant to instant; leave the sample "
                     "time out, or take `analysis: dynamics`");
    if (s.machine && !s.time.machine.locate_events)
      for (const NamedForce& f : s.machine->forces)
        if (mbd::needs_events(f.element))
          refuse("time.machine.locate events", "no",
                 "cannot be with `stick stiffness` or `restitution` of " + f.name +
                     ": that it sticks, slides or begins to touch are events; leave out one of the two");
    if (s.soil && s.machine && s.time.machine.step) {
      refuse("time.machine.step",
             "has no effect with soil, where it is the soil step times `soil steps per machine step`");
    }
    if (s.time.machine.step) steps(*s.time.machine.step);
    for (const StopSection& stop : s.time.stop_when) {
      const std::string path = "time.stop when." + stop.name;
      if (stop.column.empty()) refuse(path + ".column", "is missing: a column of the series, such as soil.draft");
      if (stop.above.empty() == stop.below.empty())
        refuse(path, "needs either `above` or `below`, with the column's unit; for a range give two conditions");
    }
    if (!s.soil && s.time.soil_step) refuse("time.soil step", "has no effect without soil; leave it out");
  }

  /// Counted before the first one.
  void steps(double step) {
    const auto most = static_cast<double>(input_limits().steps);
    const double count = s.time.end / step;
    if (count > most)
      refuse("time.machine.step", fmt::format("{} s", step),
             fmt::format("makes {:.3g} steps until {} s; at most {:.0e}: leave it out for a step by the error, or make "
                         "it longer",
                         count, s.time.end, most));
  }
};

}  // namespace

void check_time(Checks& checks, const Scenario& s) { TimeChecks{checks, s}.time(); }

}  // namespace subsoil::sim
