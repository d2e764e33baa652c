#include "libmbd/system/system.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <type_traits>

#include "libmbd/system/bodies_of.hpp"
#include "libmbd/system/extent.hpp"
#include "libmbd/system/system_elements.hpp"
#include "libmbd/system/wrench.hpp"

namespace subsoil::mbd {

namespace {

/// Longest moment arm of a point about its body's centre of gravity, points on the ground do not count; or the
/// element's own length (of a link, the radius of a disk) where it has one.
template <class Element>
double characteristic_length(const Element& e) {
  double length = 0;
  if constexpr (Element::has.points) {
    const auto bodies = bodies_of(e);
    if (bodies[0] != ground) length = std::hypot(e.p_a[0], e.p_a[1]);
    if (bodies[1] != ground) length = std::max(length, std::hypot(e.p_b[0], e.p_b[1]));
  }
  if constexpr (Element::has.characteristic_length) length = std::max(length, e.characteristic_length());
  return length;
}

/// Moment arms of a joint's points, the longest of each body.
template <class Joint>
void take_arms(const Joint& j, std::vector<double>& longest) {
  if constexpr (Joint::has.points) {
    const auto take = [&](int body, const std::array<double, 2>& p) {
      double& arm = longest[static_cast<std::size_t>(body)];
      arm = std::max(arm, std::hypot(p[0], p[1]));
    };
    take(j.body_a, j.p_a), take(j.body_b, j.p_b);
  }
}

void check_finite_positive(const PartName& part, const char* what, double value, const char* unit) {
  if (!(value > 0) || !std::isfinite(value))
    refuse_model(part, std::string(": ") + what + " = " + std::to_string(value) + " " + unit +
                           ": must be in (0, inf); a planar body needs both mass and inertia");
}

}  // namespace

double Model::mass() const {
  return std::accumulate(bodies.begin(), bodies.end(), 0.0, [](double sum, const Body& b) { return sum + b.mass; });
}

double Model::weight() const { return mass() * std::hypot(gravity[0], gravity[1]); }

int Model::add(Body body) {
  bodies.push_back(std::move(body));
  return static_cast<int>(bodies.size());
}

System::ElementLists::ElementLists() : lists_(std::make_unique<Elements>()) {}
System::ElementLists::ElementLists(const ElementLists&) : ElementLists() {}
System::ElementLists::~ElementLists() = default;

System::System(Model model) : model_(std::move(model)) {
  add_followers(model_);
  check_bodies();
  check_elements();
  prepare_forces();
  number_rows();
  assign_ruts();
  attach_friction();
  attach_controllers();
  number_states();
  attach_events();
  place_elements();
  const auto n = static_cast<std::size_t>(bodies());
  states_.resize(n), anchors_.resize(n);
  wrenches_.resize(n), weights_.resize(n);
  external_.assign(n, {0, 0, 0});
  powers_.resize(model_.forces.size());
  values_.resize(model_.forces.size());
  mass_.resize(coordinates());
  for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
    const auto& b = model_.bodies[i];
    mass_.segment<3>(3 * static_cast<Eigen::Index>(i)) << b.mass, b.mass, b.inertia;
    weights_[i + 1] = {b.mass * model_.gravity[0], b.mass * model_.gravity[1]};
  }
  for (const auto& f : model_.forces) given_forces_.push_back(f.element);
  for (auto& c : model_.controllers)
    naming({PartName::Kind::controller, c.name}, [&] {
      visit(
          [&](const auto& controller) {
            for (const auto& input : controller.measured()) input->attach(*this);
          },
          c.element);
    });
  for (auto& e : model_.events)
    if (e.element.input) naming({PartName::Kind::event, e.name}, [&] { e.element.input->attach(*this); });
  settle_constraints();
  for (std::size_t i = 0; i < model_.joints.size(); ++i) given_latched_.push_back(latched_of(model_.joints[i].element));
  settle_forces(model_.start_time, start_position(), start_velocity());
}

System::~System() = default;

std::unique_ptr<System> System::copy() const {
  std::unique_ptr<System> out(new System(*this));
  out->blocks_.clear(), out->first_block_.clear();
  out->place_elements();
  return out;
}

void System::check_bodies() const {
  std::set<std::string> names{"ground"};
  if (model_.bodies.empty()) refuse_model({}, " without bodies; give at least one body with mass and inertia");
  for (const auto& b : model_.bodies) {
    if (b.name.empty()) throw ModelFault({}, "a body has no name; every body needs its own");
    const PartName part{PartName::Kind::body, b.name};
    if (!names.insert(b.name).second)
      refuse_model(part, ": the name is taken; every body needs its own (ground is the ground's)");
    check_finite_positive(part, "mass", b.mass, "kg");
    check_finite_positive(part, "inertia", b.inertia, "kg m^2");
  }
}

void System::prepare_forces() {
  const auto prepare = []<class Force>(Force& force) {
    if constexpr (Force::has.prepare) force.prepare();
  };
  for (auto& f : model_.forces) naming({PartName::Kind::force, f.name}, [&] { visit(prepare, f.element); });
}

void System::check_elements() const {
  std::set<std::string> names;
  const auto check = [&](PartName::Kind kind, const auto& named) {
    const PartName what{kind, named.name};
    if (!names.insert(named.name).second)
      refuse_model(what, ": the name is taken by another joint, driver or force; every one needs its own");
    visit(
        [&]<class Element>(const Element& element) {
          auto list = bodies_of(element);
          if constexpr (IsForce<Element>)
            if (Element::has.joint) list.clear();  // its bodies are the joint's
          for (const int body : list)
            if (body < 0 || body >= bodies())
              refuse_model(what, ": body index " + std::to_string(body) + " does not exist; there are " +
                                     std::to_string(bodies() - 1) + " bodies and the ground (0)");
          if (list.size() > 1 && list[0] == list[1])
            refuse_model(what, " connects '" + body_name(list[0]) + "' to itself; name two different bodies");
          if (list.size() > 2 && list[2] != ground && (list[2] == list[0] || list[2] == list[1]))
            refuse_model(
                what, " names '" + body_name(list[2]) + "' twice; its third body must be another one, or the ground");
          if constexpr (Element::has.check) naming(what, [&] { element.check(); });
        },
        named.element);
  };
  for (const auto& j : model_.joints) check(PartName::Kind::joint, j);
  for (const auto& d : model_.drivers) check(PartName::Kind::driver, d);
  for (const auto& f : model_.forces) check(PartName::Kind::force, f);
  for (const auto& c : model_.controllers) {
    const PartName what{PartName::Kind::controller, c.name};
    if (!names.insert(c.name).second)
      refuse_model(what, ": the name is taken by another element; every one needs its own");
    naming(what,
           [&] { visit([](const auto& controller) { controller.check(), controller.check_inputs(); }, c.element); });
    const bool at_once = visit(
        [](const auto& controller) {
          const ControllerInputs inputs = controller.measured();
          return controller.direct() &&
                 std::any_of(inputs.begin(), inputs.end(), [](const auto& input) { return input->of_solution(); });
        },
        c.element);
    if (at_once)
      refuse_model(what,
                   ": measures accelerations, reactions or forces, which its own output changes at once; give it a "
                   "sensor lag (a few ms), a sample time, or a transfer function of a lower numerator");
  }
}

void System::number_rows() {
  double length = 0;
  body_size_.assign(static_cast<std::size_t>(bodies()), 0.0);
  for (const auto& j : model_.joints) {
    joint_row_.push_back(equations());
    visit(
        [&](const auto& joint) {
          length = std::max(length, characteristic_length(joint));
          take_arms(joint, body_size_);
          for (const bool angular : joint.angular) {
            row_part_.push_back({PartName::Kind::joint, j.name});
            row_angular_.push_back(angular);
          }
        },
        j.element);
  }
  joints_end_ = equations();
  for (const auto& d : model_.drivers) {
    driver_row_.push_back(equations());
    row_part_.push_back({PartName::Kind::driver, d.name});
    row_angular_.push_back(visit([](const auto& driver) { return driver.angular(); }, d.element));
  }
  choose_length_scale(length);
}

// Joints that stand at centres of gravity, or as near as rounding or a hub of no matter is, give no length.
void System::choose_length_scale(double joints) {
  constexpr double far_less = 1e-2;
  const double mass = model_.mass();
  double inertia = 0;  // of all: a cart without mass may have any
  for (const Body& b : model_.bodies) inertia += b.inertia;
  const double gyration = mass > 0 ? std::sqrt(inertia / mass) : 0,
               extent = std::max(gyration, extent_by_forces(model_));
  length_scale_ = joints > far_less * extent ? joints : extent > 0 ? extent : 1;
  for (double& size : body_size_)
    if (!(size > 1e-3 * length_scale_)) size = length_scale_;  // its joints stand at its centre of gravity
}

void System::attach_friction() {
  multipliers_.assign(row_part_.size(), 0.0);
  for (auto& f : model_.forces) {
    auto* friction = f.element.get_if<JointFriction>();
    if (!friction) continue;
    std::string known;
    std::size_t i = 0;
    for (; i < model_.joints.size() && model_.joints[i].name != friction->joint; ++i)
      known += (i ? ", " : "") + model_.joints[i].name;
    if (i == model_.joints.size())
      refuse_model({PartName::Kind::force, f.name},
                   ": no joint '" + friction->joint + "'; there are " + (known.empty() ? "none" : known));
    try {
      visit([&](const auto& joint) { friction->attach(joint, joint_row_[i]); }, model_.joints[i].element);
    } catch (const std::invalid_argument& error) {
      refuse_model({PartName::Kind::force, f.name}, std::string(": ") + error.what());
    }
    friction_rows_.push_back(joint_row_[i]);
  }
}

void System::place_elements() {
  const auto place = [](auto& lists, auto& any, int number) {
    visit(
        [&]<class Element>(Element& element) {
          Elements::Placed<Element> placed{&element, number};
          const auto bodies = bodies_of(element);
          placed.a = bodies[0];
          if (bodies.size() > 1) placed.b = bodies[1];
          if (bodies.size() > 2) placed.c = bodies[2];
          std::get<std::vector<Elements::Placed<Element>>>(lists).push_back(placed);
        },
        any);
  };
  const auto block = [&](const auto& any, int first) {
    visit(
        [&]<class Element>(const Element& element) {
          for (int row = first; row < first + static_cast<int>(Element::rows); ++row) {
            first_block_.push_back(blocks_.size());
            for (const int body : bodies_of(element))
              if (body != ground) {
                blocks_.push_back({row, body});
                if constexpr (Element::has.pin) blocks_.back().has[row == first ? 1 : 0] = false;
              }
          }
        },
        any);
  };
  for (std::size_t i = 0; i < model_.joints.size(); ++i) {
    place(elements_->joints, model_.joints[i].element, joint_row_[i]);
    block(model_.joints[i].element, joint_row_[i]);
  }
  for (std::size_t i = 0; i < model_.drivers.size(); ++i) {
    place(elements_->drivers, model_.drivers[i].element, driver_row_[i]);
    block(model_.drivers[i].element, driver_row_[i]);
  }
  first_block_.push_back(blocks_.size());
  for (std::size_t i = 0; i < model_.forces.size(); ++i)
    place(elements_->forces, model_.forces[i].element, static_cast<int>(i));
}

void System::assign_ruts() {
  std::map<std::string, std::size_t> tracks;
  std::vector<double> spacings;
  for (auto& f : model_.forces)
    visit(
        [&]<class Force>(Force& force) {
          if constexpr (Force::has.rut) {
            const std::string key = force.track.empty() ? "wheel " + f.name : "track " + force.track;
            force.rut = tracks.emplace(key, tracks.size()).first->second;
            const double spacing = Rut::spacing_for(force.rut_size(), length_scale_);
            if (force.rut == spacings.size()) spacings.push_back(spacing);
            spacings[force.rut] = std::min(spacings[force.rut], spacing);  // the finest that presses the track
          }
        },
        f.element);
  for (const double spacing : spacings) ruts_.emplace_back(spacing);
}

int System::body_index(const std::string& name) const {
  if (name == "ground") return ground;
  for (std::size_t i = 0; i < model_.bodies.size(); ++i)
    if (model_.bodies[i].name == name) return static_cast<int>(i) + 1;
  std::string known = "ground";
  for (const auto& b : model_.bodies) known += ", " + b.name;
  throw std::invalid_argument("no body '" + name + "'; there are " + known);
}

const std::string& System::body_name(int body) const {
  static const std::string ground_name = "ground";
  return body == ground ? ground_name : model_.bodies[static_cast<std::size_t>(body - 1)].name;
}

Eigen::VectorXd System::start_position() const {
  Eigen::VectorXd q(coordinates());
  for (std::size_t i = 0; i < model_.bodies.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) q[static_cast<Eigen::Index>(3 * i + k)] = model_.bodies[i].pose[k];
  return q;
}

Eigen::VectorXd System::start_velocity() const {
  Eigen::VectorXd v(coordinates());
  for (std::size_t i = 0; i < model_.bodies.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) v[static_cast<Eigen::Index>(3 * i + k)] = model_.bodies[i].velocity[k];
  return v;
}

void System::set_position(double t, const Eigen::VectorXd& q) {
  t_ = t;
  for (int i = 1; i < bodies(); ++i) {
    const auto k = 3 * (i - 1);
    auto& b = states_[static_cast<std::size_t>(i)];
    b.r = {q[k], q[k + 1]};
    if (b.angle == q[k + 2]) continue;  // a pose is often asked for again
    b.angle = q[k + 2];
    anchors_[static_cast<std::size_t>(i)].of(b.angle, b.c, b.s);
  }
}

void System::set_velocity(const Eigen::VectorXd& velocity) {
  for (int i = 1; i < bodies(); ++i) {
    const auto k = 3 * (i - 1);
    auto& b = states_[static_cast<std::size_t>(i)];
    b.v = {velocity[k], velocity[k + 1]};
    b.omega = velocity[k + 2];
  }
}

void System::set_state(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity) {
  set_position(t, q);
  set_velocity(velocity);
}

// A block of Phi_q per body that is not the ground, in the order of place_elements().
template <System::Elements::Part part, class Element>
void System::Elements::evaluate(const System& system, const Placed<Element>& placed, SparseConstraints& out) {
  constexpr std::size_t count = Element::rows;
  const Element& element = *placed.element;
  ConstraintRows<count> rows;
  if constexpr (Element::has.third_body) {
    element.evaluate(system.body(placed.a), system.body(placed.b), system.body(placed.c), system.t_, rows);
  } else {
    element.evaluate(system.body(placed.a), system.body(placed.b), system.t_, rows);
  }
  const auto first = static_cast<std::size_t>(placed.number);
  auto* block = out.jacobian.data() + system.first_block_[first];
  for (std::size_t i = 0; i < count; ++i) {
    if constexpr (part != Part::position) out.gamma[first + i] = rows[i].gamma;
    if constexpr (part == Part::gamma) continue;
    out.phi[first + i] = rows[i].phi;
    out.phi_t[first + i] = rows[i].phi_t;
    if (placed.a != ground) *block++ = rows[i].on_a;
    if (placed.b != ground) *block++ = rows[i].on_b;
    if constexpr (Element::has.third_body)
      if (placed.c != ground) *block++ = rows[i].on_c;
  }
}

template <class Part>
void System::constraints(Part, SparseConstraints& out) const {
  if (out.jacobian.size() != blocks_.size() || out.phi.size() != row_part_.size()) {
    for (auto* list : {&out.phi, &out.gamma, &out.phi_t}) list->resize(row_part_.size());
    out.jacobian.resize(blocks_.size());
  }
  const auto evaluate = [&](const auto& placed) { Elements::evaluate<Part::value>(*this, placed, out); };
  for_each_placed(elements_->joints, evaluate);
  for_each_placed(elements_->drivers, evaluate);
  if (has_joint_events()) clear_open_rows(out);
}

void System::constraints(SparseConstraints& out) const {
  constraints(std::integral_constant<Elements::Part, Elements::Part::all>{}, out);
}
void System::constraints_of_position(SparseConstraints& out) const {
  constraints(std::integral_constant<Elements::Part, Elements::Part::position>{}, out);
}
void System::constraints_of_velocity(SparseConstraints& out) const {
  constraints(std::integral_constant<Elements::Part, Elements::Part::gamma>{}, out);
}

void System::clear_open_rows(SparseConstraints& out) const {
  for (std::size_t i = 0; i < open_.size(); ++i) {
    if (!open_[i]) continue;
    const int end = i + 1 < joint_row_.size() ? joint_row_[i + 1] : joints_end_;
    for (int row = joint_row_[i]; row < end; ++row) {
      const auto r = static_cast<std::size_t>(row);
      out.phi[r] = out.gamma[r] = out.phi_t[r] = 0;
      for (std::size_t b = first_block_[r]; b < first_block_[r + 1]; ++b) out.jacobian[b] = {};
    }
  }
}

void System::constraints(Constraints& out) const {
  constraints(out.sparse);
  write_out(*this, out);
}

void write_out(const System& system, Constraints& c) {
  c.jacobian.setZero(system.equations(), system.coordinates());
  for (std::size_t i = 0; i < system.blocks().size(); ++i)
    for (int k = 0; k < 3; ++k)
      c.jacobian(system.blocks()[i].row, 3 * (system.blocks()[i].body - 1) + k) =
          c.sparse.jacobian[i][static_cast<std::size_t>(k)];
  const auto vector = [](const std::vector<double>& v) {
    return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
  };
  c.phi = vector(c.sparse.phi), c.gamma = vector(c.sparse.gamma), c.phi_t = vector(c.sparse.phi_t);
}

void System::loads(Eigen::VectorXd& out) {
  for (std::size_t i = 1; i < wrenches_.size(); ++i) {
    wrenches_[i] = {external_[i][0] + weights_[i].x, external_[i][1] + weights_[i].y, external_[i][2]};
  }
  Loads sink(wrenches_);
  if (!signals_.empty()) take_signals();
  const Scene now = scene();
  for_each_placed(elements_->forces, [&](const auto& placed) {
    const auto i = static_cast<std::size_t>(placed.number);
    powers_[i] = placed.element->evaluate(now, sink, values_[i]);
  });
  for (std::size_t i = 1; i < wrenches_.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) out[static_cast<Eigen::Index>(3 * (i - 1) + k)] = wrenches_[i][k];
}

Eigen::Index System::flow_count() const {
  return static_cast<Eigen::Index>(2 * model_.forces.size() + model_.drivers.size());
}

double System::kinetic() const {
  double sum = 0;
  for (std::size_t i = 1; i < states_.size(); ++i) {
    const double* const m = mass_.data() + 3 * (i - 1);
    const double omega = states_[i].omega;
    sum += 0.5 * m[0] * dot(states_[i].v, states_[i].v) + 0.5 * m[2] * omega * omega;
  }
  return sum;
}

double System::potential() const {
  double sum = 0;
  for (std::size_t i = 1; i < states_.size(); ++i) sum -= dot(weights_[i], states_[i].r);
  return sum;
}

double System::stored() const {
  double sum = 0;
  for (const auto& p : powers_) sum += p.stored;
  return sum;
}

void System::set_external_wrench(int body, double fx, double fy, double mz) {
  if (body <= ground || body >= bodies())
    throw std::invalid_argument("external wrench on body " + std::to_string(body) + ": must be one of 1 to " +
                                std::to_string(bodies() - 1));
  const std::array<double, 3> w{fx, fy, mz};
  auto& old = external_[static_cast<std::size_t>(body)];
  if (w != old) ++wrench_changes_, old = w;
}

double System::external_work(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
  double work = 0;
  for (int i = 1; i < bodies(); ++i)
    for (int k = 0; k < 3; ++k) {
      const auto c = 3 * (i - 1) + k;
      work += external_wrench(i)[static_cast<std::size_t>(k)] * (to[c] - from[c]);
    }
  return work;
}

void System::settle_constraints() {
  set_state(model_.start_time, start_position(), start_velocity());
  const auto settle = [&]<class Element>(Element& element) {
    if constexpr (!Element::has.initialise_from_pose) {
      return;
    } else if constexpr (Element::has.third_body) {
      element.initialise_from_pose(body(element.body_a), body(element.body_b), body(element.body_c), t_);
    } else {
      const auto bodies = bodies_of(element);
      element.initialise_from_pose(body(bodies[0]), body(bodies[1]), t_);
    }
  };
  for (auto& j : model_.joints) naming({PartName::Kind::joint, j.name}, [&] { visit(settle, j.element); });
  for (auto& d : model_.drivers) naming({PartName::Kind::driver, d.name}, [&] { visit(settle, d.element); });
}

void System::settle_forces(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity) {
  set_state(t, q, velocity);
  for (std::size_t i = 0; i < given_forces_.size(); ++i) {
    visit(
        [&]<class Force>(Force& force) {
          force = given_forces_[i].get<Force>();  // in its place: the lists by type point to it
          if constexpr (Force::has.initialise_from_pose) remembering(force).initialise_from_pose(scene());
        },
        model_.forces[i].element);
  }
  start_states_.clear(), start_grips_.clear();
  begin_states();
}

void System::restart_traces() {
  for (auto& f : model_.forces)
    visit(
        [&]<class Force>(Force& force) {
          if constexpr (Force::has.trace) remembering(force).begin_trace(scene());
        },
        f.element);
  if (keeps_grips()) set_grips(start_grips_);
}

Eigen::VectorXd System::towing_velocity(double speed) const {
  Eigen::VectorXd velocity = Eigen::VectorXd::Zero(coordinates());
  for (int i = 0; i < coordinates(); i += 3) velocity[i] = speed;
  for (const auto& f : model_.forces)
    visit(
        [&]<class Force>(const Force& force) {
          if constexpr (Force::has.towing_spin) velocity[3 * (force.body - 1) + 2] = force.towing_spin(speed);
        },
        f.element);
  return velocity;
}

std::vector<char> System::towed_spins() const {
  std::vector<char> given(model_.bodies.size(), 0);
  for (const auto& f : model_.forces)
    visit(
        [&]<class Force>(const Force& force) {
          if constexpr (Force::has.towing_spin) given[static_cast<std::size_t>(force.body - 1)] = 1;
        },
        f.element);
  return given;
}

bool System::commit(Eigen::VectorXd& lost) {
  bool any = false;
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.rut) {
      const double at_once = placed.element->commit(scene(), ruts_);
      lost[placed.number] += at_once;
      any = any || at_once != 0;
    }
  });
  return any;
}

System::Memory System::memory() const {
  Memory out{.external = external_, .samplers = {}, .elements = {}, .ruts = ruts_};
  if (has_instants_) out.samplers = samplers_;
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.trace) {
      const auto m = remembering(*placed.element).memory();
      out.elements.insert(out.elements.end(), m.begin(), m.end());
    }
  });
  for (const auto& e : model_.events) {
    const auto m = latched_of(model_.joints[e.element.index].element);
    out.elements.insert(out.elements.end(), m.begin(), m.end());
  }
  return out;
}

void System::set_memory(const Memory& memory) {
  external_ = memory.external, ruts_ = memory.ruts;
  if (has_instants_) samplers_ = memory.samplers;
  auto next = memory.elements.begin();
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.trace) {
      auto m = remembering(*placed.element).memory();
      for (auto& value : m) value = *next++;
      remembering(*placed.element).set_memory(m);
    }
  });
  for (const auto& e : model_.events) {
    std::array<double, 3> m{};
    for (double& value : m) value = *next++;
    set_latched_of(model_.joints[e.element.index].element, m);
  }
}

System::Restart System::save() const {
  Restart out{.drivers = {}, .memory = memory(), .passed = passed_, .open = open_};
  for (Sampler& s : out.memory.samplers) s.forget_before();
  for (const auto& d : model_.drivers)
    visit(
        [&](const auto& driver) {
          const auto& m = driver.motion;
          out.drivers.push_back({m.start, m.start_rate, m.start_time});
        },
        d.element);
  return out;
}

void System::set_motion(std::size_t driver, const Motion& motion) {
  visit(
      [&](auto& d) {
        const Motion before = d.motion;
        d.motion = motion;
        d.motion.start = before.start, d.motion.start_rate = before.start_rate, d.motion.start_time = before.start_time;
      },
      model_.drivers[driver].element);
}

void System::restore(const Restart& from) {
  const Memory own = memory();
  const Memory& to = from.memory;
  const auto check = [](std::size_t size, std::size_t expected, const char* what) {
    if (size != expected)
      throw std::invalid_argument("restart: the state has " + std::to_string(size) + " " + what +
                                  ", this machine has " + std::to_string(expected));
  };
  check(from.drivers.size(), model_.drivers.size(), "drivers");
  check(to.external.size(), own.external.size(), "external wrenches");
  check(to.samplers.size(), own.samplers.size(), "sampled controllers");
  check(to.elements.size(), own.elements.size(), "numbers that forces and joints remember");
  check(to.ruts.size(), own.ruts.size(), "ruts");
  check(from.passed.size(), passed_.size(), "events");
  check(from.open.size(), open_.size(), "joints that may open");
  for (std::size_t i = 0; i < from.drivers.size(); ++i)
    visit(
        [&](auto& driver) {
          auto& m = driver.motion;
          m.start = from.drivers[i].value, m.start_rate = from.drivers[i].rate, m.start_time = from.drivers[i].time;
        },
        model_.drivers[i].element);
  set_memory(to);
  passed_ = from.passed, open_ = from.open;
  ++wrench_changes_;
}

}  // namespace subsoil::mbd
