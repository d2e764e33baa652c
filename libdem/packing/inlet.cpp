#include "libdem/packing/inlet.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "libdem/packing/carve.hpp"
#include "libdem/particles/fixed.hpp"

namespace subsoil::dem {
namespace {

/// Places that are tried for a grain. Room for one in fifty parts of the region is found with a chance of 98 %; in a
/// region less free than that the next interval is better.
constexpr int kAttempts = 200;

[[noreturn]] void refuse_inlet(const std::string& what) { throw std::invalid_argument("inlet: " + what); }

std::string millimetres(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g mm", length * 1e3);
  return text;
}

/// Seeds of streams that have nothing in common (Steele et al. 2014, SplitMix64).
std::uint64_t mixed(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t z = seed + 0x9e3779b97f4a7c15ULL * (stream + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// Draws centres of grains that the region holds. A clump lies within the sphere of its reach.
struct DrawCentre {
  double radius;
  RandomNumbers& random;

  Vec3 operator()(const Bounds& box) const {
    Vec3 x;
    for (int d = 0; d < 3; ++d) x[d] = random.uniform(box.low[d] + radius, box.high[d] - radius);
    return x;
  }
  Vec3 operator()(const InletDisk& disk) const {
    const Vec3 n = (1 / norm(disk.normal)) * disk.normal;
    const Vec3 across = cross(n, std::abs(n.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
    const Vec3 u = (1 / norm(across)) * across, v = cross(n, u);
    const double out = (disk.radius - radius) * std::sqrt(random.uniform()), angle = 2 * M_PI * random.uniform();
    return disk.centre + (out * std::cos(angle)) * u + (out * std::sin(angle)) * v;
  }
};

struct BoxAround {
  Bounds operator()(const Bounds& box) const { return box; }
  Bounds operator()(const InletDisk& disk) const {
    const Vec3 r{disk.radius, disk.radius, disk.radius};
    return {disk.centre - r, disk.centre + r};
  }
};

struct RefuseSmall {
  double diameter;
  void operator()(const Bounds& box) const {
    for (int d = 0; d < 3; ++d)
      if (!(box.high[d] - box.low[d] >= diameter * (1 - 1e-9)))
        refuse_inlet("the box is " + millimetres(box.high[d] - box.low[d]) + " long in " + "xyz"[d] +
                     ", less than the diameter " + millimetres(diameter) +
                     " of its largest grain; enlarge it, or choose smaller grains");
  }
  void operator()(const InletDisk& disk) const {
    if (!(norm(disk.normal) > 0)) refuse_inlet("the normal of the disk must not be zero");
    if (!(2 * disk.radius >= diameter * (1 - 1e-9)))
      refuse_inlet("the disk is " + millimetres(2 * disk.radius) + " wide, less than the diameter " +
                   millimetres(diameter) + " of its largest grain; enlarge it, or choose smaller grains");
  }
};

/// What is in the region or reaches into it.
class Occupied {
 public:
  Occupied(const Bed& bed, const Bounds& region, double largest) : bed_(bed), cell_(bed.options().periodic) {
    const LawTable& table = bed.laws();
    for (const Law& law : table.laws) gap_ = std::max(gap_, law->cutoff(largest));
    double reach = 0;
    for (const Sphere& s : bed.spheres()) reach = std::max(reach, s.r);
    reach += largest + gap_;
    for (const Sphere& s : bed.spheres()) {
      const Vec3 near = region.centre() + cell_.shortest(s.x - region.centre());
      if (region.distance_squared(near) < reach * reach) spheres_.push_back(s);
    }
    for (int b = 0; b < bed.boundary_count(); ++b)
      if (bed.boundary(b).active) boundaries_.push_back(b);
  }
  void add(const std::vector<Sphere>& grain) { spheres_.insert(spheres_.end(), grain.begin(), grain.end()); }

  /// Nothing within reach of a force.
  bool lets(const std::vector<Sphere>& grain) const {
    return std::all_of(grain.begin(), grain.end(), [&](const Sphere& s) { return lets(s); });
  }

 private:
  bool lets(const Sphere& s) const {
    for (const Sphere& other : spheres_) {
      const Vec3 apart = cell_.shortest(s.x - other.x);
      const double near = s.r + other.r + gap_;
      if (dot(apart, apart) < near * near) return false;
    }
    return std::none_of(boundaries_.begin(), boundaries_.end(),
                        [&](int b) { return inside_or_overlapping(s, bed_.boundary(b), gap_); });
  }

  const Bed& bed_;
  const PeriodicCell& cell_;
  double gap_ = 0;  ///< across which a law acts, m
  std::vector<Sphere> spheres_;
  std::vector<int> boundaries_;
};

/// Of all spheres that the inlet pours, m.
double largest_sphere(const InletPlan& plan) {
  double largest = 0, share = 0;
  for (const ClumpPart& part : plan.clumps) {
    share += part.share;
    for (const ClumpMember& m : plan.shapes[static_cast<std::size_t>(part.shape)].members)
      largest = std::max(largest, m.radius);
  }
  return share < 1 - 1e-9 ? std::max(largest, largest_radius(plan.radius)) : largest;
}

}  // namespace

std::vector<Sphere> InletGrain::spheres(const std::vector<ClumpShape>& shapes) const {
  if (shape < 0) return {body};
  const ClumpShape& clump = shapes[static_cast<std::size_t>(shape)];
  const std::vector<double> share = shares_by_volume(clump);
  std::vector<Sphere> out(clump.members.size(), body);
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k].x = body.x + attitude.rotate(clump.members[k].at);
    out[k].r = clump.members[k].radius;
    out[k].m = clump.mass * share[k];
    out[k].id = body.id + static_cast<std::uint32_t>(k);
  }
  return out;
}

Inlet::Stream::Stream(const InletPlan& plan)
    : sampler_(plan.radius, plan.shares),
      random_(mixed(plan.seed, 0)),
      of_(plan.of),
      clumps_(plan.clumps),
      first_id_(plan.first_id),
      id_step_(plan.id_step) {
  for (const ClumpPart& part : clumps_) masses_.push_back(plan.shapes.at(static_cast<std::size_t>(part.shape)).mass);
  draw();
}

void Inlet::Stream::draw() {
  next_ = {};
  Sphere& body = next_.body;
  if (const ClumpPart* const part = draw_part(clumps_, random_); part != nullptr) {
    next_.shape = part->shape;
    next_.attitude = any_attitude(random_);
    body.r = part->reach;
    body.m = masses_[static_cast<std::size_t>(part - clumps_.data())];
    body.kind = SphereKind::member;
  } else {
    body.r = sampler_.draw(random_);
    body.m = of_.density * sphere_volume(body.r);
    body.kind = SphereKind::free;
  }
  body.id = first_id_ + number_ * id_step_;
  body.material = static_cast<std::uint16_t>(of_.material);
}

void Inlet::Stream::pass() {
  mass_ += next_.body.m;
  ++number_;
  draw();
}

bool Inlet::is_due(const Stream& stream, double asked) const {
  return (plan_.counts ? stream.number() + 0.5 : stream.before() + 0.5 * stream.next().body.m) <= asked;
}

Inlet::Inlet(InletPlan plan) : plan_(std::move(plan)) {
  if (!(plan_.rate > 0)) refuse_inlet("the rate must be above zero");
  if (!(plan_.interval > 0)) refuse_inlet("the interval must be above zero");
  if (!(plan_.from < plan_.until)) refuse_inlet("must open before it closes");
  if (!(plan_.of.density > 0)) refuse_inlet("the density must be above zero");
  std::visit(RefuseSmall{2 * largest_reach(plan_.radius, plan_.clumps)}, plan_.region);
  state_.first_id = plan_.first_id, state_.interval = plan_.interval;
  static_cast<void>(Stream{plan_});  // refuses a distribution without sense
}

double Inlet::asked(double time) const { return plan_.rate * std::max(0.0, std::min(time, plan_.until) - plan_.from); }

std::size_t Inlet::pour(Bed& bed, double last_step) {
  const double time = bed.time(), asked = this->asked(time);
  if (!stream_) restore(state_);
  if (!is_due(*stream_, asked)) return 0;
  const auto turn = static_cast<std::int64_t>(std::floor((time - plan_.from) / plan_.interval + 1e-6));
  if (turn <= state_.turn || time > plan_.until + plan_.interval) return 0;
  state_.turn = turn;

  Occupied occupied(bed, std::visit(BoxAround{}, plan_.region), largest_sphere(plan_));
  RandomNumbers random(mixed(plan_.seed, static_cast<std::uint64_t>(turn) + 1));
  const Vec3 gravity = bed.options().gravity;
  Bed::State in;
  std::vector<ClumpSpec> clumps;
  CarriedSoil more;
  while (is_due(*stream_, asked)) {
    InletGrain grain = stream_->next();
    Sphere& s = grain.body;
    bool placed = false;
    for (int k = 0; k < kAttempts && !placed; ++k) {
      s.x = std::visit(DrawCentre{s.r, random}, plan_.region);
      placed = occupied.lets(grain.spheres(plan_.shapes));
    }
    if (!placed) {
      ++state_.waited;
      break;
    }
    s.v = plan_.velocity;
    more.add(s, gravity);
    occupied.add(grain.spheres(plan_.shapes));
    s.v -= (0.5 * last_step) * gravity;  // of half a step before
    if (grain.shape < 0)
      in.spheres.push_back(s);
    else
      clumps.push_back({grain.shape, s.x, grain.attitude, s.v, {}, s.material, s.id});
    stream_->pass();
  }
  if (more.spheres == 0) return 0;
  if (!in.spheres.empty()) bed.insert(in);
  bed.add(clumps);
  bed.count_removed(-more.energy());
  state_.poured.add(more);
  return more.spheres;
}

double Inlet::smallest_radius() const {
  double smallest = least_radius(plan_.radius);
  for (const ClumpPart& part : plan_.clumps)
    for (const ClumpMember& m : plan_.shapes[static_cast<std::size_t>(part.shape)].members)
      smallest = std::min(smallest, m.radius);
  return smallest;
}

std::vector<InletGrain> Inlet::due_by(double time) const {
  std::vector<InletGrain> out;
  const double all = asked(time);
  for (Stream stream(plan_); is_due(stream, all); stream.pass()) out.push_back(stream.next());
  return out;
}

void Inlet::restore(const InletState& state) {
  state_ = state;
  plan_.first_id = state.first_id, plan_.interval = state.interval;
  stream_.emplace(plan_);
  for (std::size_t k = 0; k < state.poured.spheres; ++k) stream_->pass();
}

}  // namespace subsoil::dem
