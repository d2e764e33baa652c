#include <algorithm>
#include <limits>

#include "libmbd/system/measure.hpp"
#include "libmbd/system/system_elements.hpp"

/// States of elements and controllers: pressures, currents, integrals; sampled outputs.
namespace subsoil::mbd {

void System::attach_controllers() {
  for (auto& f : model_.forces)
    visit(
        [&]<class Force>(Force& force) {
          if constexpr (Force::has.controlled) {
            if (force.controller.empty()) return;
            std::string known;
            for (std::size_t i = 0; i < model_.controllers.size(); ++i) {
              if (model_.controllers[i].name == force.controller) force.signal = static_cast<int>(i);
              known += (i ? ", " : "") + model_.controllers[i].name;
            }
            if (force.signal < 0)
              refuse_model("force '" + f.name + "': no controller '" + force.controller + "'; there are " +
                           (known.empty() ? "none" : known));
          }
        },
        f.element);
  signals_.assign(model_.controllers.size(), 0.0);
  measured_ = signals_;
  samplers_.resize(model_.controllers.size());
  no_acceleration_.setZero(coordinates()), no_lambda_.setZero(equations());
}

void System::number_states() {
  for (auto& f : model_.forces)
    visit(
        [&]<class Force>(Force& force) {
          if constexpr (Force::has.states) {
            force.first_state = state_scales_.size();
            for (const double scale : force.state_scales()) state_scales_.push_back(scale);
          }
        },
        f.element);
  for (auto& c : model_.controllers) {
    c.element.first_state = state_scales_.size();
    state_scales_.insert(state_scales_.end(), PidController::state_count, 1.0);
    has_instants_ = has_instants_ || c.element.sampled();
  }
  element_states_.assign(state_scales_.size(), 0.0);
  state_rates_ = element_states_;
}

void System::take_signals() {
  const Observation now{*this, no_acceleration_, no_lambda_};
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    const PidController& c = model_.controllers[i].element;
    if (c.sampled()) {
      signals_[i] = samplers_[i].held(t_, outputs_before_);
      continue;
    }
    if (!c.input->of_solution()) measured_[i] = c.input->value(now);
    signals_[i] = c.output(t_, measured_[i], element_states_.data() + c.first_state);
  }
}

const std::vector<double>& System::take_state_rates(const Eigen::VectorXd& acceleration,
                                                    const Eigen::VectorXd& lambda) {
  const Scene now = scene();
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.states) {
      const auto rates = placed.element->state_rates(now);
      std::copy(rates.begin(), rates.end(),
                state_rates_.begin() + static_cast<std::ptrdiff_t>(placed.element->first_state));
    }
  });
  const Observation seen{*this, acceleration, lambda};
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    const PidController& c = model_.controllers[i].element;
    if (c.input->of_solution() || c.sampled()) measured_[i] = c.input->value(seen);
    c.rates(t_, measured_[i], element_states_.data() + c.first_state, state_rates_.data() + c.first_state);
  }
  return state_rates_;
}

const std::vector<double>& System::begin_states() {
  const Observation now{*this, no_acceleration_, no_lambda_};
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    const PidController& c = model_.controllers[i].element;
    // What is of the solution begins where there is nothing to correct.
    measured_[i] = c.input->of_solution() ? c.set_point.value(t_) : c.input->value(now);
    const auto start = c.start(t_, measured_[i]);
    std::copy(start.begin(), start.end(), element_states_.begin() + static_cast<std::ptrdiff_t>(c.first_state));
    samplers_[i].start(t_);
  }
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.states) {
      const auto start = placed.element->start_states(scene());
      std::copy(start.begin(), start.end(),
                element_states_.begin() + static_cast<std::ptrdiff_t>(placed.element->first_state));
    }
  });
  return element_states_;
}

bool System::begin_states_of(const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda) {
  const Observation seen{*this, acceleration, lambda};
  bool any = false;
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    const PidController& c = model_.controllers[i].element;
    if (!c.input->of_solution()) continue;
    any = true;
    measured_[i] = c.input->value(seen);
    const auto start = c.start(t_, measured_[i]);
    std::copy(start.begin(), start.end(), element_states_.begin() + static_cast<std::ptrdiff_t>(c.first_state));
  }
  return any;
}

void System::see(Seen& out) const {
  out.t = t_, out.states = states_, out.multipliers = multipliers_, out.element_states = element_states_;
  out.signals = signals_, out.measured = measured_, out.powers = powers_, out.values = values_;
}

void System::set_seen(const Seen& seen) {
  t_ = seen.t, states_ = seen.states, multipliers_ = seen.multipliers, element_states_ = seen.element_states;
  signals_ = seen.signals, measured_ = seen.measured, powers_ = seen.powers, values_ = seen.values;
}

double System::controller_error(std::size_t controller) const {
  const PidController& c = model_.controllers[controller].element;
  return c.error(t_, measured_[controller], element_states_.data() + c.first_state);
}

double System::next_instant() const {
  double next = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < samplers_.size(); ++i)
    if (model_.controllers[i].element.sampled())
      next = std::min(next, samplers_[i].next(model_.controllers[i].element));
  for (std::size_t i = 0; i < model_.events.size(); ++i)
    if (model_.events[i].element.timed() && !passed_[i]) next = std::min(next, model_.events[i].element.at);
  return next;
}

void System::act(const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda, double close) {
  const Observation seen{*this, acceleration, lambda};
  for (std::size_t i = 0; i < samplers_.size(); ++i) {
    const PidController& c = model_.controllers[i].element;
    if (!c.sampled() || samplers_[i].next(c) > t_ + close) continue;
    measured_[i] = c.input->value(seen);
    if (samplers_[i].act(c, t_, close, measured_[i], element_states_.data() + c.first_state)) ++wrench_changes_;
  }
}

void System::forget_outputs_before() {
  for (Sampler& s : samplers_) s.forget_before();
}

}  // namespace subsoil::mbd
