#pragma once

// The list of controllers: a new one is its own file and one word here.

#include <tuple>

#include "libmbd/controllers/formula.hpp"
#include "libmbd/controllers/pid.hpp"
#include "libmbd/controllers/table_of_two.hpp"
#include "libmbd/controllers/transfer_function.hpp"

namespace subsoil::mbd {

using Controllers = std::tuple<PidController, FormulaController, TransferFunction, TableOfTwo>;

template <>
struct ListOf<ControllerFamily> {
  using type = Controllers;
};

}  // namespace subsoil::mbd
