#include "libsim/run/inputs.hpp"

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <utility>

#include "libdem/base/archive.hpp"
#include "libmbd/controllers.hpp"
#include "libmbd/elements.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

void Input::Piece::archive(Archive& a) { a("from", from)("value", value)("rate", rate)("once", once)("twice", twice); }

void Input::set(double t, double value, double rate) {
  // The integrals are those of what was in force until now.
  const Piece next{t, value, rate, integral(t), double_integral(t)};
  if (!set_) first_ = t;
  before_ = set_ ? last_ : next;
  last_ = next, set_ = true;
}

void Input::archive(Archive& a) { a("set", set_)("first", first_)("last", last_)("before", before_); }

const Input::Piece* Input::piece_at(double t) const {
  if (!set_ || t < first_) return nullptr;
  return t < last_.from ? &before_ : &last_;
}

double Input::value(double t) const {
  const Piece* const p = piece_at(t);
  return p != nullptr ? p->value + p->rate * (t - p->from) : given_.value(t);
}
double Input::first(double t) const {
  const Piece* const p = piece_at(t);
  return p != nullptr ? p->rate : given_.first(t);
}
double Input::second(double t) const { return piece_at(t) != nullptr ? 0 : given_.second(t); }
double Input::integral(double t) const {
  const Piece* const p = t > first_ ? piece_at(t) : nullptr;  // integrals do not jump: at the first set() either holds
  if (p == nullptr) return given_.integral(t);
  const double s = t - p->from;
  return p->once + s * (p->value + s * p->rate / 2);
}
double Input::double_integral(double t) const {
  const Piece* const p = t > first_ ? piece_at(t) : nullptr;
  if (p == nullptr) return given_.double_integral(t);
  const double s = t - p->from;
  return p->twice + s * (p->once + s * (p->value / 2 + s * p->rate / 6));
}

namespace {

using Take = std::function<void(const std::string& name, const std::string& unit, mbd::Function& function)>;

/// The functions of time of an element, by the keys and units of its description.
template <class Element>
void functions_of(Element& e, const std::string& path, const Take& take) {
  const auto one = [&](const char* key, const char* unit, mbd::Function& f) {
    if (f.is_set()) take(path + "." + key, unit, f);
  };
  if constexpr (requires { e.motion; }) {
    const std::string unit = e.angular() ? "rad" : "m";
    one("position", unit.c_str(), e.motion.position);
    one("velocity", (unit + "/s").c_str(), e.motion.velocity);
    one("acceleration", (unit + "/s^2").c_str(), e.motion.acceleration);
  }
  if constexpr (requires { e.set_point; }) {
    one("set point", e.measured_unit.c_str(), e.set_point);
    one("bias", e.output_unit.c_str(), e.bias);
  }
  if constexpr (requires { e.fx; })
    one("along x", "N", e.fx), one("along y", "N", e.fy), one("moment", "N m", e.moment);
  if constexpr (requires { e.share; })
    if constexpr (std::is_same_v<decltype(e.share), mbd::Function>) one("share", "1", e.share);
  if constexpr (requires { e.voltage; }) one("voltage", "V", e.voltage);
  if constexpr (requires { e.valve; }) one("valve", "1", e.valve), one("flow given", "m^3/s", e.flow);
  if constexpr (std::is_same_v<Element, mbd::RotationalSpringDamper>) one("actuator torque", "N m", e.actuator);
  if constexpr (std::is_same_v<Element, mbd::SpringDamper>) one("actuator force", "N", e.actuator);
  if constexpr (requires { e.wind_x; }) one("wind along x", "m/s", e.wind_x), one("wind along y", "m/s", e.wind_y);
}

void functions_of(Scenario& s, const Take& take) {
  if (s.machine) {
    const auto each = [&](auto& list, const char* kind) {
      for (auto& item : list)
        visit([&](auto& e) { functions_of(e, std::string("machine.") + kind + "." + item.name, take); }, item.element);
    };
    each(s.machine->drivers, "drivers");
    each(s.machine->forces, "forces");
    each(s.machine->controllers, "controllers");
  }
  for (BoundarySection& b : s.boundaries) {
    if (!b.servo) continue;
    if (b.servo->load.is_set()) take("boundaries." + b.name + ".servo.load", "N", b.servo->load);
    if (b.servo->pressure.is_set()) take("boundaries." + b.name + ".servo.pressure", "Pa", b.servo->pressure);
  }
}

}  // namespace

mbd::Function Inputs::make(const std::string& name, const std::string& unit, mbd::Function given) {
  const auto input = std::make_shared<Input>(name, unit, std::move(given));
  inputs_.push_back(input);
  mbd::ExpressionFunction f;
  f.text = "0", f.unit = unit;  // as a scenario has it that is written
  f.value_ = [input](double t) { return input->value(t); };
  f.first_ = [input](double t) { return input->first(t); };
  f.second_ = [input](double t) { return input->second(t); };
  f.integral_ = [input](double t) { return input->integral(t); };
  f.double_integral_ = [input](double t) { return input->double_integral(t); };
  return f;
}

std::vector<std::string> Inputs::available(const Loaded& loaded) {
  std::vector<std::string> out;
  Scenario copy = loaded.scenario;
  functions_of(copy, [&](const std::string& name, const std::string&, mbd::Function&) { out.push_back(name); });
  return out;
}

void Inputs::replace(Loaded& loaded, const std::vector<std::string>& names) {
  const std::vector<std::string> known = available(loaded);
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw ScenarioError("input " + name + ": the scenario gives no such function of time" + suggestion(name, known));
  functions_of(loaded.scenario, [&](const std::string& name, const std::string& unit, mbd::Function& function) {
    if (std::find(names.begin(), names.end(), name) != names.end()) function = make(name, unit, function);
  });
}

void Inputs::add_force_on(Loaded& loaded, const std::string& body) {
  std::vector<std::string> known;
  if (loaded.scenario.machine)
    for (const BodySection& b : loaded.scenario.machine->bodies) known.push_back(b.name);
  const auto found = std::find(known.begin(), known.end(), body);
  if (found == known.end())
    throw ScenarioError("force on " + body + ": the machine has no such body" + suggestion(body, known));
  mbd::AppliedForce force;
  force.body = 1 + static_cast<int>(found - known.begin());
  force.fx = make(body + ".fx", "N", 0.0), force.fy = make(body + ".fy", "N", 0.0);
  force.moment = make(body + ".moment", "N m", 0.0);
  loaded.scenario.machine->forces.push_back({"force on " + body, force});
}

Input& Inputs::at(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& input : inputs_) {
    if (input->name() == name) return *input;
    known.push_back(input->name());
  }
  throw std::invalid_argument("input " + name + ": is not among the inputs that the simulation was made with" +
                              (known.empty() ? ", which has none; name it in `inputs`" : suggestion(name, known)));
}

}  // namespace subsoil::sim
