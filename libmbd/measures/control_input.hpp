#pragma once

#include <memory>
#include <string>

#include "libmbd/controllers/pid.hpp"
#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

/// A column of a measure as the input of a controller.
std::shared_ptr<ControllerInput> input_of(const AnyMeasure& measure, std::size_t column = 0);

/// The columns of a measure: the suffix of each and its unit.
std::vector<MeasureColumn> columns_of(const AnyMeasure& measure);

}  // namespace subsoil::mbd
