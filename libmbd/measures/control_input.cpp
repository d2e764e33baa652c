#include "libmbd/measures/control_input.hpp"

#include <stdexcept>

#include "libmbd/measures.hpp"

namespace subsoil::mbd {

namespace {

class MeasureInput final : public ControllerInput {
 public:
  MeasureInput(AnyMeasure measure, std::size_t column)
      : measure_(std::move(measure)), column_(column), values_(columns_of(measure_).size()) {
    if (column_ >= values_.size()) throw std::invalid_argument("the measure has no such column");
  }
  void attach(const System& system) override {
    visit(
        [&]<class Measure>(Measure& m) {
          if constexpr (Measure::has.attach) m.attach(system);
        },
        measure_);
  }
  double value(const Observation& at) const override {
    visit([&](const auto& m) { m.evaluate(at, values_); }, measure_);
    return values_[column_];
  }
  bool of_solution() const override {
    return visit([]<class Measure>(const Measure&) { return Measure::has.of_solution; }, measure_);
  }

 private:
  AnyMeasure measure_;
  std::size_t column_;
  mutable std::vector<double> values_;
};

}  // namespace

std::shared_ptr<ControllerInput> input_of(const AnyMeasure& measure, std::size_t column) {
  return std::make_shared<MeasureInput>(measure, column);
}

std::vector<MeasureColumn> columns_of(const AnyMeasure& measure) {
  return visit([](const auto& m) { return m.columns(); }, measure);
}

}  // namespace subsoil::mbd
