#include "libsim/studies/wear/recession.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "libdem/geometry/mesh_edges.hpp"
#include "libdem/geometry/mesh_surface.hpp"
#include "libmbd/base/dense.hpp"

namespace subsoil::sim {
namespace {

using dem::Triangle;
using dem::TriangleMesh;
using dem::Vec3;
using Points = std::vector<Vec3>;

constexpr double smooth_bend = 0.86602540378443865;  // cos 30 deg between the normals of a fan's neighbours
/// Of singular values: two faces that meet at less than 5 deg tell nothing of where their edge moves.
constexpr double same_plane = 0.04;
constexpr double step_share = 0.1;      // of a triangle's height
constexpr double least_height = 0.05;   // of that at the start
constexpr double relaxed_height = 0.6;  // likewise: below it vertices are pulled along the surface
constexpr int most_sweeps = 20;         // of that in a step
constexpr int most_steps = 2000;

/// Triangles around each vertex, parted by sharp edges.
struct Fans {
  std::vector<std::array<std::uint32_t, 3>> at;  ///< by triangle and corner
  std::vector<std::vector<std::uint32_t>> of;    ///< by vertex
  std::size_t count = 0;
};

/// Corners 3 t + i of triangles; joined ones are of one fan.
class Corners {
 public:
  explicit Corners(std::size_t triangles) : above_(3 * triangles) { std::iota(above_.begin(), above_.end(), 0u); }
  std::uint32_t root(std::uint32_t c) {
    while (above_[c] != c) c = above_[c] = above_[above_[c]];
    return c;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    above_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> above_;
};

Fans fans_of(const TriangleMesh& mesh) {
  const std::vector<Triangle>& triangles = mesh.triangles();
  const dem::MeshEdges all(triangles);
  Corners corners(triangles.size());
  const auto low_corner = [](const dem::EdgeUse& use) { return 3 * use.triangle + (use.side + !use.forward) % 3; };
  const auto high_corner = [](const dem::EdgeUse& use) { return 3 * use.triangle + (use.side + use.forward) % 3; };
  for (const dem::MeshEdge& edge : all.edges) {
    if (edge.end - edge.begin != 2) continue;  // where bodies touch
    const dem::EdgeUse &a = all.uses[edge.begin], &b = all.uses[edge.begin + 1];
    if (dot(mesh.normal(a.triangle), mesh.normal(b.triangle)) < smooth_bend) continue;
    corners.join(low_corner(a), low_corner(b)), corners.join(high_corner(a), high_corner(b));
  }
  Fans fans;
  fans.at.resize(triangles.size()), fans.of.resize(mesh.vertices().size());
  std::vector<std::uint32_t> number(3 * triangles.size(), ~0u);
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      std::uint32_t& fan = number[corners.root(3 * t + i)];
      if (fan == ~0u) {
        fan = static_cast<std::uint32_t>(fans.count++);
        fans.of[triangles[t][i]].push_back(fan);
      }
      fans.at[t][i] = fan;
    }
  return fans;
}

double height(const Points& p, const Triangle& t) {
  const Vec3 &a = p[t[0]], &b = p[t[1]], &c = p[t[2]];
  return norm(dem::area_vector(a, b, c)) / std::max({norm(b - a), norm(c - b), norm(a - c)});
}

/// d of each fan.
std::vector<double> depths_of(const TriangleMesh& mesh, const Fans& fans, std::span<const double> volumes) {
  std::vector<double> depth(fans.count), area(fans.count);
  for (std::size_t t = 0; t < volumes.size(); ++t) {
    const double one = norm(dem::area_vector(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2))) / 2;
    for (const std::uint32_t fan : fans.at[t]) depth[fan] += volumes[t], area[fan] += one;
  }
  for (std::size_t f = 0; f < depth.size(); ++f) depth[f] /= area[f];
  return depth;
}

/// Half of the cotangents opposite each edge inside a fan's surface, none below zero.
std::map<std::pair<std::uint32_t, std::uint32_t>, double> weights_of(const TriangleMesh& mesh, const Fans& fans) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> weights;
  for (std::size_t t = 0; t < fans.at.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const Vec3 to_j = mesh.corner(t, j) - mesh.corner(t, i), to_k = mesh.corner(t, k) - mesh.corner(t, i);
      const std::uint32_t a = fans.at[t][static_cast<std::size_t>(j)], b = fans.at[t][static_cast<std::size_t>(k)];
      weights[std::minmax(a, b)] += dot(to_j, to_k) / (2 * norm(cross(to_j, to_k)));
    }
  for (auto& [pair, weight] : weights) weight = std::max(weight, 0.0);
  return weights;
}

/// Four implicit steps of diffusion, each of variance spread^2/4 along every direction in the surface.
void spread_depths(const TriangleMesh& mesh, const Fans& fans, double spread, std::vector<double>& depth) {
  constexpr int steps = 4;
  const double time = spread * spread / (2 * steps);
  const auto n = static_cast<Eigen::Index>(fans.count);
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(n);
  for (std::size_t t = 0; t < fans.at.size(); ++t)
    for (const std::uint32_t fan : fans.at[t])
      mass[fan] += norm(dem::area_vector(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2))) / 6;
  Eigen::VectorXd diagonal = mass;
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [pair, weight] : weights_of(mesh, fans)) {
    diagonal[pair.first] += time * weight, diagonal[pair.second] += time * weight;
    entries.emplace_back(std::max(pair.first, pair.second), std::min(pair.first, pair.second), -time * weight);
  }
  for (Eigen::Index i = 0; i < n; ++i) entries.emplace_back(i, i, diagonal[i]);
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  Eigen::Map<Eigen::VectorXd> values(depth.data(), n);
  for (int k = 0; k < steps; ++k) values = solver.solve(mass.cwiseProduct(values)).cwiseMax(0.0).eval();
}

/// u with N . u = -d for the fans of a vertex.
Vec3 motion_of(const std::vector<std::uint32_t>& fans, const Points& normal, const std::vector<double>& depth) {
  if (std::none_of(fans.begin(), fans.end(), [&](std::uint32_t f) { return depth[f] > 0; })) return {};
  if (fans.size() == 1) {
    const Vec3& n = normal[fans[0]];
    const double square = dot(n, n);
    return square > same_plane * same_plane ? (-depth[fans[0]] / square) * n : Vec3{};
  }
  const auto rows = static_cast<Eigen::Index>(fans.size());
  Eigen::MatrixXd a(rows, 3);
  Eigen::VectorXd b(rows);
  for (Eigen::Index r = 0; r < rows; ++r) {
    const std::uint32_t fan = fans[static_cast<std::size_t>(r)];
    for (int i = 0; i < 3; ++i) a(r, i) = normal[fan][i];
    b[r] = -depth[fan];
  }
  const mbd::SingularValues svd = mbd::singular_values(a);
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 0; k < svd.values.size() && svd.values[k] >= same_plane * svd.values[0]; ++k)
    u += svd.left.col(k).dot(b) / svd.values[k] * svd.right.col(k);
  return {u[0], u[1], u[2]};
}

/// N of each fan.
Points normals_of(const Points& p, const std::vector<Triangle>& triangles, const Fans& fans) {
  Points normal(fans.count);
  std::vector<double> area(fans.count);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3 one = dem::area_vector(p[triangles[t][0]], p[triangles[t][1]], p[triangles[t][2]]);
    for (const std::uint32_t fan : fans.at[t]) normal[fan] += one, area[fan] += norm(one);
  }
  for (std::size_t f = 0; f < normal.size(); ++f) normal[f] *= 1 / area[f];
  return normal;
}

Points motions_of(const Points& p, const std::vector<Triangle>& triangles, const Fans& fans,
                  const std::vector<double>& depth) {
  const Points normal = normals_of(p, triangles, fans);
  Points out;
  for (const std::vector<std::uint32_t>& of : fans.of) out.push_back(motion_of(of, normal, depth));
  return out;
}

/// The volume that a closed mesh loses where its vertices move by s u: a s + b s^2/2 + c s^3/3, from the flux of u
/// through area vectors of edges e + s f. No difference of two volumes, in which a thin layer would drown.
struct Loss {
  double a = 0, b = 0, c = 0;
  Loss(const Points& p, const std::vector<Triangle>& triangles, const Points& u) {
    long double sums[3] = {0, 0, 0};
    for (const Triangle& t : triangles) {
      const Vec3 e1 = p[t[1]] - p[t[0]], e2 = p[t[2]] - p[t[0]], f1 = u[t[1]] - u[t[0]], f2 = u[t[2]] - u[t[0]];
      const Vec3 mean = (-1.0 / 6) * (u[t[0]] + u[t[1]] + u[t[2]]);
      sums[0] += dot(mean, cross(e1, e2));
      sums[1] += dot(mean, cross(e1, f2) + cross(f1, e2));
      sums[2] += dot(mean, cross(f1, f2));
    }
    a = static_cast<double>(sums[0]), b = static_cast<double>(sums[1]), c = static_cast<double>(sums[2]);
  }
  double at(double s) const { return s * (a + s * (b / 2 + s * c / 3)); }
  /// The smallest s that loses the volume, by Newton's method from the linear one; none where there is no such place.
  std::optional<double> factor(double volume) const {
    if (!(a > 0)) return {};
    double s = volume / a;
    for (int k = 0; k < 50; ++k) {
      const double rate = a + s * (b + s * c);
      if (!(rate > 0.1 * a)) return {};
      const double change = (volume - at(s)) / rate;
      s += change;
      if (std::abs(change) <= 1e-16 * std::abs(s)) break;
    }
    return s;
  }
};

/// Why a surface does not recede further, and where.
struct Stuck {
  std::string why;
  Vec3 at;
};

[[noreturn]] void refuse_at(const std::string& why, const Vec3& at) { throw Stuck{why, at}; }

void refuse_bad_input(const TriangleMesh& mesh, std::span<const double> volumes) {
  if (!mesh.closed())
    throw std::invalid_argument("an open surface has no volume to lose; close it, or leave its wear out");
  if (volumes.size() != mesh.triangles().size())
    throw std::invalid_argument(
        fmt::format("{} worn volumes for {} triangles", volumes.size(), mesh.triangles().size()));
  for (std::size_t t = 0; t < volumes.size(); ++t)
    if (!(volumes[t] >= 0) || !std::isfinite(volumes[t]))
      throw std::invalid_argument(fmt::format("triangle {} has lost {} m^3: must be 0 or above", t + 1, volumes[t]));
}

/// Vertices that share an edge with each, and those of them across which it has two fans: along a sharp edge.
struct Neighbours {
  std::vector<std::vector<std::uint32_t>> all, along;
  Neighbours(const std::vector<Triangle>& triangles, const Fans& fans) : all(fans.of.size()), along(fans.of.size()) {
    const dem::MeshEdges edges(triangles);
    const auto fan = [&](const dem::EdgeUse& use, std::uint32_t vertex) {
      const Triangle& t = triangles[use.triangle];
      return fans.at[use.triangle][static_cast<std::size_t>(std::find(t.begin(), t.end(), vertex) - t.begin())];
    };
    for (const dem::MeshEdge& edge : edges.edges) {
      const dem::EdgeUse &first = edges.uses[edge.begin], &last = edges.uses[edge.end - 1];
      for (const auto& [from, to] : {std::pair{edge.low, edge.high}, std::pair{edge.high, edge.low}}) {
        all[from].push_back(to);
        if (fan(first, from) != fan(last, from)) along[from].push_back(to);
      }
    }
  }
};

/// Of a mesh on its way.
class Receding {
 public:
  Receding(const TriangleMesh& mesh, const Fans& fans, const std::vector<double>& depth)
      : triangles_(mesh.triangles()), fans_(fans), depth_(depth), beside_(triangles_, fans), p_(mesh.vertices()) {
    for (const Triangle& t : triangles_) first_.push_back(height(p_, t));
  }
  const Points& vertices() const { return p_; }

  /// Loses up to `most`; returns how much. `factor` grows by the share of the depths.
  double step(double most, double& factor) {
    const double slid = relax();
    const Points u = motions_of(p_, triangles_, fans_, depth_);
    const Loss loss(p_, triangles_, u);
    std::vector<double> heights;
    for (const Triangle& t : triangles_) heights.push_back(height(p_, t));
    std::size_t tight = 0;
    for (double part = most; part > 1e-9 * most; part /= 2) {
      const std::optional<double> s = loss.factor(part - slid);
      if (!s || *s < 0 || !fits(u, *s, heights, tight)) continue;
      for (std::size_t v = 0; v < p_.size(); ++v) p_[v] += *s * u[v];
      factor += *s;
      refuse_shrunk();
      return part;
    }
    refuse_at("its triangles cannot follow the wear", p_[triangles_[tight][0]]);
  }

  void refuse_slow() const {
    std::size_t worst = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (height(p_, triangles_[t]) / first_[t] < height(p_, triangles_[worst]) / first_[worst]) worst = t;
    refuse_at("its triangles cannot follow the wear", p_[triangles_[worst][0]]);
  }

 private:
  /// Pulls the vertices of triangles that have shrunk to the mean of their neighbours, along the surface and along
  /// sharp edges: an edge that recedes would else use up the triangles at it. Returns the volume lost, which is none on
  /// flat faces.
  double relax() {
    const Points before = p_;
    for (int k = 0; k < most_sweeps && sweep(); ++k) {
    }
    Points way = p_;
    for (std::size_t v = 0; v < way.size(); ++v) way[v] -= before[v];
    return Loss(before, triangles_, way).at(1);
  }
  /// False where nothing has shrunk.
  bool sweep() {
    std::vector<double> room(p_.size(), std::numeric_limits<double>::infinity());
    std::vector<char> shrunk(p_.size());
    bool any = false;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const double now = height(p_, triangles_[t]);
      for (const std::uint32_t v : triangles_[t]) {
        room[v] = std::min(room[v], step_share / 2 * now);
        if (now < relaxed_height * first_[t]) shrunk[v] = any = true;
      }
    }
    if (!any) return false;
    const Points normal = normals_of(p_, triangles_, fans_), p = p_;
    for (std::size_t v = 0; v < p_.size(); ++v) {
      if (shrunk[v] == 0 || fans_.of[v].size() > 2) continue;
      const bool edge = fans_.of[v].size() == 2;
      const std::vector<std::uint32_t>& beside = edge ? beside_.along[v] : beside_.all[v];
      if (edge && beside.size() != 2) continue;
      Vec3 way = -p[v];
      for (const std::uint32_t b : beside) way += (1.0 / static_cast<double>(beside.size())) * p[b];
      const Vec3& n = normal[fans_.of[v][0]];
      const Vec3 axis = edge ? cross(n, normal[fans_.of[v][1]]) : n;
      const double square = dot(axis, axis);
      if (!(square > 0)) continue;
      const Vec3 part = (dot(way, axis) / square) * axis;
      way = edge ? part : way - part;
      const double length = norm(way);
      if (length > 0) p_[v] += std::min(0.5, room[v] / length) * way;
    }
    return true;
  }
  bool fits(const Points& u, double s, const std::vector<double>& heights, std::size_t& tight) const {
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Vec3 &a = u[triangles_[t][0]], &b = u[triangles_[t][1]], &c = u[triangles_[t][2]];
      if (s * std::max({norm(b - a), norm(c - b), norm(a - c)}) <= step_share * heights[t]) continue;
      tight = t;
      return false;
    }
    return true;
  }
  void refuse_shrunk() const {
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (height(p_, triangles_[t]) < least_height * first_[t])
        refuse_at(fmt::format("the wear uses up triangle {}, {:.3g} mm high,", t + 1, 1e3 * first_[t]),
                  p_[triangles_[t][0]]);
  }

  const std::vector<Triangle>& triangles_;
  const Fans& fans_;
  const std::vector<double>& depth_;
  Neighbours beside_;
  Points p_;
  std::vector<double> first_;  ///< heights at the start
};

/// Whether the straight path from a to b passes through a triangle, not along it. Moeller and Trumbore, J. Graphics
/// Tools 2 (1997) 21.
bool passes(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q, const Vec3& r) {
  const Vec3 path = b - a, e1 = q - p, e2 = r - p, h = cross(path, e2);
  const double det = dot(e1, h);
  if (std::abs(det) <= 1e-6 * norm(path) * norm(cross(e1, e2))) return false;
  const Vec3 from = a - p, k = cross(from, e1);
  const double u = dot(from, h) / det, v = dot(path, k) / det, t = dot(e2, k) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && t > 1e-6 && t < 1 - 1e-6;
}

/// What lies above a vertex, along its normal up to where it was, was removed: where the new surface passes through it,
/// the vertex has come out at the other side.
void refuse_pierced(const Points& before, const TriangleMesh& after, const Fans& fans) {
  const dem::MeshSurface surface(after);
  const Points normal = normals_of(after.vertices(), after.triangles(), fans);
  std::vector<std::uint32_t> near;
  for (std::uint32_t v = 0; v < before.size(); ++v) {
    const Vec3& b = after.vertices()[v];
    Vec3 n;
    for (const std::uint32_t f : fans.of[v]) n += normal[f];
    const double up = dot(before[v] - b, n) / dot(n, n), way = norm(before[v] - b);
    if (!(up * norm(n) > 1e-9 * way)) continue;  // it has only slid along the surface
    const Vec3 a = b + up * n;
    near.clear();
    surface.candidates(0.5 * (a + b), 0.5 * norm(b - a), near);
    for (const std::uint32_t t : near) {
      const Triangle& corners = after.triangles()[t];
      if (std::find(corners.begin(), corners.end(), v) != corners.end()) continue;
      if (passes(a, b, after.corner(t, 0), after.corner(t, 1), after.corner(t, 2)))
        refuse_at(fmt::format("the wear, {:.3g} mm deep, comes through the opposite side", 1e3 * norm(b - a)),
                  before[v]);
    }
  }
}

/// Whether a side of one triangle passes through another that has no vertex of it.
bool crosses(const TriangleMesh& mesh, const dem::MeshEdge& edge, std::uint32_t t) {
  const Triangle& corners = mesh.triangles()[t];
  if (std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return v == edge.low || v == edge.high; }))
    return false;
  return passes(mesh.vertices()[edge.low], mesh.vertices()[edge.high], mesh.corner(t, 0), mesh.corner(t, 1),
                mesh.corner(t, 2));
}

/// Edges whose ends recede past each other carry the surface through itself, where no vertex need come out. What
/// crossed before, as bodies in one mesh may, is left alone.
void refuse_crossed(const TriangleMesh& before, const TriangleMesh& after) {
  const dem::MeshSurface surface(after);
  const dem::MeshEdges all(after.triangles());
  std::vector<std::uint32_t> near;
  for (const dem::MeshEdge& edge : all.edges) {
    const Vec3 &a = after.vertices()[edge.low], &b = after.vertices()[edge.high];
    near.clear();
    surface.candidates(0.5 * (a + b), 0.5 * norm(b - a), near);
    for (const std::uint32_t t : near)
      if (crosses(after, edge, t) && !crosses(before, edge, t))
        refuse_at("the worn surface passes through itself", before.vertices()[edge.low]);
  }
}

/// Loses the volume by depths in these proportions. Throws Stuck.
Recession recede_by(const TriangleMesh& mesh, const Fans& fans, const std::vector<double>& depth, double all) {
  Recession out{.mesh = mesh};
  Receding receding(mesh, fans, depth);
  while (out.removed < all) {
    const double left = all - out.removed, lost = receding.step(left, out.factor);
    out.removed = lost == left ? all : out.removed + lost;
    if (++out.steps == most_steps) receding.refuse_slow();
  }
  out.mesh = TriangleMesh(receding.vertices(), mesh.triangles());
  refuse_pierced(mesh.vertices(), out.mesh, fans);
  refuse_crossed(mesh, out.mesh);
  return out;
}

/// By halving: how much of the volume can be lost, and what that looks like.
[[noreturn]] void refuse_stuck(const Stuck& stuck, const TriangleMesh& mesh, const Fans& fans,
                               const std::vector<double>& depth, double all) {
  double low = 0, high = 1;
  Recession furthest{.mesh = mesh};
  while (high - low > 0.01 * high && high > 1e-4) {
    const double share = 0.5 * (low + high);
    try {
      furthest = recede_by(mesh, fans, depth, share * all);
      low = share;
    } catch (const Stuck&) {
      high = share;
    }
  }
  const double deepest = recessed(mesh, furthest.mesh).deepest;
  throw RecessionLimit(
      fmt::format("{} at ({:.4g}, {:.4g}, {:.4g}) mm. The surface can lose {:.2g} % of that, {:.3g} mm at its deepest: "
                  "wear it for less, spread the wear over a length, or mesh the surface with larger triangles there",
                  stuck.why, 1e3 * stuck.at.x, 1e3 * stuck.at.y, 1e3 * stuck.at.z, 100 * low, 1e3 * deepest),
      low, deepest);
}

}  // namespace

Recession recede(const TriangleMesh& mesh, std::span<const double> volumes, double spread) {
  refuse_bad_input(mesh, volumes);
  Recession out{.mesh = mesh};
  const double all = std::accumulate(volumes.begin(), volumes.end(), 0.0);
  if (all == 0) return out;
  if (all >= mesh.volume())
    throw std::invalid_argument(fmt::format(
        "{:.4g} m^3 are worn of a body of {:.4g} m^3: nothing is left; wear it for less", all, mesh.volume()));
  const Fans fans = fans_of(mesh);
  std::vector<double> depth = depths_of(mesh, fans, volumes);
  if (spread > 0) spread_depths(mesh, fans, spread, depth);
  try {
    return recede_by(mesh, fans, depth, all);
  } catch (const Stuck& stuck) {
    refuse_stuck(stuck, mesh, fans, depth, all);
  }
}

Recessed recessed(const TriangleMesh& before, const TriangleMesh& after) {
  Recessed out;
  std::vector<double> mean;
  for (std::size_t t = 0; t < before.triangles().size(); ++t) {
    const Vec3 normal = before.normal(t);
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
      const Vec3 way = before.corner(t, i) - after.corner(t, i);
      out.deepest = std::max(out.deepest, dot(way, normal));
      out.farthest = std::max(out.farthest, norm(way));
      sum += dot(way, normal);
    }
    mean.push_back(sum / 3);
  }
  for (std::size_t t = 0; t < mean.size(); ++t)
    if (mean[t] > 0.01 * out.deepest)
      out.area += norm(dem::area_vector(before.corner(t, 0), before.corner(t, 1), before.corner(t, 2))) / 2;
  return out;
}

}  // namespace subsoil::sim
