#pragma once

#include <Eigen/Core>
#include <concepts>
#include <span>
#include <string>
#include <vector>

#include "libmbd/base/marker.hpp"
#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// A column of a measure: `.x` of its vector, or, with an empty suffix, the measure's own name.
struct MeasureColumn {
  std::string suffix;
  const char* unit;
};

/// Where a marker is and how it moves (world axes; m, rad and their rates).
struct MarkerState {
  Vec2 r, v, a;
  double angle = 0, omega = 0, alpha = 0;

  /// A world vector in the marker's axes.
  Vec2 seen(Vec2 w) const {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * w.x + s * w.y, c * w.y - s * w.x};
  }
};

/// What a measure sees: a machine at an instant, with its accelerations q'' and the multipliers of all constraints.
struct Observation {
  const System& system;
  const Eigen::VectorXd& acceleration;
  const Eigen::VectorXd& lambda;

  MarkerState at(const Marker& m) const {
    const BodyState& b = system.body(m.body);
    const Vec2 arm = b.vector_in_world(m.p);
    MarkerState state{b.r + arm, b.velocity_at(arm), -b.omega * b.omega * arm, b.angle + m.angle, b.omega, 0};
    if (m.body == ground) return state;
    const auto q2 = acceleration.segment<3>(3 * (m.body - 1));
    state.alpha = q2[2];
    state.a = Vec2{q2[0], q2[1]} + state.a + state.alpha * turned(arm);
    return state;
  }
};

/// Which numbers of a vector become columns: NAME.x and NAME.y, or one of them, or its size, as NAME.
enum class VectorPart { both, x, y, size };
/// The same of a force with its moment: NAME.x, NAME.y and NAME.moment, or one of them as NAME.
enum class WrenchPart { all, x, y, moment, size };

template <class V>
void describe_part(V& v, VectorPart& part) {
  v.choice("component", part,
           {{"both", VectorPart::both}, {"x", VectorPart::x}, {"y", VectorPart::y}, {"size", VectorPart::size}},
           "both: the columns NAME.x and NAME.y; else one column NAME");
}

template <class V>
void describe_part(V& v, WrenchPart& part) {
  v.choice("component", part,
           {{"all", WrenchPart::all},
            {"x", WrenchPart::x},
            {"y", WrenchPart::y},
            {"moment", WrenchPart::moment},
            {"size", WrenchPart::size}},
           "all: the columns NAME.x, NAME.y and NAME.moment; else one column NAME; size: of the force");
}

std::vector<MeasureColumn> columns_of(VectorPart part, const char* unit);
std::vector<MeasureColumn> columns_of(WrenchPart part);
/// Writes what columns_of() announced.
void put(VectorPart part, Vec2 value, std::span<double> out);
void put(WrenchPart part, Vec2 force, double moment, std::span<double> out);

/// What a measure has beside columns() and evaluate(), as its `static constexpr MeasureMembers has{...}`; see
/// ForceMembers.
struct MeasureMembers {
  bool attach = false;       ///< attach(system): finds a joint or force by its name
  bool of_solution = false;  ///< depends on accelerations, reactions or forces
};

/// A measure: numbers of a machine at an instant.
template <class M>
concept IsMeasure = requires(const M m, const Observation o, std::span<double> out) {
  { M::has } -> std::same_as<const MeasureMembers&>;
  { m.columns() } -> std::same_as<std::vector<MeasureColumn>>;
  m.evaluate(o, out);
}
&&M::has.attach == requires(M m, const System& system) { m.attach(system); };

struct MeasureFamily {
  template <class M>
  static constexpr bool takes = IsMeasure<M>;
};
using AnyMeasure = AnyElement<MeasureFamily>;

}  // namespace subsoil::mbd
