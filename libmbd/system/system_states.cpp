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
              refuse_model({PartName::Kind::force, f.name},
                           ": no controller '" + force.controller + "'; there are " + (known.empty() ? "none" : known));
          }
        },
        f.element);
  signals_.assign(model_.controllers.size(), 0.0);
  std::size_t inputs = 0;
  for (const auto& c : model_.controllers) {
    first_measured_.push_back(inputs);
    inputs += visit([](const auto& controller) { return controller.measured().size(); }, c.element);
  }
  measured_.assign(inputs, 0.0);
  samplers_.resize(model_.controllers.size());
  no_acceleration_.setZero(coordinates()), no_lambda_.setZero(equations());
}

void System::number_states() {
  for (auto& f : model_.forces)
    visit(
        [&]<class Force>(Force& force) {
          if constexpr (Force::has.states) {
            force.first_state = state_scales_.size();
            for (const double scale : remembering(force).state_scales()) state_scales_.push_back(scale);
          }
        },
        f.element);
  for (std::size_t i = 0; i < model_.controllers.size(); ++i) {
    visit(
        [&](auto& controller) {
          controller.first_state = state_scales_.size();
          state_scales_.insert(state_scales_.end(), controller.state_count(), 1.0);
        },
        model_.controllers[i].element);
    has_instants_ = has_instants_ || sampled(i) != nullptr;
  }
  element_states_.assign(state_scales_.size(), 0.0);
  state_rates_ = element_states_;
}

/// The controller where it acts from instant to instant.
const PidController* System::sampled(std::size_t controller) const {
  const auto* const pid = model_.controllers[controller].element.get_if<PidController>();
  return pid != nullptr && pid->sampled() ? pid : nullptr;
}

namespace {
/// Reads the inputs that `wanted` takes into y.
template <class Wanted>
void read_inputs(const ControllerInputs& inputs, const Observation& at, double* y, Wanted wanted) {
  for (std::size_t k = 0; k < inputs.size(); ++k)
    if (wanted(*inputs[k])) y[k] = inputs[k]->value(at);
}
}  // namespace

void System::take_signals() {
  const Observation now{*this, no_acceleration_, no_lambda_};
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    if (sampled(i) != nullptr) {
      signals_[i] = samplers_[i].held(t_, outputs_before_);
      continue;
    }
    visit(
        [&](const auto& c) {
          double* const y = measured_.data() + first_measured_[i];
          read_inputs(c.measured(), now, y, [](const ControllerInput& input) { return !input.of_solution(); });
          signals_[i] = c.output(t_, y, element_states_.data() + c.first_state);
        },
        model_.controllers[i].element);
  }
}

const std::vector<double>& System::take_state_rates(const Eigen::VectorXd& acceleration,
                                                    const Eigen::VectorXd& lambda) {
  const Scene now = scene();
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.states) {
      if (state_count_of(*placed.element) == 0) return;
      const auto rates = remembering(*placed.element).state_rates(now);
      std::copy(rates.begin(), rates.end(),
                state_rates_.begin() + static_cast<std::ptrdiff_t>(placed.element->first_state));
    }
  });
  const Observation seen{*this, acceleration, lambda};
  for (std::size_t i = 0; i < signals_.size(); ++i)
    visit(
        [&](const auto& c) {
          double* const y = measured_.data() + first_measured_[i];
          const bool all = sampled(i) != nullptr;
          read_inputs(c.measured(), seen, y,
                      [all](const ControllerInput& input) { return all || input.of_solution(); });
          c.rates(t_, y, element_states_.data() + c.first_state, state_rates_.data() + c.first_state);
        },
        model_.controllers[i].element);
  return state_rates_;
}

const std::vector<double>& System::begin_states() {
  const Observation now{*this, no_acceleration_, no_lambda_};
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    visit(
        [&]<class Controller>(const Controller& c) {
          double* const y = measured_.data() + first_measured_[i];
          read_inputs(c.measured(), now, y, [](const ControllerInput& input) { return !input.of_solution(); });
          // What is of the solution begins where there is nothing to correct.
          double nothing = 0;
          if constexpr (Controller::has.functions) nothing = c.set_point.value(t_);
          for (std::size_t k = 0; k < c.measured().size(); ++k)
            if (c.measured()[k]->of_solution()) y[k] = nothing;
          c.start(t_, y, element_states_.data() + c.first_state);
        },
        model_.controllers[i].element);
    samplers_[i].start(t_);
  }
  for_each_placed(elements_->forces, [&]<class Placed>(const Placed& placed) {
    using Force = std::remove_cvref_t<decltype(*placed.element)>;
    if constexpr (Force::has.states) {
      const auto start = remembering(*placed.element).start_states(scene());
      std::copy(start.begin(), start.end(),
                element_states_.begin() + static_cast<std::ptrdiff_t>(placed.element->first_state));
    }
  });
  if (!start_states_.empty()) element_states_ = start_states_;
  return element_states_;
}

std::string System::state_owner(std::size_t state) const {
  std::string owner;
  for (const auto& f : model_.forces)
    visit(
        [&]<class Force>(const Force& force) {
          if constexpr (Force::has.states)
            if (state >= force.first_state && state < force.first_state + state_count_of(force))
              owner = "force '" + f.name + "'";
        },
        f.element);
  for (const auto& c : model_.controllers)
    visit(
        [&](const auto& controller) {
          if (state >= controller.first_state && state < controller.first_state + controller.state_count())
            owner = "controller '" + c.name + "'";
        },
        c.element);
  return owner;
}

bool System::begin_states_of(const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda) {
  if (!start_states_.empty()) return false;
  const Observation seen{*this, acceleration, lambda};
  bool any = false;
  for (std::size_t i = 0; i < signals_.size(); ++i)
    visit(
        [&](const auto& c) {
          const ControllerInputs inputs = c.measured();
          if (std::none_of(inputs.begin(), inputs.end(), [](const auto& input) { return input->of_solution(); }))
            return;
          any = true;
          double* const y = measured_.data() + first_measured_[i];
          read_inputs(inputs, seen, y, [](const ControllerInput& input) { return input.of_solution(); });
          c.start(t_, y, element_states_.data() + c.first_state);
        },
        model_.controllers[i].element);
  return any;
}

double System::controller_error(std::size_t controller) const {
  return visit(
      [&]<class Controller>(const Controller& c) -> double {
        if constexpr (Controller::has.error)
          return c.error(t_, measured_.data() + first_measured_[controller], element_states_.data() + c.first_state);
        return 0;
      },
      model_.controllers[controller].element);
}

double System::next_instant() const {
  double next = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < samplers_.size(); ++i)
    if (const PidController* c = sampled(i)) next = std::min(next, samplers_[i].next(*c));
  for (std::size_t i = 0; i < model_.events.size(); ++i)
    if (model_.events[i].element.timed() && !passed_[i]) next = std::min(next, model_.events[i].element.at);
  return next;
}

void System::act(const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda, double close) {
  const Observation seen{*this, acceleration, lambda};
  for (std::size_t i = 0; i < samplers_.size(); ++i) {
    const PidController* const c = sampled(i);
    if (c == nullptr || samplers_[i].next(*c) > t_ + close) continue;
    double& y = measured_[first_measured_[i]];
    y = c->input->value(seen);
    if (samplers_[i].act(*c, t_, close, y, element_states_.data() + c->first_state)) ++wrench_changes_;
  }
}

void System::forget_outputs_before() {
  for (Sampler& s : samplers_) s.forget_before();
}

}  // namespace subsoil::mbd
