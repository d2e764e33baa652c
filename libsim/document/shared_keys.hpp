#pragma once
#include <string>
#include <vector>

#include "libsim/document/document.hpp"

/// Parameters of a plan, whose `paths` are keys of a scenario that they move.
namespace subsoil::sim {

/// The scenario of a plan as it is written, with the plan's sets; empty where it cannot be read, which is refused where
/// it is loaded.
Node written_scenario(const std::string& file, const std::vector<std::string>& sets);

/// Refuses, by refuse(path, rule), keys of a plan's parameters that another moves before, or a section that holds them:
/// the later parameter would win without a word.
template <class Parameter, class Refuse>
void refuse_shared_keys(const std::vector<Parameter>& parameters, const Node& scenario, Refuse refuse) {
  for (std::size_t k = 0; k < parameters.size(); ++k)
    for (std::size_t i = 0; i < k; ++i)
      for (const std::string& one : parameters[i].paths)
        for (const std::string& other : parameters[k].paths)
          if (paths_meet(scenario, one, other))
            refuse("parameters." + parameters[k].name + ".keys",
                   "`" + other + "` is moved by parameter `" + parameters[i].name + "` already" +
                       (one == other ? "" : ", as `" + one + "`") +
                       ": the later one would win; leave the key to one of them");
}

}  // namespace subsoil::sim
