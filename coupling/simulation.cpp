#include "coupling/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "coupling/quasi_newton.hpp"
#include "libdem/base/small_rotation.hpp"

namespace subsoil::coupling {

dem::Pose pose_of(const mbd::BodyState& body) {
  return {{body.r.x, body.r.y, 0}, {std::cos(body.angle / 2), 0, 0, std::sin(body.angle / 2)}};
}

Simulation::Simulation(dem::Bed* bed, mbd::Machine* machine, std::vector<BodySurface> surfaces,
                       std::vector<GivenMotion> motions, SimulationOptions options)
    : bed_(bed),
      machine_(machine),
      surfaces_(std::move(surfaces)),
      motions_(std::move(motions)),
      options_(options),
      servos_(motions_.size()) {
  if (bed_ == nullptr && machine_ == nullptr) throw std::invalid_argument("a simulation needs soil or a machine");
  if (bed_ != nullptr && !(options_.soil_step > 0)) throw std::invalid_argument("the soil step must be positive");
  if (bed_ == nullptr && !(options_.machine_step > 0)) throw std::invalid_argument("the machine step must be positive");
  if (options_.soil_steps < 1) throw std::invalid_argument("soil steps per machine step: at least 1");
  const std::size_t bodies = machine_ != nullptr ? static_cast<std::size_t>(machine_->system().bodies()) : 1;
  soil_on_body_.resize(bodies);
  window_.resize(bodies);
  acceleration_.resize(bodies);
  for (const BodySurface& s : surfaces_) {
    if (bed_ == nullptr) break;
    const double reach = dem::bounds(bed_->boundary(s.boundary).shape).farthest(dem::Vec3{});
    const double arm = std::isfinite(reach) ? reach : 1;  // a plane has no end
    const auto known = std::find(coupled_.begin(), coupled_.end(), s.body);
    if (known == coupled_.end())
      coupled_.push_back(s.body), arm_.push_back(arm);
    else
      arm_[static_cast<std::size_t>(known - coupled_.begin())] =
          std::max(arm_[static_cast<std::size_t>(known - coupled_.begin())], arm);
  }
  starts_.resize(bodies), z_.resize(bodies);
  time_ = bed_ != nullptr ? bed_->time() : machine_->time();
  take_accelerations();
  place_surfaces();
}

double Simulation::time() const { return time_; }

dem::Pose Simulation::surface_pose(int boundary) const {
  for (const BodySurface& s : surfaces_)
    if (s.boundary == boundary) return pose_of(body(s.body));
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (motions_[i].boundary == boundary) return pose_at(i, time_);
  return bed_->boundary(boundary).pose;
}

/// Of now; of a servo also shortly after, as it goes.
dem::Pose Simulation::pose_at(std::size_t motion, double time) const {
  const GivenMotion& m = motions_[motion];
  dem::Pose pose = m.pose(time);
  if (m.servo) {
    const ServoState& s = servos_[motion];
    pose.position += m.servo->along * (s.travel + s.velocity * (time - time_));
  }
  return pose;
}

/// Forces are those of t_n, poses become those of t_{n+1}.
void Simulation::advance_servos() {
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (motions_[i].servo)
      servos_[i].advance(*motions_[i].servo, bed_->boundary(motions_[i].boundary).wrench.force, time_,
                         options_.soil_step);
}

mbd::BodyState Simulation::body(int body) const {
  const mbd::BodyState& now = machine_->body(body);
  if (in_window_ == 0) return now;
  if (iterates()) return on_path(static_cast<std::size_t>(body), in_window_ * options_.soil_step);
  const auto& a = acceleration_[static_cast<std::size_t>(body)];
  const double t = in_window_ * options_.soil_step, q = 0.5 * t * t;
  return {{now.r.x + now.v.x * t + a[0] * q, now.r.y + now.v.y * t + a[1] * q},
          now.angle + now.omega * t + a[2] * q,
          {now.v.x + a[0] * t, now.v.y + a[1] * t},
          now.omega + a[2] * t};
}

void Simulation::place(dem::Boundary& boundary, const dem::Pose& pose, const dem::Vec3& velocity,
                       const dem::Vec3& angular_velocity) {
  if (stepped_) {
    // What the surface really did since the last step; its own velocity only tells the first step.
    const double dt = options_.soil_step;
    boundary.velocity = (pose.position - boundary.pose.position) * (1 / dt);
    boundary.angular_velocity = dem::small_rotation(boundary.pose.attitude, pose.attitude, dt);
  } else {
    boundary.velocity = velocity;
    boundary.angular_velocity = angular_velocity;
    boundary.pose_before = pose;
  }
  boundary.pose = pose;
}

void Simulation::place_surfaces() {
  if (bed_ == nullptr) return;
  for (const BodySurface& s : surfaces_) {
    const mbd::BodyState on = body(s.body);
    place(bed_->boundary(s.boundary), pose_of(on), {on.v.x, on.v.y, 0}, {0, 0, on.omega});
  }
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    dem::Boundary& b = bed_->boundary(motions_[i].boundary);
    if (stepped_) {
      place(b, pose_at(i, time_), {}, {});
      continue;
    }
    // Velocity at the start itself, from what comes after: before it a motion may have stood still. With p at 0, dt/2
    // and dt, p' = (4 p_1 - 3 p_0 - p_2)/dt to second order.
    const double dt = options_.soil_step;
    const dem::Pose now = pose_at(i, time_), half = pose_at(i, time_ + 0.5 * dt), whole = pose_at(i, time_ + dt);
    const auto moved = [&](const dem::Pose& to) { return to.position - now.position; };
    const auto turned = [&](const dem::Pose& to) { return dem::small_rotation(now.attitude, to.attitude, 1); };
    place(b, now, (4.0 * moved(half) - moved(whole)) * (1 / dt), (4.0 * turned(half) - turned(whole)) * (1 / dt));
  }
}

void Simulation::take_accelerations() {
  if (machine_ == nullptr) return;
  const auto& a = machine_->integrator().state().acceleration;
  for (std::size_t i = 1; i < acceleration_.size(); ++i)
    for (std::size_t d = 0; d < 3; ++d) acceleration_[i][d] = a(static_cast<Eigen::Index>(3 * (i - 1) + d));
}

void Simulation::gather() {
  for (dem::Wrench& w : soil_on_body_) w = {};
  for (const BodySurface& s : surfaces_) {
    const dem::Boundary& b = bed_->boundary(s.boundary);
    // The window's mean is about the centre of mass where it is; a body's own origin is that centre.
    soil_on_body_[static_cast<std::size_t>(s.body)] += b.wrench;
  }
}

/// Where all bodies stand at t after the window's start.
mbd::BodyState Simulation::on_path(std::size_t body, double t) const {
  const mbd::BodyState& from = starts_[body];
  const double window = options_.soil_step * options_.soil_steps, share = t / window;
  const double x = z_[body][0] - from.r.x, y = z_[body][1] - from.r.y, angle = z_[body][2] - from.angle;
  return {{from.r.x + share * x, from.r.y + share * y},
          from.angle + share * angle,
          {x / window, y / window},
          angle / window};
}

/// Of the coupled bodies as the machine has them, m; angles times the arm.
Eigen::VectorXd Simulation::ends() const {
  Eigen::VectorXd out(3 * static_cast<Eigen::Index>(coupled_.size()));
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    const mbd::BodyState& at = machine_->body(coupled_[k]);
    out.segment<3>(3 * static_cast<Eigen::Index>(k)) << at.r.x, at.r.y, arm_[k] * at.angle;
  }
  return out;
}

/// The mean wrench of a window whose surfaces go to z; the bed stands behind the first step, and again afterwards.
void Simulation::repeat_window() {
  const int n = options_.soil_steps;
  const std::vector<dem::Wrench> first = soil_on_body_;
  const std::vector<ServoState> servos = servos_;
  for (std::size_t i = 0; i < window_.size(); ++i) window_[i] = first[i] * (0.5 / n);
  for (in_window_ = 1; in_window_ <= n; ++in_window_) {
    place_surfaces();
    bed_->step(options_.soil_step);
    advance_servos();
    time_ = bed_->time();
    gather();
    for (std::size_t i = 0; i < window_.size(); ++i)
      window_[i] += soil_on_body_[i] * ((in_window_ < n ? 1.0 : 0.5) / n);
  }
  in_window_ = 0;
  bed_->restore(checkpoint_);
  time_ = bed_->time();
  servos_ = servos, soil_on_body_ = first;
}

/// After the first soil step of a window: where the machine ends and the mean wrench that moves it there.
void Simulation::agree() {
  const double window = options_.soil_step * options_.soil_steps;
  for (std::size_t b = 1; b < starts_.size(); ++b) {
    starts_[b] = machine_->body(static_cast<int>(b));
    const mbd::BodyState& s = starts_[b];
    const auto& a = acceleration_[b];
    const double q = 0.5 * window * window;
    z_[b] = {s.r.x + s.v.x * window + a[0] * q, s.r.y + s.v.y * window + a[1] * q,
             s.angle + s.omega * window + a[2] * q};
  }
  bed_->save(checkpoint_);
  const mbd::Snapshot machine = machine_->snapshot();
  Eigen::VectorXd start(3 * static_cast<Eigen::Index>(coupled_.size()));
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    const auto& z = z_[static_cast<std::size_t>(coupled_[k])];
    start.segment<3>(3 * static_cast<Eigen::Index>(k)) << z[0], z[1], arm_[k] * z[2];
  }
  QuasiNewton solver(std::move(start));
  double residual = std::numeric_limits<double>::infinity(), least = residual;
  std::vector<dem::Wrench> best;
  ++exchange_.windows;
  for (int count = 1; count <= options_.most_iterations && residual > options_.tolerance; ++count) {
    for (std::size_t k = 0; k < coupled_.size(); ++k)
      for (std::size_t d = 0; d < 3; ++d)
        z_[static_cast<std::size_t>(coupled_[k])][d] =
            solver.at()(static_cast<Eigen::Index>(3 * k + d)) / (d == 2 ? arm_[k] : 1);
    repeat_window();
    ++exchange_.evaluations;
    if (count > 1) machine_->restore(machine);
    hand_over();
    machine_->advance(window);
    const Eigen::VectorXd reached = ends();
    residual = (reached - solver.at()).lpNorm<Eigen::Infinity>();
    if (!(residual >= least)) least = residual, best = window_;
    solver.take(reached);
  }
  advanced_ = residual <= options_.tolerance;
  if (!advanced_) {
    ++exchange_.open, exchange_.widest = std::max(exchange_.widest, least);
    window_ = best;
    machine_->restore(machine);
    hand_over();
    machine_->advance(window);
  }
  for (std::size_t b = 1; b < z_.size(); ++b) {
    const mbd::BodyState& at = machine_->body(static_cast<int>(b));
    z_[b] = {at.r.x, at.r.y, at.angle};
  }
  // Inside a window the machine stands at its start, as rows and states expect.
  advanced_ = options_.soil_steps == 1;
  if (!advanced_) machine_->restore(machine);
}

void Simulation::hand_over() {
  for (const BodySurface& s : surfaces_) {
    const dem::Wrench& w = window_[static_cast<std::size_t>(s.body)];
    machine_->set_external_wrench(s.body, w.force.x, w.force.y, w.moment.z);
  }
}

void Simulation::advance_machine() {
  hand_over();
  if (std::exchange(advanced_, false)) {
    // by agree()
  } else if (bed_ != nullptr) {
    machine_->advance(options_.soil_step * options_.soil_steps);
  } else {
    // A remainder of rounding is no step of its own: the step before takes it.
    const double rest = end_ - machine_->time(), h = options_.machine_step;
    machine_->advance(rest < h * (1 + 1e-6) && rest > 0 ? rest : h);
  }
  take_accelerations();
  for (dem::Wrench& w : window_) w = {};
}

void Simulation::step(const dem::Bed::Request& request) {
  if (bed_ == nullptr) {
    advance_machine();
    time_ = machine_->time();
    return;
  }
  const auto work = [&] { return machine_ != nullptr ? machine_->integrator().flows().external_work : 0.0; };
  work_on_machine_ = work();
  place_surfaces();
  bed_->step(options_.soil_step, request);
  stepped_ = true;
  advance_servos();  // by the load at t_n
  time_ = bed_->time();
  gather();
  if (!iterates())
    for (std::size_t i = 0; i < window_.size(); ++i) window_[i] += soil_on_body_[i] * (1.0 / options_.soil_steps);
  else if (in_window_ == 0)
    agree();
  if (++in_window_ < options_.soil_steps) return;
  in_window_ = 0;
  if (machine_ != nullptr) advance_machine();
  const double steps = options_.soil_steps;  // the machine has passed the step's end: back to its begin
  work_on_machine_ = std::lerp(work(), *work_on_machine_, 1 / steps);
}

void Simulation::step_to(double time) {
  const double rest = time - machine_->time(), h = options_.machine_step;
  rest < h*(1 + 1e-9) ? machine_->advance_to(time) : machine_->advance(h);
  take_accelerations();
  time_ = machine_->time();
}

InterfaceWork Simulation::interface_work() const {
  InterfaceWork work;
  if (bed_ == nullptr || machine_ == nullptr) return work;
  for (const BodySurface& s : surfaces_) work.on_soil += bed_->boundary(s.boundary).work;
  work.on_machine = work_on_machine_.value_or(machine_->integrator().flows().external_work);
  return work;
}

ExchangeState Simulation::save() const {
  ExchangeState out{
      .in_window = in_window_, .stepped = stepped_, .window = window_, .acceleration = acceleration_, .servos = {}};
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (motions_[i].servo) out.servos.push_back(servos_[i]);
  if (!iterates()) return out;
  ExchangeState::Iterated& iterated = out.iterated.emplace();
  for (const mbd::BodyState& s : starts_) iterated.starts.push_back({s.r.x, s.r.y, s.angle, s.v.x, s.v.y, s.omega});
  iterated.ends = z_, iterated.count = exchange_;
  return out;
}

void Simulation::restore(const ExchangeState& state) {
  const auto servos =
      std::count_if(motions_.begin(), motions_.end(), [](const auto& m) { return m.servo.has_value(); });
  if (state.window.size() != window_.size() || state.acceleration.size() != acceleration_.size() ||
      state.servos.size() != static_cast<std::size_t>(servos) || state.in_window < 0 ||
      (state.iterated && (state.iterated->starts.size() != starts_.size() || state.iterated->ends.size() != z_.size())))
    throw std::invalid_argument("restart: the state has another machine, or other servos");
  // A state of the other exchange may be taken at a window's start, where neither has anything under way.
  if (state.iterated.has_value() != iterates() && state.in_window != 0)
    throw std::invalid_argument(
        "restart: the state lies inside a window of the other `time.coupling`; take a state of a window's start, or "
        "the coupling it was written with");
  in_window_ = state.in_window, stepped_ = state.stepped, work_on_machine_.reset();
  window_ = state.window, acceleration_ = state.acceleration;
  auto servo = state.servos.begin();
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (motions_[i].servo) {
      servos_[i] = *servo++;
      if (motions_[i].servo->gain_given) servos_[i].gain = motions_[i].servo->gain;
    }
  if (iterates() && state.iterated) {
    for (std::size_t b = 0; b < starts_.size(); ++b) {
      const std::array<double, 6>& s = state.iterated->starts[b];
      starts_[b] = {{s[0], s[1]}, s[2], {s[3], s[4]}, s[5]};
    }
    z_ = state.iterated->ends, exchange_ = state.iterated->count;
  }
  advanced_ = false;
  time_ = bed_ != nullptr ? bed_->time() : machine_->time();
  if (bed_ == nullptr) return;
  // The poses of the step before came back with the bed, for the next step's velocities; a run saved before its first
  // step has none.
  if (!stepped_) return place_surfaces();
  for (const BodySurface& s : surfaces_) bed_->boundary(s.boundary).pose = bed_->boundary(s.boundary).pose_before;
  for (const GivenMotion& m : motions_) bed_->boundary(m.boundary).pose = bed_->boundary(m.boundary).pose_before;
}

}  // namespace subsoil::coupling
