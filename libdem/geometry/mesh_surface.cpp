#include "libdem/geometry/mesh_surface.hpp"

#include <algorithm>
#include <limits>

namespace subsoil::dem {

/// Lengths below which two places are one, for a query within `cutoff`. A sphere cannot feel details much finer
/// than itself, so they are relative to the cutoff, and never below the rounding of the coordinates.
struct MeshSurface::Tolerance {
  // A direction that leaves the point p by falling distance must point to the centre by more than this sine. Near the
  // border between two features both then survive and are one contact.
  static constexpr double descent = 1e-9;

  Tolerance(double cutoff, double rounding_of_mesh)
      : rounding(rounding_of_mesh), contains(1e-5 * cutoff + rounding), nearer(1e-12 * cutoff + rounding) {}
  // Whether two minima are one contact, seen from the centre. A hollow curved surface is meshed by facets that bend
  // towards each other; a smooth one has one minimum where they have two beside each of their edges, on r/(R - r) of
  // all places, however fine the mesh. Of two minima closer than this the nearer bears: the elastic energy of the
  // largest overlap is continuous, and stiffness is that of the smooth surface. 0.2 rad: bends of round surfaces of 32
  // facets and more. A shallower corner than that, or two bars that near to each other, bears in turn from either side.
  static constexpr double one_contact = 0.2;
  bool same_contact(const Minimum& a, const Minimum& b) const {
    const Vec3 apart = a.point() - b.point();
    const double limit = std::max(one_contact * a.distance, contains);
    return dot(apart, apart) <= limit * limit;
  }

  double rounding;  // m: of a computed point
  double contains;  // m: a triangle as near as this to a point contains it. Surfaces joined with decimals cut after the
                    // micrometre still fit; too large only moves the border between two features by as much.
  double nearer;    // m: difference of two distances that rounding cannot make. With d = distance, a share of 1e-12
                    // in distance is 1e-6 in direction, which one_contact covers.
};

namespace {

bool contains(const Facet& f, const Vec3& p, double tolerance) {
  if (std::abs(dot(p - f.corner[0], f.normal)) > tolerance) return false;
  for (int i = 0; i < 3; ++i)
    if (dot(p - f.corner[i], f.aside[i]) > tolerance) return false;
  // Only now the exact distance: three half-planes with a margin reach far beyond the tip of a needle.
  return nearest_point(f, p).distance_squared <= tolerance * tolerance;
}

/// Does the triangle cut the stretch from c to p, away from p?
bool cuts(const Facet& f, const Vec3& c, const Vec3& p, double tolerance) {
  const double at_c = dot(c - f.corner[0], f.normal), at_p = dot(p - f.corner[0], f.normal);
  if (std::abs(at_p) <= tolerance || std::abs(at_c) <= tolerance || (at_c > 0) == (at_p > 0)) return false;
  return contains(f, c + (at_c / (at_c - at_p)) * (p - c), tolerance);
}

}  // namespace

void MeshSurface::candidates(const Vec3& c, double cutoff, std::vector<uint32_t>& out) const {
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  const double limit = cutoff * (1 + 1e-9) + rounding_;
  tree_.visit_near(c, limit, [&](uint32_t t) {
    if (nearest_point(facets_[t], c).distance_squared <= limit * limit) out.push_back(t);
  });
  std::sort(out.begin() + first, out.end());
}

uint32_t MeshSurface::nearest_triangle(const Vec3& point) const {
  double best = std::numeric_limits<double>::infinity();
  uint32_t nearest = 0;
  // Points of contacts lie on the surface: the first, narrow look nearly always finds it.
  for (double reach = 1e-9 * bounds_.diagonal() + rounding_; !(best <= reach * reach); reach *= 16) {
    tree_.visit_near(point, reach, [&](uint32_t t) {
      const double distance2 = nearest_point(facets_[t], point).distance_squared;
      if (distance2 < best || (distance2 == best && t < nearest)) best = distance2, nearest = t;
    });
    if (!std::isfinite(reach)) return 0;  // the point is not finite: nobody is near
  }
  // On an edge rounding decides which is nearest: of all that are so to rounding the first, whatever the last bits are.
  const double limit = std::sqrt(best) + 1e-9 * bounds_.diagonal() + rounding_;
  tree_.visit_near(point, limit, [&](uint32_t t) {
    if (t < nearest && nearest_point(facets_[t], point).distance_squared <= limit * limit) nearest = t;
  });
  return nearest;
}

bool MeshSurface::leaves_nearer(uint32_t corner, const Vec3& u, double distance, const Tolerance& tolerance) const {
  const double limit = Tolerance::descent * distance + tolerance.rounding;
  for (uint32_t i = corners_[corner].begin; i < corners_[corner].end; ++i)
    if (dot(u, cone_[i]) > limit) return true;
  return false;
}

bool MeshSurface::is_minimum_by_position(const Minimum& m, const Vec3& c, std::span<const uint32_t> candidates,
                                         const Tolerance& tolerance) const {
  const double nearer = std::max(0.0, m.distance - tolerance.nearer);
  for (const uint32_t t : candidates) {
    if (t == m.triangle || !contains(facets_[t], m.point(), tolerance.contains)) continue;
    if (nearest_point(facets_[t], c).distance_squared < nearer * nearer) return false;
  }
  return true;
}

bool MeshSurface::is_hidden(const Minimum& m, const Vec3& c, std::span<const uint32_t> candidates,
                            const Tolerance& tolerance) const {
  return std::any_of(candidates.begin(), candidates.end(),
                     [&](uint32_t t) { return t != m.triangle && cuts(facets_[t], c, m.point(), tolerance.contains); });
}

const Vec3& MeshSurface::outward(const Minimum& m) const {
  return m.corner == no_corner ? facets_[m.triangle].normal : corners_[m.corner].outward;
}

uint32_t MeshSurface::feature(const Minimum& m) const {
  return m.corner == no_corner ? face_feature_[m.triangle] : corners_[m.corner].feature;
}

SurfaceContact MeshSurface::contact_at(const Minimum& m, const Vec3& c, const Tolerance& tolerance) const {
  const Facet& facet = facets_[m.triangle];
  const Vec3 u = c - m.point();
  const bool inside = facet.sided && dot(u, outward(m)) < 0;
  const double sign = inside ? -1 : 1;
  Vec3 normal;
  if (m.corner == no_corner) {
    // The stored normal, since u loses digits as the distance shrinks. An open surface acts to both sides.
    normal = facet.sided || dot(u, facet.normal) >= 0 ? facet.normal : -facet.normal;
  } else {
    normal = m.distance > tolerance.rounding ? (sign / m.distance) * u : outward(m);
  }
  return {m.point(), normal, sign * m.distance, feature(m), facet.surface};
}

size_t MeshSurface::find_minima(const Vec3& c, double cutoff, std::span<const uint32_t> candidates,
                                const Tolerance& tolerance, Minimum* minima) const {
  size_t count = 0;
  for (const uint32_t t : candidates) {
    const Nearest nearest = nearest_point(facets_[t], c);
    if (nearest.distance_squared > cutoff * cutoff) continue;
    const Vec3& p = nearest.point;
    const double distance = std::sqrt(nearest.distance_squared);
    const bool on_face = nearest.part == Part::face;
    const uint32_t corner = on_face ? no_corner : facets_[t].part_corner[static_cast<int>(nearest.part) - 1];
    if (!on_face && leaves_nearer(corner, c - p, distance, tolerance)) continue;
    // Above a side within a flat face its two triangles tie to rounding. The face goes first: its normal is exact, that
    // of an edge is the direction to a point that may be 1e-8 m aside at the same distance.
    const int handicap = on_face ? 0 : nearest.part <= Part::edge2 ? 1 : 2;
    const Minimum m{p.x, p.y, p.z, distance, distance + handicap * tolerance.nearer, t, corner};
    // All triangles around an edge or a vertex bring the same place; a fan of many must not fill the list.
    const auto brings_it = [&](const Minimum& other) {
      return other.order <= m.order && feature(other) == feature(m) && tolerance.same_contact(other, m);
    };
    if (std::any_of(minima, minima + count, brings_it)) continue;
    if (count == max_minima && m.order >= minima[count - 1].order) continue;
    size_t i = count < max_minima ? count++ : count - 1;
    for (; i > 0 && m.order < minima[i - 1].order; --i) minima[i] = minima[i - 1];
    minima[i] = m;
  }
  return count;
}

size_t MeshSurface::contacts(const Vec3& c, double cutoff, std::span<const uint32_t> candidates, SurfaceContact* out,
                             size_t max) const {
  const Tolerance tolerance(cutoff, rounding_);
  Minimum minima[max_minima];
  const size_t count = find_minima(c, cutoff, candidates, tolerance, minima);
  if (count == 0 || max == 0) return 0;

  // The nearest minimum is the nearest point of the whole surface: always a contact, and it tells inside from outside.
  size_t accepted = 1;  // minima[0 .. accepted) are contacts
  out[0] = contact_at(minima[0], c, tolerance);
  if (out[0].distance < 0) return 1;
  for (size_t i = 1; i < count && accepted < max; ++i) {
    const Minimum m = minima[i];
    const auto same = [&](const Minimum& other) { return tolerance.same_contact(other, m); };
    if (std::any_of(minima, minima + accepted, same)) continue;
    // From behind: sight would refuse it as well, unless the plate is thinner than `contains`; and this is quick.
    if (facets_[m.triangle].sided && dot(c - m.point(), outward(m)) < 0) continue;
    if (!is_minimum_by_position(m, c, candidates, tolerance) || is_hidden(m, c, candidates, tolerance)) continue;
    out[accepted] = contact_at(m, c, tolerance);
    minima[accepted++] = m;
  }
  return accepted;
}

std::optional<FlatFace> MeshSurface::flat_face(const Vec3& c, double margin,
                                               std::span<const uint32_t> candidates) const {
  if (candidates.empty()) return std::nullopt;
  const Facet& first = facets_[candidates.front()];
  const double height = dot(c - first.corner[0], first.normal);
  if ((first.sided ? height : std::abs(height)) <= margin) return std::nullopt;
  const Vec3 foot = c - height * first.normal;
  bool above = false;
  for (const uint32_t t : candidates) {
    const Facet& f = facets_[t];
    // Bends of less than a milliradian are within one feature; a plane must be one to rounding.
    if (face_feature_[t] != face_feature_[candidates.front()] || norm(f.normal - first.normal) > 1e-9)
      return std::nullopt;
    above = above || nearest_point(f, foot).distance_squared <= rounding_ * rounding_;
    for (int i = 0; i < 3; ++i) {
      if (corners_[f.part_corner[i]].feature == face_feature_[t]) continue;
      const double along = std::clamp(dot(foot - f.corner[i], f.along[i]), 0.0, f.length[i]);
      if (norm(foot - f.corner[i] - along * f.along[i]) <= margin) return std::nullopt;
    }
  }
  if (!above) return std::nullopt;
  const Vec3 normal = height > 0 ? first.normal : -first.normal;
  return FlatFace{normal, dot(normal, first.corner[0]), first.surface};
}

}  // namespace subsoil::dem
