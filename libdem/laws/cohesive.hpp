#pragma once
#include "libdem/laws/cohesion.hpp"

/// A normal law with cohesion, as the sweep evaluates it. Users write the law and its `cohesion`; make_law()
/// puts this around laws that have one, so that the others carry neither its arithmetic nor its memory.
namespace subsoil::dem {

template <class Normal>
struct Cohesive : Normal {
  static constexpr LawMembers has{.memory = Normal::has.memory + 1,  // the normal law's, and whether a bridge holds
                                  .plastic = Normal::has.plastic,
                                  .needs_sum = true,
                                  .weaken = true,
                                  .may_gain = Normal::has.may_gain,
                                  .refuse_collapse = true};

  void weaken(double share) { this->cohesion.weaken(share); }
  double cutoff() const { return std::max(Normal::cutoff(), this->cohesion.cutoff()); }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a, T (&memory)[Cohesive::has.memory]) const {
    NormalForce<T> n = normal_force(static_cast<const Normal&>(*this), a, memory);
    this->cohesion.add(a, n, memory[Cohesive::has.memory - 1]);
    return n;
  }

  /// Throws std::invalid_argument when attraction is stronger than the contact: spheres would rest half a radius and
  /// more in each other.
  void refuse_collapse(double r_eff) const {
    double memory[Cohesive::has.memory] = {};
    // Of all pairs of this r_eff two equal spheres have the maximum circle in common, and so the maximum pull.
    if (normal(Approach<double>{r_eff, 0, 1, r_eff, 0, 0.25 / r_eff}, memory).force > 0) return;
    throw std::invalid_argument("at r_eff = " + std::to_string(1e3 * r_eff) +
                                " mm the cohesion is stronger than the contact, spheres would sink into each other; "
                                "take a stiffer contact or a weaker cohesion");
  }

  /// Stiffness at the overlap that bodies reach which attract each other.
  StiffnessBound bound(const WorstContact& w) const {
    WorstContact harder = w;
    if constexpr (!Normal::constant_stiffness) harder.speed = speed_of(overlap_at(w), w);
    StiffnessBound b = Normal::bound(harder);
    b.k_n = std::max(b.k_n, this->cohesion.steepest(w));
    return b;
  }

 private:
  /// Work that it takes to load the spring to an overlap, J; of the normal law alone, or with the attraction.
  double stored(double overlap, const WorstContact& w, bool attracted) const {
    const Approach<double> a{overlap, 0, std::sqrt(w.m_eff), w.r_eff, 1, 0.25 / w.r_eff};
    double memory[Cohesive::has.memory] = {};
    const NormalForce<double> n = normal_force(static_cast<const Normal&>(*this), a, memory);
    const double work = n.stored + n.lost;  // what plasticity takes is work too
    if (!attracted) return work;
    NormalForce<double> attraction{};
    attraction.in_contact = overlap > 0;
    double bridge = 0;
    this->cohesion.add(a, attraction, bridge);
    return work + attraction.stored;
  }
  /// Where bodies that meet at the expected speed turn: the maximum overlap whose energy is theirs, by halving.
  double overlap_at(const WorstContact& w) const {
    const double energy = 0.5 * w.m_eff * w.speed * w.speed;
    double high = w.r_eff;
    while (stored(high, w, true) < energy && high < 1e3 * w.r_eff) high *= 2;
    while (high > 1e-15 * w.r_eff && stored(0.5 * high, w, true) > energy) high *= 0.5;
    double low = 0.5 * high;
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (low + high);
      (stored(middle, w, true) > energy ? high : low) = middle;
    }
    return high;
  }
  /// Speed that reaches an overlap without the attraction.
  double speed_of(double overlap, const WorstContact& w) const {
    return std::sqrt(2 * stored(overlap, w, false) / w.m_eff);
  }
};

}  // namespace subsoil::dem
