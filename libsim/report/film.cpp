#include "libsim/report/film.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "libsim/view/packed.hpp"

namespace subsoil::sim {
namespace {

constexpr std::size_t bytes_per_sphere = 9;
constexpr double rounding = 1e-4;  // of the smallest radius: positions in frames (docs/reference/results-directory.md)
constexpr std::size_t most_triangles = 3000;  // of a surface; a finer mesh is drawn by every so-many-th

struct Bounds {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double v) { low = std::min(low, v), high = std::max(high, v); }
  double size() const { return std::max(1e-12, high - low); }
  unsigned scaled(double v, unsigned top) const {
    return static_cast<unsigned>(std::lround(std::clamp((v - low) / size(), 0.0, 1.0) * top));
  }
};

/// A sphere of the section.
struct Cut {
  float x, y, z, vx, vy, r;
  std::uint32_t index;
};

class FilmMaker {
 public:
  FilmMaker(const FramesFile& file, const FilmOptions& options)
      : file_(file), options_(options), middle_(options.middle) {}

  Json make() {
    const FrameSpheres first = file_.spheres(0, false);
    take_start(first);
    place_slab(first);
    choose_frames(first);
    for (const std::size_t frame : frames_) cuts_.push_back(cut(frame));
    surfaces();
    Json out;
    for (const std::size_t frame : frames_) out["times"].push_back(file_.times()[frame]);
    for (const auto& c : cuts_) out["counts"].push_back(c.size());
    bound();
    out["box"] = {x_.low, y_.low, x_.high, y_.high};
    out["slab"] = {middle_ - half_, middle_ + half_};
    out["all frames"] = file_.times().size();
    out["v max"] = v_max_;
    out["has velocity"] = has_velocity_;
    out["radius"] = {r_.low, r_.high};
    out["depth"] = {start_.low, start_.high};
    out["materials"] = file_.materials();
    out["spheres"] = packed(pack());
    out["surfaces"] = shapes_;
    pack_surfaces(out);
    out["stills"] = stills();
    return out;
  }

 private:
  void take_start(const FrameSpheres& first) {
    start_y_.assign(file_.particles(), std::numeric_limits<float>::quiet_NaN());
    double sum = 0;
    if (file_.is_moving_bed())
      for (std::size_t i = 0; i < start_y_.size(); ++i) start_y_[i] = static_cast<float>(file_.height_at_rest(i));
    for (std::size_t i = 0; i < first.index.size(); ++i) {
      start_y_[first.index[i]] = first.position[3 * i + 1];
      start_.take(first.position[3 * i + 1]);
      sum += file_.radius()[first.index[i]];
    }
    for (const float r : file_.radius()) r_.take(r);
    half_ = first.index.empty() ? 0 : sum / static_cast<double>(first.index.size());
    if (first.index.empty()) start_ = {0, 1}, r_ = {0, 1};
  }

  /// A lattice has nothing between its planes: where a shift by up to a radius finds far more spheres, it is made.
  void place_slab(const FrameSpheres& first) {
    std::size_t most = 0, here = 0;
    double best = middle_;
    for (const int k : {0, 1, -1, 2, -2, 3, -3, 4, -4}) {
      const double z = options_.middle + 0.25 * k * half_;
      std::size_t count = 0;
      for (std::size_t i = 0; i < first.index.size(); ++i)
        count += std::abs(first.position[3 * i + 2] - z) <= half_ ? 1 : 0;
      if (k == 0) here = count;
      if (count > most) most = count, best = z;
    }
    if (3 * here < 2 * most) middle_ = best;
  }

  /// Frames at equal distances, as many as the bytes allow, and the stills.
  void choose_frames(const FrameSpheres& first) {
    std::size_t in_slab = 0;
    for (std::size_t i = 0; i < first.index.size(); ++i)
      in_slab += std::abs(first.position[3 * i + 2] - middle_) <= half_ ? 1 : 0;
    const double room = options_.bytes / static_cast<double>(bytes_per_sphere * std::max<std::size_t>(in_slab, 1));
    const double reading = options_.largest_reading / static_cast<double>(std::max<std::size_t>(file_.particles(), 1));
    const std::size_t all = file_.times().size();
    const std::size_t count =
        std::min(all, static_cast<std::size_t>(std::clamp(std::min(room, reading), 2.0, double(options_.most_frames))));
    for (std::size_t k = 0; k < count; ++k) frames_.push_back(count == 1 ? all - 1 : k * (all - 1) / (count - 1));
    for (const double time : options_.stills) {
      const auto after = std::lower_bound(file_.times().begin(), file_.times().end(), time - 1e-9);
      const auto frame = static_cast<std::size_t>(
          std::min<std::ptrdiff_t>(after - file_.times().begin(), static_cast<std::ptrdiff_t>(all) - 1));
      still_frames_.push_back(frame);
      frames_.push_back(frame);
    }
    std::sort(frames_.begin(), frames_.end());
    frames_.erase(std::unique(frames_.begin(), frames_.end()), frames_.end());
  }

  std::vector<Cut> cut(std::size_t frame) {
    FrameSpheres s = file_.spheres(frame, true);
    file_.put_in_window(frame, s.position);
    const bool moving = s.velocity.size() == s.position.size() && !s.velocity.empty();
    has_velocity_ = has_velocity_ || moving;
    std::vector<Cut> out;
    for (std::size_t i = 0; i < s.index.size(); ++i) {
      const float* p = &s.position[3 * i];
      if (std::abs(p[2] - middle_) > half_) continue;
      out.push_back({p[0], p[1], p[2], moving ? s.velocity[3 * i] : 0, moving ? s.velocity[3 * i + 1] : 0,
                     file_.radius()[s.index[i]], s.index[i]});
    }
    return out;
  }

  void surfaces() {
    for (const FrameSurface& s : file_.surfaces()) {
      if (s.vertices.empty() || s.wall) continue;
      const std::vector<std::size_t> kept = add_shape(s);
      Places places;
      for (std::size_t f = 0; f < (s.moves ? frames_.size() : 1); ++f) {
        std::vector<float> all = s.moves ? file_.surface(frames_[f], s) : s.vertices;
        if (all.empty()) all = s.vertices;
        if (s.moves) file_.put_in_window(frames_[f], all);
        std::vector<float> some;
        for (const std::size_t v : kept)
          for (std::size_t axis = 0; axis < 3; ++axis) some.push_back(all[3 * v + axis]);
        places.push_back(std::move(some));
      }
      places_.push_back(std::move(places));
    }
  }

  /// The shape of a surface, of a fine mesh every so-many-th triangle; returns the vertices that it uses.
  std::vector<std::size_t> add_shape(const FrameSurface& s) {
    const std::size_t count = s.vertices.size() / 3, step = s.triangles.size() / most_triangles + 1;
    std::vector<int> place(count, -1);
    std::vector<std::size_t> kept;
    const auto take = [&](int v) {
      int& p = place.at(static_cast<std::size_t>(v));
      if (p < 0) p = static_cast<int>(kept.size()), kept.push_back(static_cast<std::size_t>(v));
      return p;
    };
    Json triangles = Json::array(), segments = Json::array();
    for (std::size_t k = 0; k < s.triangles.size(); k += step)
      for (const int v : s.triangles[k]) triangles.push_back(take(v));
    for (const auto& e : s.segments)
      for (const int v : e) segments.push_back(take(v));
    if (triangles.empty() && segments.empty())
      for (std::size_t v = 0; v < count; ++v) take(static_cast<int>(v));
    Json shape{{"name", s.name}, {"moves", s.moves}, {"vertices", kept.size()}};
    if (!triangles.empty()) shape["triangles"] = triangles;
    if (!segments.empty()) shape["segments"] = segments;
    if (step > 1) shape["thinned"] = step;
    shapes_.push_back(shape);
    return kept;
  }

  void bound() {
    std::vector<double> speeds;
    for (const auto& c : cuts_)
      for (const Cut& s : c) {
        x_.take(s.x - s.r), x_.take(s.x + s.r), y_.take(s.y - s.r), y_.take(s.y + s.r);
        speeds.push_back(std::hypot(s.vx, s.vy));
      }
    for (const Places& places : places_)
      for (const auto& v : places)
        for (std::size_t i = 0; i + 2 < v.size(); i += 3) x_.take(v[i]), y_.take(v[i + 1]);
    if (x_.low > x_.high) x_ = y_ = {0, 1};
    if (!speeds.empty()) {
      const auto at = speeds.begin() + static_cast<std::ptrdiff_t>(0.998 * static_cast<double>(speeds.size() - 1));
      std::nth_element(speeds.begin(), at, speeds.end());
      v_max_ = std::max(*at, 1e-6);
    }
  }

  std::vector<unsigned char> pack() const {
    std::vector<std::vector<unsigned char>> planes(bytes_per_sphere);
    const auto speed = [&](double v) {
      return static_cast<unsigned char>(128 + std::lround(std::clamp(v / v_max_, -1.0, 1.0) * 127));
    };
    for (const auto& c : cuts_)
      for (const Cut& s : c) {
        const unsigned x = x_.scaled(s.x, 65535), y = y_.scaled(s.y, 65535);
        const float start = start_y_[s.index];
        const unsigned char bytes[bytes_per_sphere] = {
            static_cast<unsigned char>(x & 255U),
            static_cast<unsigned char>(x >> 8U),
            static_cast<unsigned char>(y & 255U),
            static_cast<unsigned char>(y >> 8U),
            speed(s.vx),
            speed(s.vy),
            static_cast<unsigned char>(r_.scaled(s.r, 255)),
            static_cast<unsigned char>(std::isnan(start) ? 0 : start_.scaled(start, 255)),
            static_cast<unsigned char>(file_.material()[s.index])};
        for (std::size_t b = 0; b < bytes_per_sphere; ++b) planes[b].push_back(bytes[b]);
      }
    std::vector<unsigned char> all;
    for (const auto& plane : planes) all.insert(all.end(), plane.begin(), plane.end());
    return all;
  }

  /// Moving surfaces one after another, frame by frame, x then y of every vertex, 16 bits.
  void pack_surfaces(Json& out) const {
    std::vector<unsigned char> low, high;
    const auto put = [&](unsigned v) {
      low.push_back(static_cast<unsigned char>(v & 255U)), high.push_back(static_cast<unsigned char>(v >> 8U));
    };
    for (const Places& places : places_)
      for (const auto& v : places)
        for (std::size_t axis = 0; axis < 2; ++axis)
          for (std::size_t i = axis; i < v.size(); i += 3) put((axis == 0 ? x_ : y_).scaled(v[i], 65535));
    low.insert(low.end(), high.begin(), high.end());
    out["surface places"] = packed(low);
  }

  Json stills() const {
    Json list = Json::array();
    for (const std::size_t frame : still_frames_) {
      const auto at =
          static_cast<std::size_t>(std::lower_bound(frames_.begin(), frames_.end(), frame) - frames_.begin());
      std::vector<ChainSphere> spheres;
      for (const Cut& c : cuts_[at]) spheres.push_back({c.x, c.y, c.z, c.r, file_.material()[c.index]});
      list.push_back(still(at, spheres, chains(spheres, options_.force)));
    }
    return list;
  }

  Json still(std::size_t at, const std::vector<ChainSphere>& spheres, const std::vector<Chain>& found) const {
    double largest = 0, mean = 0, moved = 0;
    for (const Chain& c : found) largest = std::max(largest, std::abs(c.size));
    std::vector<unsigned char> bytes;
    for (std::uint32_t Chain::*row : {&Chain::a, &Chain::b})
      for (unsigned shift = 0; shift < 32; shift += 8)
        for (const Chain& c : found) bytes.push_back(static_cast<unsigned char>((c.*row >> shift) & 255U));
    for (const Chain& c : found) bytes.push_back(static_cast<unsigned char>(128 + std::lround(127 * c.size / largest)));
    // What a shift by the rounding of the frames does to the chains, in the mean.
    for (const Chain& c : found) {
      const ChainSphere &a = spheres[c.a], &b = spheres[c.b];
      const double overlap = a.r + b.r - std::hypot(a.x - b.x, a.y - b.y, a.z - b.z), shift = rounding * r_.low;
      mean += std::abs(c.size);
      moved += std::abs(options_.force.known() ? options_.force(a, b, overlap + shift) - c.size : rounding);
    }
    const double count = static_cast<double>(std::max<std::size_t>(found.size(), 1));
    return {{"frame", at},           {"pairs", found.size()},       {"largest", largest},
            {"mean", mean / count},  {"resolution", moved / count}, {"unit", options_.force.known() ? "N" : "1"},
            {"bytes", packed(bytes)}};
  }

  using Places = std::vector<std::vector<float>>;  // per frame
  const FramesFile& file_;
  const FilmOptions& options_;
  std::vector<std::size_t> frames_, still_frames_;
  std::vector<std::vector<Cut>> cuts_;
  std::vector<float> start_y_;  // by index; NaN: not in the first frame
  Bounds x_, y_, r_, start_;
  std::vector<Places> places_;
  Json shapes_ = Json::array();
  double middle_, half_ = 0, v_max_ = 1e-6;
  bool has_velocity_ = false;
};

}  // namespace

Json film(const FramesFile& file, const FilmOptions& options) {
  if (file.times().empty()) throw std::runtime_error("holds no complete frame");
  return FilmMaker(file, options).make();
}

}  // namespace subsoil::sim
