#include "coupling/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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

void Simulation::gather(double share) {
  for (dem::Wrench& w : soil_on_body_) w = {};
  for (const BodySurface& s : surfaces_) {
    const dem::Boundary& b = bed_->boundary(s.boundary);
    // The window's mean is about the centre of mass where it is; a body's own origin is that centre.
    soil_on_body_[static_cast<std::size_t>(s.body)] += b.wrench;
  }
  for (std::size_t i = 0; i < window_.size(); ++i) window_[i] += soil_on_body_[i] * share;
}

void Simulation::advance_machine() {
  for (const BodySurface& s : surfaces_) {
    const dem::Wrench& w = window_[static_cast<std::size_t>(s.body)];
    machine_->set_external_wrench(s.body, w.force.x, w.force.y, w.moment.z);
  }
  if (bed_ != nullptr) {
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
  place_surfaces();
  bed_->step(options_.soil_step, request);
  stepped_ = true;
  advance_servos();  // by the load at t_n
  time_ = bed_->time();
  gather(1.0 / options_.soil_steps);
  if (++in_window_ < options_.soil_steps) return;
  in_window_ = 0;
  if (machine_ != nullptr) advance_machine();
}

void Simulation::step_to(double time) {
  const double rest = time - machine_->time(), h = options_.machine_step;
  machine_->advance(rest < h * (1 + 1e-9) ? rest : h);
  take_accelerations();
  time_ = machine_->time();
}

InterfaceWork Simulation::interface_work() const {
  InterfaceWork work;
  if (bed_ == nullptr || machine_ == nullptr) return work;
  for (const BodySurface& s : surfaces_) work.on_soil += bed_->boundary(s.boundary).work;
  work.on_machine = machine_->energy().external_work;
  return work;
}

std::vector<double> Simulation::save() const {
  std::vector<double> out{static_cast<double>(in_window_), stepped_ ? 1.0 : 0.0};
  for (const dem::Wrench& w : window_)
    out.insert(out.end(), {w.force.x, w.force.y, w.force.z, w.moment.x, w.moment.y, w.moment.z});
  for (const auto& a : acceleration_) out.insert(out.end(), a.begin(), a.end());
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    if (!motions_[i].servo) continue;
    const ServoState& s = servos_[i];
    out.insert(out.end(), {s.travel, s.velocity, s.integral, s.error, s.force, s.load, s.began ? 1.0 : 0.0});
  }
  return out;
}

void Simulation::restore(const std::vector<double>& state) {
  const auto servos =
      std::count_if(motions_.begin(), motions_.end(), [](const auto& m) { return m.servo.has_value(); });
  if (state.size() != 2 + 9 * window_.size() + ServoState::kNumbers * static_cast<std::size_t>(servos))
    throw std::invalid_argument("restart: the state has another machine, or other servos");
  const double* at = state.data();
  in_window_ = static_cast<int>(*at++);
  stepped_ = *at++ != 0;
  for (dem::Wrench& w : window_) {
    w = {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}};
    at += 6;
  }
  for (auto& a : acceleration_)
    for (double& x : a) x = *at++;
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    if (!motions_[i].servo) continue;
    ServoState& s = servos_[i];
    for (double* x : {&s.travel, &s.velocity, &s.integral, &s.error, &s.force, &s.load}) *x = *at++;
    s.began = *at++ != 0;
  }
  time_ = bed_ != nullptr ? bed_->time() : machine_->time();
  if (bed_ == nullptr) return;
  // The poses of the step before came back with the bed, for the next step's velocities; a run saved before its first
  // step has none.
  if (!stepped_) return place_surfaces();
  for (const BodySurface& s : surfaces_) bed_->boundary(s.boundary).pose = bed_->boundary(s.boundary).pose_before;
  for (const GivenMotion& m : motions_) bed_->boundary(m.boundary).pose = bed_->boundary(m.boundary).pose_before;
}

}  // namespace subsoil::coupling
