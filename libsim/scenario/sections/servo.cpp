#include "libsim/scenario/sections/servo.hpp"

#include "libsim/scenario/checks.hpp"

namespace subsoil::sim {

void describe(Fields& v, ServoSection& s) {
  v.optional_function("load", s.load, "N", "with which it presses, over time");
  v.optional_function(
      "pressure", s.pressure, "Pa",
      "in place of `load`: times the area that the surface shows along `along`, between periodic sides");
  v.vector("along", s.along, "1", "direction of the load and of the line on which the boundary moves; any length");
  v.quantity("speed limit", s.limit, "m/s", "(0, inf)", "it moves no faster, also where nothing resists");
  v.quantity("gain", s.gain, "m/(N s)", "(0, inf)",
             "K_p: speed over what is missing of the load, so that the plate is pushed through a dashpot 1/K_p; left "
             "out: the speed limit over the largest load");
  v.quantity("lag", s.lag, "s", "[0, inf)",
             "T of the speed behind what the gains ask for, as of a plate of mass T/K_p; left out: 20 soil steps");
  v.quantity("integral gain", s.integral, "m/(N s^2)", "[0, inf)",
             "K_i: takes away what a load that changes leaves missing; waits while the speed is limited");
  v.quantity("rate gain", s.rate, "m/N", "[0, inf)", "K_d: on the rate of what is missing");
}

void check_servo(Checks& checks, const std::string& path, const ServoSection& servo) {
  if (servo.load.is_set() == servo.pressure.is_set())
    checks.refuse(path, servo.load.is_set() ? "has `load` and `pressure`; give one of them"
                                            : "needs a `load` (N) or a `pressure` (Pa)");
  checks.direction(path + ".along", servo.along);
}

}  // namespace subsoil::sim
