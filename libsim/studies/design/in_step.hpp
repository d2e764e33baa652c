#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace subsoil::sim {

/// A design as places in the bounds of its parameters, 0 to 1 each.
using Design = std::vector<double>;

/// What a design is worth.
struct Worth {
  std::size_t point = 0;             ///< of the study
  bool whole = false;                ///< all numbers and formulas have a value
  double objective = 0;              ///< as the plan asks: what is minimised or maximised
  std::vector<double> excess, size;  ///< per constraint, as DesignConstraint
};

/// Asks for designs, which run side by side.
using Ask = std::function<std::vector<Worth>(const std::vector<Design>&)>;
struct Question {
  std::size_t search = 0;
  std::vector<Design> places;
};

/// Runs searches 0 ... count - 1, each in a thread of its own that waits while its designs run. Designs run when every
/// search that has not ended has asked, by `answer`, in the calling thread and in the order of the searches: so points
/// have the same numbers however long each takes. What `answer` or a search throws ends all and is thrown here.
void search_in_step(std::size_t count, const std::function<void(std::size_t, const Ask&)>& search,
                    const std::function<std::vector<std::vector<Worth>>(const std::vector<Question>&)>& answer);

}  // namespace subsoil::sim
