#include "libdem/packing/moving_bed.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "libdem/laws/bond.hpp"
#include "libdem/particles/rigid_rotation.hpp"
#include "libdem/particles/statistics.hpp"

namespace subsoil::dem {
namespace {

void refuse_block(const char* why) { throw std::invalid_argument(std::string("moving bed: ") + why); }

/// Bonds of cement between all that touch. Blocks come with them, so they are those of the bed at its start.
void cement(Bed& bed) {
  bool any = false;
  for (const Law& law : bed.laws().laws) {
    if (law->bond() == nullptr || law->bond()->replaces_contact()) continue;
    any = true;
    if (law->bond()->time > 0)
      refuse_block("its blocks come in cemented, as the bed is at the start; leave `bond time` out");
  }
  if (any) bed.form_bonds();
}

}  // namespace

PeriodicBlock block_of(Bed& bed, std::span<const int> boundary_of) {
  const PeriodicCell cell = bed.options().periodic;
  if (!(cell.length.x > 0)) refuse_block("its block must be periodic along x");
  PeriodicBlock out{.low = cell.low.x,
                    .length = cell.length.x,
                    .state = {},
                    .clumps = {},
                    .shapes = bed.clump_shapes(),
                    .across = {},
                    .bonds_across = {},
                    .stored = {}};
  bed.freeze();
  cement(bed);
  const std::vector<ContactRecord> contacts = bed.contacts();
  const Bed::State all = bed.save();
  if (all.spheres.empty()) refuse_block("its block holds no sphere");
  std::vector<const Sphere*> by_id;
  for (const Sphere& s : all.spheres) by_id.push_back(&s);
  std::sort(by_id.begin(), by_id.end(), [](const Sphere* a, const Sphere* b) { return a->id < b->id; });
  std::vector<Sphere>& spheres = out.state.spheres;
  for (const Sphere* s : by_id) spheres.push_back(*s);
  std::unordered_map<std::uint32_t, std::uint32_t> number;
  for (Sphere& s : spheres) {
    if (is_fixed(s)) refuse_block("its block must be without fixed spheres");
    const auto k = static_cast<std::uint32_t>(number.size());
    number[s.id] = k;
    s.x = cell.wrapped(s.x), s.v = s.w = {}, s.id = k, s.calm = 0;
  }
  for (Clump c : bed.clumps()) {
    c.position = cell.wrapped(c.position), c.velocity = c.angular_momentum = {};
    c.first_sphere = number.at(c.first_sphere), c.id = c.first_sphere;
    const std::vector<ClumpMember>& members = out.shapes[c.shape].members;
    for (std::size_t m = 0; m < members.size(); ++m) {
      Vec3& x = spheres[c.first_sphere + m].x;  // the period repeats along x
      x.x -= cell.periods(x - c.position - c.attitude.rotate(members[m].at)).x;
    }
    out.clumps.push_back(c);
  }
  /// Periods from that of the first to that of the second.
  const auto across = [&](std::int64_t i, std::int64_t j) {
    const double apart = spheres[static_cast<std::size_t>(j)].x.x - spheres[static_cast<std::size_t>(i)].x.x;
    return std::int64_t{-std::lround(apart / out.length)};
  };
  for (const PairHistory& p : all.pairs) {
    out.state.pairs.push_back({number.at(p.i), number.at(p.j), p.state});
    out.across.push_back(across(out.state.pairs.back().i, out.state.pairs.back().j));
  }
  for (const BondHistory& b : all.bonds) {
    out.state.bonds.push_back({number.at(b.i), number.at(b.j), b.state});
    out.bonds_across.push_back(across(out.state.bonds.back().i, out.state.bonds.back().j));
  }
  for (const SurfaceHistory& c : all.surfaces)
    out.state.surfaces.push_back(
        {number.at(c.sphere), static_cast<std::uint32_t>(boundary_of[c.boundary]), c.normal, c.state});
  for (const ContactRecord& c : contacts) {
    const std::int64_t i = number.at(c.i), j = c.at_surface ? -1 : std::int64_t{number.at(c.j)};
    out.stored.push_back({i, j, j < 0 ? 0 : across(i, j), c.stored});
  }
  return out;
}

double PeriodicBlock::energy() const {
  double sum = 0;
  for (const StoredInContact& c : stored) sum += c.energy;
  return sum;
}

void CarriedSoil::add(const Sphere& s, const Vec3& acceleration) {
  ++spheres, mass += s.m, momentum += s.m * s.v;
  kinetic += kinetic_energy_of(s), gravity -= s.m * dot(acceleration, s.x);
}
void CarriedSoil::add(const Clump& c, const ClumpShape& shape, const Vec3& acceleration) {
  spheres += shape.members.size(), mass += shape.mass, momentum += shape.mass * c.velocity;
  const Vec3 w = angular_velocity_of(c.attitude, shape.inertia, c.angular_momentum);
  kinetic += 0.5 * shape.mass * dot(c.velocity, c.velocity) + 0.5 * dot(w, c.angular_momentum);
  gravity -= shape.mass * dot(acceleration, c.position);
}
void CarriedSoil::add(const CarriedSoil& more) {
  spheres += more.spheres, mass += more.mass, momentum += more.momentum;
  kinetic += more.kinetic, gravity += more.gravity, stored += more.stored;
}

std::vector<long> PeriodicBlock::clump_of_spheres() const {
  std::vector<long> out(size(), -1);
  for (std::size_t k = 0; k < clumps.size(); ++k)
    for (std::size_t m = 0; m < shapes.at(clumps[k].shape).members.size(); ++m)
      out.at(clumps[k].first_sphere + m) = static_cast<long>(k);
  return out;
}

MovingBed::MovingBed(PeriodicBlock block, const MovingBedPlan& plan) : block_(std::move(block)), plan_(plan) {
  if (plan.steps < 1 || !(plan.step > 0) || (plan.direction != 1 && plan.direction != -1))
    refuse_block("at least one step of some length, and a direction of 1 or -1");
  if (block_.size() == 0 || block_.across.size() != block_.state.pairs.size() ||
      block_.bonds_across.size() != block_.state.bonds.size())
    refuse_block("the arrays of its block do not belong together");
  clump_of_ = block_.clump_of_spheres();
  for (std::size_t i = 0; i < block_.size(); ++i) {
    const Clump* const clump = clump_of_[i] < 0 ? nullptr : &block_.clumps[static_cast<std::size_t>(clump_of_[i])];
    largest_ = std::max(largest_, clump != nullptr ? block_.shapes[clump->shape].reach : block_.sphere(i).r);
    const double from_low = (clump != nullptr ? clump->position : block_.sphere(i).x).x - block_.low;
    depth_.push_back(plan.direction > 0 ? from_low : block_.length - from_low);
  }
  held_ = held_length(largest_);
  if (block_.length < held_ || plan.step < held_) {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "the settled bed is %.4g m long and advances by %.4g m: both must be two diameters of the largest grain, %.4g "
        "m, or more",
        block_.length, plan.step, held_);
    refuse_block(text);
  }
}

/// The period behind the start of the window is number -1.
std::uint32_t MovingBed::id(long period, std::size_t sphere) const {
  return static_cast<std::uint32_t>(static_cast<std::size_t>(period + 1) * block_.size() + sphere);
}

Vec3 MovingBed::site(long period, std::size_t sphere) const {
  const double start = plan_.direction > 0 ? plan_.rear - block_.low : plan_.rear - block_.length - block_.low;
  Vec3 x = block_.sphere(sphere).x;
  x.x += start + plan_.direction * (static_cast<double>(period) * block_.length);
  return x;
}

Vec3 MovingBed::place_at_rest(std::uint32_t id) const {
  return site(static_cast<long>(id / block_.size()) - 1, place_in_block(id));
}

/// use(period) for all that have a part in the stretch.
template <class Use>
void MovingBed::each_period(const Stretch& of, const Use& use) const {
  const auto first = static_cast<long>(std::floor(of.low / block_.length)) - 1;
  const auto last = static_cast<long>(std::floor(of.high / block_.length)) + 1;
  for (long period = std::max(first, -1L); period <= last; ++period) use(period);
}

void MovingBed::put_spheres(Bed::State& out, const Stretch& of, bool fixed) const {
  each_period(of, [&](long period) {
    for (std::size_t i = 0; i < block_.size(); ++i) {
      if (!of.holds(along(period, i))) continue;
      Sphere& s = out.spheres.emplace_back(block_.sphere(i));
      s.x = site(period, i), s.id = id(period, i);
      s.kind = fixed || clump_of_[i] >= 0 ? SphereKind::fixed : SphereKind::free;  // of a clump until it is joined
    }
  });
}

/// At rest, where they stand.
std::vector<Clump> MovingBed::clumps_in(const Stretch& of) const {
  std::vector<Clump> out;
  each_period(of, [&](long period) {
    for (const Clump& c : block_.clumps) {
      if (!of.holds(along(period, c.first_sphere))) continue;
      Clump& added = out.emplace_back(c);
      added.position += site(period, c.first_sphere) - block_.sphere(c.first_sphere).x;
      added.first_sphere = added.id = id(period, c.first_sphere);
    }
  });
  return out;
}

double MovingBed::depth_now(const Bed& bed, const Sphere& s) const {
  const long clump = bed.clump_of(s);
  return along((clump < 0 ? s.x : bed.clumps()[static_cast<std::size_t>(clump)].position).x);
}

/// Whether the hindmost sphere of a pair lies in the stretch, the first of it being of this period: its second's
/// period, else kNone.
constexpr long kNone = -1000;
long MovingBed::hindmost(const Stretch& of, long period, std::int64_t i, std::int64_t j, std::int64_t across) const {
  const long second = period + plan_.direction * across;  // counted along the travel
  const double u = std::min(along(period, static_cast<std::size_t>(i)), along(second, static_cast<std::size_t>(j)));
  return of.holds(u) ? second : kNone;
}

/// Pairs and bonds whose hindmost sphere lies in the stretch, and the stretch's contacts at surfaces.
void MovingBed::put_contacts(Bed::State& out, const Stretch& of) const {
  const Bed::State& from = block_.state;
  each_period(of, [&](long period) {
    for (std::size_t k = 0; k < from.pairs.size(); ++k) {
      const PairHistory& p = from.pairs[k];
      const long second = hindmost(of, period, p.i, p.j, block_.across[k]);
      if (second != kNone) out.pairs.push_back({id(period, p.i), id(second, p.j), p.state});
    }
    for (std::size_t k = 0; k < from.bonds.size(); ++k) {
      const BondHistory& b = from.bonds[k];
      const long second = hindmost(of, period, b.i, b.j, block_.bonds_across[k]);
      if (second != kNone) out.bonds.push_back({id(period, b.i), id(second, b.j), b.state});
    }
    for (const SurfaceHistory& c : from.surfaces)
      if (of.holds(along(period, c.sphere)))
        out.surfaces.push_back({id(period, c.sphere), c.boundary, c.normal, c.state});
  });
}

/// Of spheres in the stretch at rest, and contacts as of `put_contacts`.
CarriedSoil MovingBed::content(const Stretch& of, const Vec3& gravity) const {
  CarriedSoil out;
  each_period(of, [&](long period) {
    for (std::size_t i = 0; i < block_.size(); ++i) {
      if (!of.holds(along(period, i)) || clump_of_[i] >= 0) continue;
      const double m = block_.sphere(i).m;
      ++out.spheres, out.mass += m, out.gravity -= m * dot(gravity, site(period, i));
    }
    for (const StoredInContact& c : block_.stored) {
      const bool in = c.j < 0 ? of.holds(along(period, static_cast<std::size_t>(c.i)))
                              : hindmost(of, period, c.i, c.j, c.across) != kNone;
      if (in) out.stored += c.energy;
    }
  });
  for (const Clump& c : clumps_in(of)) out.add(c, block_.shapes[c.shape], gravity);
  return out;
}

/// Pairs of which only one sphere is free are those that reach across the rear end, too. Walls below the window are
/// boundaries that do not meet fixed spheres (Boundary::meets_fixed): their contacts begin and end with those of free
/// ones.
void MovingBed::fill(Bed& bed) const {
  Bed::State all;
  const double front = end_ahead(0);
  put_spheres(all, {-held_, 0}, true);
  put_spheres(all, {0, front}, false);
  put_spheres(all, {front, front + held_}, true);
  Bed::State behind;
  put_contacts(behind, {-held_, 0});
  const auto u = [&](std::uint32_t id) { return along(static_cast<long>(id / block_.size()) - 1, place_in_block(id)); };
  const auto reaches_in = [&](const auto& of) { return u(of.i) >= 0 || u(of.j) >= 0; };
  std::copy_if(behind.pairs.begin(), behind.pairs.end(), std::back_inserter(all.pairs), reaches_in);
  std::copy_if(behind.bonds.begin(), behind.bonds.end(), std::back_inserter(all.bonds), reaches_in);
  put_contacts(all, {0, front});
  bed.insert(all);
  bed.join(clumps_in({0, front}));
}

/// Spheres beyond the held ones that overlap what is put in.
std::vector<std::uint32_t> MovingBed::in_the_way(const Bed& bed, const Bed::State& added) const {
  const double reach = end_ahead(advanced_) + held_ - 2 * largest_;
  std::vector<std::uint32_t> out;
  for (const Sphere& s : bed.spheres()) {
    if (is_fixed(s) || depth_now(bed, s) < reach) continue;
    for (const Sphere& more : added.spheres) {
      const Vec3 apart = s.x - more.x;
      const double near = s.r + more.r;
      if (dot(apart, apart) >= near * near) continue;
      out.push_back(s.id);
      break;
    }
  }
  return out;
}

namespace {

/// Sorted, with all spheres of the clumps that they belong to.
std::vector<std::uint32_t> with_clumps(const Bed& bed, const std::vector<std::uint32_t>& ids) {
  std::vector<std::uint32_t> sorted = ids;
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> out = sorted;
  for (const Clump& c : bed.clumps()) {
    const auto members = static_cast<std::uint32_t>(bed.clump_shapes()[c.shape].members.size());
    const auto first = std::lower_bound(sorted.begin(), sorted.end(), c.first_sphere);
    if (first == sorted.end() || *first >= c.first_sphere + members) continue;
    for (std::uint32_t m = 0; m < members; ++m) out.push_back(c.first_sphere + m);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// Of spheres that are not free, or will not be: held at rest, or taken out.
enum class Fate : char { held, gone };
using Fates = std::unordered_map<std::uint32_t, Fate>;

/// J, stored in contacts that end: of one that is gone, between two that are not free, and at walls.
double energy_that_ends(std::span<const ContactRecord> contacts, const Fates& fates) {
  double out = 0;
  for (const ContactRecord& c : contacts) {
    const auto i = fates.find(c.i), j = c.at_surface ? i : fates.find(c.j);
    const bool i_stays = i == fates.end(), j_stays = j == fates.end();
    const bool one_is_gone = (!i_stays && i->second == Fate::gone) || (!j_stays && j->second == Fate::gone);
    if (one_is_gone || (!i_stays && !j_stays)) out += c.stored;
  }
  return out;
}

}  // namespace

void MovingBed::advance(Bed& bed, std::span<const int> walls) {
  const Vec3 gravity = bed.options().gravity;
  const Stretch next{end_ahead(advanced_), end_ahead(advanced_ + 1)};  // that is let go
  const auto let_go = [&](const Sphere& s) {
    return is_fixed(s) && next.holds(along(static_cast<long>(s.id / block_.size()) - 1, place_in_block(s.id)));
  };
  const auto is_loose = [&](const Sphere& s) { return clump_of_[place_in_block(s.id)] < 0; };
  const double rear = static_cast<double>(advanced_ + 1) * plan_.step;  // from the first rear end

  Bed::State added;
  put_spheres(added, {next.low + held_, next.high + held_}, true);
  put_contacts(added, next);

  const std::vector<ContactRecord> contacts = bed.contacts();
  const std::vector<std::uint32_t> over = with_clumps(bed, in_the_way(bed, added));
  const auto is_over = [&](const Sphere& s) { return std::binary_search(over.begin(), over.end(), s.id); };
  const auto is_behind = [&](const Sphere& s) { return depth_now(bed, s) < rear - held_; };
  const auto leaves = [&](const Sphere& s) { return depth_now(bed, s) < rear || is_over(s); };
  Fates fates;
  for (const Sphere& s : bed.spheres()) {
    if (leaves(s)) {
      fates[s.id] = is_behind(s) || is_over(s) ? Fate::gone : Fate::held;
      if (const long clump = bed.clump_of(s); clump >= 0) {
        const Clump& c = bed.clumps()[static_cast<std::size_t>(clump)];
        if (s.id == c.first_sphere) left_.add(c, block_.shapes[c.shape], gravity);
      } else if (!is_fixed(s)) {
        left_.add(s, gravity);
      }
    } else if (is_fixed(s) && !let_go(s)) {
      fates[s.id] = Fate::held;
    }
  }
  const double ended = energy_that_ends(contacts, fates);
  left_.stored += ended;
  pushed_out_ += over.size();
  const CarriedSoil more = content(next, gravity);
  entered_.add(more);

  bed.insert(added);
  bed.release_if([&](const Sphere& s) { return let_go(s) && is_loose(s); });
  bed.join(clumps_in(next));
  const auto awaits = [&](Fate fate) {
    return [&fates, fate](const Sphere& s) {
      const auto at = fates.find(s.id);
      return at != fates.end() && at->second == fate;
    };
  };
  bed.fix_if(awaits(Fate::held));
  bed.count_removed(ended - more.stored);
  for (const int wall : walls) {
    Boundary& b = bed.boundary(wall);
    b.pose.position.x += plan_.direction * plan_.step;
    b.pose_before = b.pose;  // no motion that does work
  }
  ++advanced_;
  bed.remove_if(awaits(Fate::gone));
}

void MovingBed::archive(Archive& a) {
  a("advanced", advanced_)("pushed out", pushed_out_)("entered", entered_)("left", left_);
}

}  // namespace subsoil::dem
