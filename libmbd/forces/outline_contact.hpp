#pragma once

#include "libmbd/element/outline_forms.hpp"
#include "libmbd/element/touch_memory.hpp"

namespace subsoil::mbd {

/// Contact of the outlines of two bodies (cams, hooks, pawls, blocks), at every place where they can touch:
///   corner or disk    gap = d(C) - R           C, R: centre, radius; d: signed distance of the other outline      (m)
///   side              gap = n . (c - q)        against a closed curve; c: its farthest point along -n            (m)
/// A polygon brings its convex corners, both of two polygons theirs; with a curve the corner counts where the curve's
/// normal lies between those of the corner's sides, else the side: at the handover both are the same contact. In a
/// re-entrant corner it touches both sides, and has a place on each (Outline::all_near). Each
/// place with gap < 0 has a force of its own, ContactLaw: Hunt-Crossley of the depth -gap and Coulomb friction. So a
/// block on its side has two, and the stored energy is a continuous function of the pose. Validity: depths small beside
/// sides and radii. Where corner meets corner, each sees the other. A side sees a curve's farthest point alone, and
/// curves whose middle is on its free side; it sees no open flank, nor the inside of a hole. Curves do not see each
/// other (refused).
///
/// Columns: sums of normal force and friction, minimum gap, slip of the deepest place, number of places in contact.
/// Source of the law: see HuntCrossleyForce; of the geometry: Ericson 2005, Real-Time Collision Detection, 5.1 and 9.
struct OutlineContact {
  template <class Self>
  using Memory = ContactMemory<Self>;
  static constexpr ForceMembers has = [] {
    ForceMembers members = contact_members(true);
    members.prepare = true;
    return members;
  }();
  static constexpr std::array<ForceColumn, 5> columns{
      {{"normal force", "N"}, {"friction", "N"}, {"gap", "m"}, {"slip", "m/s"}, {"contacts", "1", true}}};
  int body_a = -1, body_b = -1;
  OutlineForm first{}, second{};
  ContactLaw law{};
  /// Where the two can touch: a corner or a side of one of them, and how many places of the other it meets at most.
  struct Site {
    bool of_second, face;
    std::size_t index, at_once = 1;
  };
  // Made by prepare():
  std::shared_ptr<const Outline> outline_a{}, outline_b{};
  std::vector<Site> sites{};
  std::vector<Touch> touches{};  // see ContactMemory
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("outline contact", "the outlines of two bodies touch wherever they meet, and only push");
    v.bodies("outline contact", body_a, body_b, "the two bodies");
    v.form("first", first, "the outline of the first body");
    v.form("second", second, "the outline of the second body");
    law.describe(v);
  }

  void check() const;
  /// Makes the outlines ready; throws std::invalid_argument with what is wrong.
  void prepare();

  std::size_t gap_count() const;
  void gaps(const Scene& scene, std::span<double> out) const;
  double gap_speed(const Scene& scene) const;
  /// Of the gap k; the normal points away from what a corner sees, and away from a face's own body.
  ContactPlace place(const Scene& scene, std::size_t k) const;
  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const;

 private:
  using Touches = std::array<ContactPoint, Outline::most_at_once>;  // the first at_once of a place
  void list_sites();
  ContactPlace placed(const Site& site, const ContactPoint& point) const;
  void find(const Scene& scene, const Site& site, Touches& out) const;
  void touch_corner(const BodyState& owner, const BodyState& other, const Outline& seen, const Outline::Corner& corner,
                    Touches& out) const;
  ContactPoint touch_face(const BodyState& owner, const BodyState& other, const Outline& seen,
                          const Outline::Face& face) const;
};

}  // namespace subsoil::mbd
