#include "libmbd/forces/outline_contact.hpp"

#include <algorithm>

namespace subsoil::mbd {

namespace {

using Kind = Outline::Kind;

Outline made_outline(const OutlineForm& form) {
  return std::visit([](const auto& f) { return f.make(); }, form);
}

double unfit_for_hollow(const Outline& hollow, const Outline& other) {
  if (other.kind() != Kind::disk && other.kind() != Kind::polygon) return 0;
  double radius = 0;
  for (const Outline::Corner& c : other.corners()) radius = std::max(radius, c.radius);
  return radius >= hollow.narrowest_hollow() ? radius : 0;
}

}  // namespace

void OutlineContact::check() const {
  law.check();
  OutlineContact trial = *this;
  trial.prepare();
}

void OutlineContact::prepare() {
  outline_a = std::make_shared<const Outline>(made_outline(first));
  outline_b = std::make_shared<const Outline>(made_outline(second));
  for (const auto& [one, other] : {std::pair(outline_a.get(), outline_b.get()), {outline_b.get(), outline_a.get()}})
    if (const double radius = unfit_for_hollow(*one, *other); radius > 0)
      throw std::invalid_argument(
          "a radius of " + std::to_string(radius) + " m does not fit into the curve's hollow of radius " +
          std::to_string(one->narrowest_hollow()) + " m; take a smaller one, or widen the hollow");
  list_sites();
  if (sites.empty())
    throw std::invalid_argument(
        "two outlines that are both curves or flat have no point that can touch; give one of them as a polygon or "
        "disk, or a flat's partner as a closed profile");
}

/// The corners of both; a disk alone against anything but a disk is enough, and of two disks the second.
void OutlineContact::list_sites() {
  sites.clear();
  const auto add = [&](bool of_second, const Outline& own, const Outline& other) {
    if (other.kind() == Kind::disk && own.kind() != Kind::disk) return;
    if (own.kind() == Kind::disk && other.kind() == Kind::disk && !of_second) return;
    for (std::size_t i = 0; i < own.corners().size(); ++i) sites.push_back({of_second, false, i, other.at_once()});
    if (!other.has_support()) return;
    for (std::size_t i = 0; i < own.faces().size(); ++i) sites.push_back({of_second, true, i});
  };
  add(true, *outline_b, *outline_a);
  add(false, *outline_a, *outline_b);
}

std::size_t OutlineContact::gap_count() const {
  std::size_t count = 0;
  for (const Site& site : sites) count += site.at_once;
  return count;
}

void OutlineContact::gaps(const Scene& scene, std::span<double> out) const {
  Touches all;
  std::size_t i = 0;
  for (const Site& site : sites) {
    find(scene, site, all);
    for (std::size_t k = 0; k < site.at_once; ++k) out[i++] = all[k].gap;
  }
}

/// A place belongs to both bodies; only flats and open curves go on without end.
double OutlineContact::gap_speed(const Scene& scene) const {
  double most = 0;
  if (std::isfinite(outline_a->reach())) most = speed_against(scene, body_b, body_a, outline_a->reach());
  if (std::isfinite(outline_b->reach()))
    most = std::max(most, speed_against(scene, body_a, body_b, outline_b->reach()));
  return most;
}

void OutlineContact::find(const Scene& scene, const Site& site, Touches& out) const {
  const Outline &own = site.of_second ? *outline_b : *outline_a, &seen = site.of_second ? *outline_a : *outline_b;
  const BodyState &owner = body_of(scene, site.of_second ? body_b : body_a),
                  &other = body_of(scene, site.of_second ? body_a : body_b);
  if (site.face)
    out[0] = touch_face(owner, other, seen, own.faces()[site.index]);
  else
    touch_corner(owner, other, seen, own.corners()[site.index], out);
}

/// The normal is that of what is seen, towards the corner. Between two disks the point is the middle of both circles,
/// so that neither of them is the first.
void OutlineContact::touch_corner(const BodyState& owner, const BodyState& other, const Outline& seen,
                                  const Outline::Corner& corner, Touches& out) const {
  const Vec2 centre = owner.point_in_world({corner.centre.x, corner.centre.y});
  const auto w = other.point_in_body(centre);
  Outline::Nears all;
  seen.all_near({w[0], w[1]}, all);
  for (std::size_t k = 0; k < seen.at_once(); ++k) {
    const Vec2 normal = other.vector_in_world({all[k].normal.x, all[k].normal.y});
    const double gap = all[k].distance - corner.radius;
    const double from_centre = corner.radius + (seen.kind() == Outline::Kind::disk ? 0.5 * gap : 0);
    out[k] = {gap, normal, centre - from_centre * normal};
  }
  if (seen.has_support() && (corner.before.x != 0 || corner.before.y != 0)) {
    const Vec2 before = owner.vector_in_world({corner.before.x, corner.before.y}),
               after = owner.vector_in_world({corner.after.x, corner.after.y}), into = -1.0 * out[0].normal;
    if (!(cross(before, into) >= 0 && cross(into, after) >= 0)) out[0].gap = std::abs(out[0].gap);
  }
}

/// The normal is the face's, towards the curve.
ContactPoint OutlineContact::touch_face(const BodyState& owner, const BodyState& other, const Outline& seen,
                                        const Outline::Face& face) const {
  const Vec2 normal = owner.vector_in_world({face.normal.x, face.normal.y}),
             along = owner.vector_in_world({face.along.x, face.along.y});
  const Vec2 from = owner.point_in_world({face.from.x, face.from.y}),
             middle = other.point_in_world({seen.middle().x, seen.middle().y});
  const double outside = dot(normal, middle - from);
  if (!(outside > 0)) return {std::max(-outside, 1e-300), normal, middle};  // it faces away from the curve
  const Vec2 m{-other.c * normal.x - other.s * normal.y, other.s * normal.x - other.c * normal.y};
  const Vec2 c = seen.farthest(m), at = other.point_in_world({c.x, c.y});
  const Vec2 d = at - from;
  const double s = dot(along, d), beyond = std::max(-s, s - face.length);
  const double gap = dot(normal, d) - face.radius;
  // Beyond a side's end the corner sees the curve.
  return {std::isinf(face.length) ? gap : beyond > 0 ? std::max(gap, beyond) : gap, normal, at};
}

ContactPlace OutlineContact::placed(const Site& site, const ContactPoint& point) const {
  const bool from_first = site.of_second != site.face;
  return {from_first ? body_a : body_b, from_first ? body_b : body_a, point};
}

ContactPlace OutlineContact::place(const Scene& scene, std::size_t k) const {
  Touches all;
  auto site = sites.begin();
  for (; k >= site->at_once; ++site) k -= site->at_once;
  find(scene, *site, all);
  return placed(*site, all[k]);
}

ForcePower OutlineContact::evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
  ForcePower sum;
  values = {0, 0, std::numeric_limits<double>::infinity(), 0, 0};
  Touches all;
  std::size_t first = 0;
  for (const Site& site : sites) {
    find(scene, site, all);
    for (std::size_t k = 0; k < site.at_once; ++k) {
      const ContactPoint& c = all[k];
      const bool deepest = c.gap < values[2];
      if (deepest) values[2] = c.gap;
      if (!remembering(*this).acts(first + k, c.gap)) continue;
      ForceValues own{};
      const ForcePower power = remembering(*this).push(scene, first + k, placed(site, c), loads, own);
      values[0] += own[0], values[1] += own[1], values[4] += c.gap < 0;
      if (deepest) values[3] = own[3];
      sum.stored += power.stored, sum.lost += power.lost;
    }
    first += site.at_once;
  }
  return sum;
}

}  // namespace subsoil::mbd
