#include "libmbd/adaptive.hpp"

#include <limits>
#include <stdexcept>

namespace subsoil::mbd {

namespace {
// Within one advance(). More means that steps have become so short that the end is out of reach.
constexpr long most_steps = 2'000'000;
}  // namespace

Adaptive::Adaptive(System& system) : Integrator(system), directions_(switches_.count(), 0) {}

void Adaptive::on_start() {
  clock_.restart();
  coupled_ = remembers(system_.model());
  rows_ = partition_.used_rows();
  build();
  restart();
}

void Adaptive::restart() {
  wrench_changes_ = system_.wrench_changes();
  partition_.evaluate(now_);
  if (partition_.used_rows() != rows_) {  // redundant constraints: others carry the multipliers now
    rows_ = partition_.used_rows();
    build();
  }
  begin();
  front_ = now_.t, root_ = false;
}

void Adaptive::read_consistent(double t) {
  read(t);
  now_.t = t;
  if (follows_partition()) return partition_.evaluate(now_);
  // What does not step by the partition may have passed a pose where the choice of the output before is singular.
  bool singular = false;
  try {
    partition_.evaluate(now_);
    singular = partition_.asks_for_choice();
  } catch (const std::runtime_error&) {
    singular = true;
  }
  if (!singular) return;
  read(t);
  partition_.choose(now_);
  partition_.evaluate(now_);
}

void Adaptive::pass_event() {
  read_consistent(front_);
  root_directions(directions_);
  // The side is kept here, so that a zero which rounding shows twice after a restart counts once.
  for (std::size_t i = 0; i < directions_.size(); ++i)
    if (directions_[i] * switches_.side(i) < 0) take_event(i);
  restart();
}

void Adaptive::on_advance(double h) {
  const double end = clock_.end_of_step(now_.t, h);
  if (wrench_changes_ != system_.wrench_changes()) {
    coupled_ = true;
    restart();
  }
  const double stop = coupled_ ? end : std::numeric_limits<double>::infinity();
  for (long taken = 0; front_ < end; ++taken) {
    if (taken == most_steps)
      throw std::runtime_error("t = " + std::to_string(front_) + " s: " + std::to_string(most_steps) +
                               " steps did not reach " + std::to_string(end) +
                               " s; the system is stiff or its forces are not smooth: take ida, or a wider tolerance");
    if (root_) {
      pass_event();
      continue;
    }
    const Reached reached = take_step(end, stop);
    front_ = reached.t, root_ = reached.root;
    if (!root_ && front_ < end && follows_partition() && partition_.asks_for_choice()) {
      read_consistent(front_);
      if (partition_.choose_again_if_needed(now_)) restart();
    }
  }
  read_consistent(end);
  bool anew = has_drifted();
  if (partition_.choose_again_if_needed(now_)) {
    partition_.evaluate(now_);
    anew = anew || follows_partition();
  }
  if (anew || partition_.used_rows() != rows_) restart();
}

}  // namespace subsoil::mbd
