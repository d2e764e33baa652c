#pragma once

#include <array>
#include <concepts>
#include <span>
#include <type_traits>
#include <vector>

#include "libmbd/base/body.hpp"
#include "libmbd/element/any_element.hpp"
#include "libmbd/element/rut.hpp"

namespace subsoil::mbd {

/// What a force sees: the bodies (0 = ground), the time, the ground's ruts, the multipliers of the equations for
/// the friction that they make, the states of
/// all elements that have any, and the outputs of controllers.
struct Scene {
  std::span<const BodyState> bodies;
  double t = 0;
  std::span<const Rut> ruts;
  std::span<const double> lambda{};
  std::span<const double> states{};
  std::span<const double> signals{};
};

/// Where a force puts what it does: (F_x, F_y, M_z) about each body's centre of gravity, world axes. Ground has a slot
/// that nobody reads, so that no force needs a branch for it.
class Loads {
 public:
  explicit Loads(std::span<std::array<double, 3>> wrenches) : wrenches_(wrenches) {}
  /// Force `f` on the material point whose moment arm about the centre of gravity is `arm`, world axes.
  void add(int body, Vec2 arm, Vec2 f) { add_wrench(body, f.x, f.y, cross(arm, f)); }
  void add_wrench(int body, double fx, double fy, double mz) {
    auto& w = wrenches_[static_cast<std::size_t>(body)];
    w[0] += fx, w[1] += fy, w[2] += mz;
  }

 private:
  std::span<std::array<double, 3>> wrenches_;
};

/// The energy account of a force, of which the energy balance of the whole system is made:
///   power on the bodies = work - lost - d(stored)/dt
struct ForcePower {
  double stored = 0;  ///< energy that it can give back (J)
  double lost = 0;    ///< rate of dissipation (W)
  double work = 0;    ///< rate of work that it brings in from outside (W)
};

/// What an event does to a force at that instant.
struct Changeover {
  double heat = 0;      ///< energy that it loses (J)
  bool slides = false;  ///< friction: whether it slides from now on
};

/// A reported value of a force: name and unit.
struct ForceColumn {
  const char* name;
  const char* unit;
  bool whole = false;  ///< a whole number, which has no value between two instants
};
inline constexpr std::size_t max_force_columns = 6;
using ForceValues = std::array<double, max_force_columns>;

/// What a force has beside evaluate(), as its `static constexpr ForceMembers has{...}`. The system calls what stands
/// here and nothing else. IsForce compares it with the members that there are, so that a misspelt one is no silent
/// loss.
struct ForceMembers {
  bool check = false;                 ///< check(): refuses parameters, by std::invalid_argument
  bool prepare = false;               ///< prepare(): makes what its parameters state ready for use
  bool initialise_from_pose = false;  ///< initialise_from_pose(scene): what the start pose decides
  bool gap = false;                   ///< gap(scene): on whose sign the law depends, > 0 open, < 0 in contact;
                                      ///< gap_speed(scene): a bound on how fast it changes
  bool gaps = false;                  ///< gap_count(), gaps(scene, out): such gaps, one per point that may touch;
                                      ///< gap_speed(scene) of them all
  /// Friction that comes to rest, at stick_count() places k; see StickSlip:
  /// hold(scene, k): falls through 0 where it changes; pass_event(scene, k): it does; sticks(k): what it is
  /// `grip(scene, k, force, mass)`, `grip_limit(scene, k)`: sticks with that force on b (N), which may be so large
  /// damp(k, mass): sticks as it does, damped critically for that mass along s'' where no damping is given
  /// slide(k, sense): slides from now on; sense(k): in which it does, 0 where it sticks; slip_speed(scene, k): s' (m/s)
  /// slip_acceleration(scene, k, q'', length): s'' of a solution (m/s^2), in a machine of that length (m)
  bool stick = false;
  /// touch(scene, k, closes): the gap k has passed 0. remembers(): whether something depends on that
  bool touch = false;
  bool trace = false;  ///< begin_trace(scene), memory(), set_memory(m): what a restart needs
  /// track, rut, rut_size(), commit(scene, ruts): accepted states change the ground; commit returns what is lost at
  /// that instant (J)
  bool rut = false;
  bool towing_spin = false;  ///< towing_spin(speed): angular velocity of its body in a tow
  bool joint = false;        ///< joint, attach(joint, row): its bodies are those of a joint
  /// state_count numbers that are integrated with the motion, from first_state
  /// of the scene's on: start_states(scene), state_rates(scene), and
  /// state_scales(), the size below which they do not matter to 1 in
  /// tolerances.
  bool states = false;
  /// profile_count() laws over a relative measure x each, with features that a long step may pass over:
  /// profile_arguments(scene, out): their x; profile_value(k, x); profile_nodes(k): the x between which pieces are
  /// smooth
  bool profiles = false;
  bool controlled = false;  ///< controller, signal: its place among the scene's
                            ///< signals, -1 without
};

/// A force, or what it keeps its memory by: `template <class Self> using Memory`, which has the members that stand in
/// ForceMembers from `initialise_from_pose` to `states`, gaps apart.
template <class F>
decltype(auto) remembering(F& force) {
  if constexpr (requires { typename std::remove_const_t<F>::template Memory<F>; }) {
    return typename std::remove_const_t<F>::template Memory<F>(force);
  } else {
    return (force);
  }
}

namespace detail {
template <class F>
concept Sticks = requires(F f, const Scene scene) {
  { remembering(f).stick_count() } -> std::same_as<std::size_t>;
  { remembering(f).hold(scene, std::size_t{}) } -> std::same_as<double>;
  { remembering(f).pass_event(scene, std::size_t{}) } -> std::same_as<Changeover>;
  { remembering(f).sticks(std::size_t{}) } -> std::same_as<bool>;
  { remembering(f).grip_limit(scene, std::size_t{}) } -> std::same_as<double>;
  { remembering(f).held(scene, std::size_t{}) } -> std::same_as<double>;
  { remembering(f).creeps() } -> std::same_as<bool>;
  { remembering(f).grip(scene, std::size_t{}, 1.0, 1.0) } -> std::same_as<double>;
  { remembering(f).damp(std::size_t{}, 1.0) } -> std::same_as<void>;
  { remembering(f).slide(std::size_t{}, 1) } -> std::same_as<void>;
  { remembering(f).sense(std::size_t{}) } -> std::same_as<int>;
  { remembering(f).slip_speed(scene, std::size_t{}) } -> std::same_as<double>;
  { remembering(f).slip_acceleration(scene, std::size_t{}, std::span<const double>{}, 1.) } -> std::same_as<double>;
  { remembering(f).remembers() } -> std::same_as<bool>;
};
template <class F>
concept Touches = requires(F f, const Scene scene) {
  { remembering(f).touch(scene, std::size_t{}, true) } -> std::same_as<Changeover>;
  { remembering(f).remembers() } -> std::same_as<bool>;
};
template <class F>
concept Traces = requires(F f, const Scene scene) {
  remembering(f).begin_trace(scene);
  remembering(f).set_memory(remembering(f).memory());
};
template <class F>
concept Ruts = requires(F f, const Scene scene, std::vector<Rut> ruts) {
  f.track.empty();
  f.rut = std::size_t{0};
  { f.rut_size() } -> std::same_as<double>;
  { f.commit(scene, ruts) } -> std::same_as<double>;
};
template <class F>
concept HasStates = requires(F f, const Scene scene) {
  f.first_state = std::size_t{0};
  { remembering(f).start_states(scene)[0] } -> std::convertible_to<double>;
  { remembering(f).state_rates(scene)[0] } -> std::convertible_to<double>;
  { remembering(f).state_scales()[0] } -> std::convertible_to<double>;
};
template <class F>
concept HasProfiles = requires(const F f, const Scene scene, std::span<double> out) {
  { f.profile_count() } -> std::same_as<std::size_t>;
  f.profile_arguments(scene, out);
  { f.profile_value(std::size_t{}, 1.0) } -> std::same_as<double>;
  { f.profile_nodes(std::size_t{}) } -> std::same_as<std::vector<double>>;
};
template <class F>
concept Controlled = requires(F f) {
  f.controller.empty();
  f.signal = -1;
};
/// F::has is what F has.
template <class F>
concept ForceHas = F::has.check == requires(const F f) {
  f.check();
}
&&F::has.prepare == requires(F f) { f.prepare(); }
&&F::has.initialise_from_pose == requires(F f, const Scene scene) { remembering(f).initialise_from_pose(scene); }
&&F::has.gap == requires(const F f, const Scene scene) {
  { f.gap(scene) } -> std::same_as<double>;
  { f.gap_speed(scene) } -> std::same_as<double>;
}
&&F::has.gaps == requires(const F f, const Scene scene, std::span<double> out) {
  { f.gap_count() } -> std::same_as<std::size_t>;
  f.gaps(scene, out);
  { f.gap_speed(scene) } -> std::same_as<double>;
}
&&F::has.stick == Sticks<F>&& F::has.touch == Touches<F>&& F::has.trace == Traces<F>&& F::has.rut ==
    Ruts<F>&& F::has.towing_spin == requires(const F f) {
  { f.towing_spin(1.0) } -> std::same_as<double>;
}
&&F::has.joint == requires(F f) { f.joint.empty(); }
&&F::has.states == HasStates<F>&& F::has.profiles == HasProfiles<F>&& F::has.controlled == Controlled<F>;
}  // namespace detail

/// How many states a force has: a constant of its type, or what its parameters ask for.
template <class F>
std::size_t state_count_of(const F& f) {
  if constexpr (requires { remembering(f).state_count(); }) {
    return remembering(f).state_count();
  } else {
    return F::state_count;
  }
}

/// A force: wrenches on the bodies that it names, with its account of energy and its columns.
template <class F>
concept IsForce = requires(const F f, const Scene scene, Loads loads, ForceValues values) {
  { F::has } -> std::same_as<const ForceMembers&>;
  { f.columns.size() } -> std::same_as<std::size_t>;
  { f.evaluate(scene, loads, values) } -> std::same_as<ForcePower>;
}
&&detail::ForceHas<F>;

struct ForceFamily {
  template <class F>
  static constexpr bool takes = IsForce<F>;
};
using AnyForce = AnyElement<ForceFamily>;

}  // namespace subsoil::mbd
