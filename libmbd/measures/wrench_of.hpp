#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>

#include "libmbd/system/measure.hpp"
#include "libmbd/system/wrench.hpp"

namespace subsoil::mbd {

/// A wrench of a joint or force on one of its bodies, in the axes of a marker, about a marker's point: shared by the
/// measures of both.
struct WrenchOf {
  std::string element{};  ///< its name
  int on = -1;            ///< body; -1: the measure's own choice
  Marker in{.name = "ground"};
  Marker about{};  ///< without a name: the wrench's own point
  WrenchPart part = WrenchPart::all;
  std::size_t index = 0;  ///< of the element; found by attach()

  std::vector<MeasureColumn> columns() const { return columns_of(part); }

 protected:
  template <class V>
  void describe_rest(V& v, const char* which_body, const char* which_point) {
    v.optional_body("on", on, which_body);
    v.optional_marker("in", in, "whose axes the components are given in");
    v.optional_marker("about", about, which_point);
    describe_part(v, part);
  }

  /// `bodies`: those of the element; `own`: the one that the measure chooses where the user does not.
  void find(const char* kind, const System& system, const std::vector<int>& bodies, int own) {
    if (on < 0) on = own;
    if (std::find(bodies.begin(), bodies.end(), on) != bodies.end()) return;
    std::string names;
    for (const int body : bodies) names += (names.empty() ? "" : ", ") + system.body_name(body);
    throw std::invalid_argument(std::string(kind) + " '" + element + "' does not act on '" + system.body_name(on) +
                                "'; let `on` be one of " + names);
  }
  void report(const Observation& o, const Wrench& w, std::span<double> out) const {
    const Wrench moved = about.name.empty() ? w : w.moved_to(o.at(about).r);
    put(part, o.at(in).seen(moved.force), moved.moment, out);
  }
};

}  // namespace subsoil::mbd
