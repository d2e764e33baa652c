#include "libsim/io/block_mean.hpp"

#include <algorithm>
#include <cmath>

#include "libsim/base/replicates.hpp"

namespace subsoil::sim {
namespace {

constexpr double block_rounding = 1e-9;  // of a block: of times that are summed up
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

void BlockMean::add(double duration, double value) {
  if (!(duration > 0)) return;
  duration_ += duration, integral_ += duration * value;
  // What ends in the next block is parted: else each block is longer by a part of a step, and of n periods one is
  // missing.
  const double room = length_ - open_.duration;
  if (duration < length_ && duration > room + block_rounding * length_) {
    take(room, value);
    duration -= room;
  }
  take(duration, value);
}

void BlockMean::take(double duration, double value) {
  open_.duration += duration, open_.integral += duration * value;
  if (open_.duration < length_ * (1 - block_rounding)) return;
  blocks_.push_back(open_);
  open_ = {};
  if (blocks_.size() < most) return;
  blocks_ = merged(blocks_);
  for (const Block& b : blocks_) length_ = std::max(length_, b.duration);
}

std::vector<BlockMean::Block> BlockMean::merged(const std::vector<Block>& blocks) {
  std::vector<Block> out;
  for (std::size_t i = 0; i + 1 < blocks.size(); i += 2)
    out.push_back({blocks[i].duration + blocks[i + 1].duration, blocks[i].integral + blocks[i + 1].integral});
  return out;
}

std::vector<BlockMean::Block> BlockMean::longest() const {
  std::vector<Block> level = blocks_;
  while (level.size() >= 2 * least) level = merged(level);
  return level;
}

double BlockMean::mean() const { return duration_ > 0 ? integral_ / duration_ : nan; }

double BlockMean::interval() const {
  double widest = nan;
  for (std::vector<Block> level = blocks_; level.size() >= least; level = merged(level)) {
    std::vector<double> means;
    for (const Block& b : level) means.push_back(b.mean());
    const double width = Replicates(means).half_width();
    widest = std::isnan(widest) ? width : std::max(widest, width);
  }
  return widest;
}

BlockMean::Line BlockMean::line() const {
  std::vector<Block> level = longest();
  if (level.size() < least) return {nan, nan};
  // What is left over behind whole blocks is a shorter one: a force may rise just there.
  const double whole = level.front().duration;
  Block rest{duration_, integral_};
  for (const Block& b : level) rest.duration -= b.duration, rest.integral -= b.integral;
  if (rest.duration > block_rounding * duration_) level.push_back(rest);
  const auto n = static_cast<double>(level.size());
  double centre = 0, middle = 0, weights = 0, at = 0;
  std::vector<double> times, weight;
  for (const Block& b : level) {
    times.push_back(at + b.duration / 2), weight.push_back(b.duration / whole);
    at += b.duration;
    weights += weight.back(), middle += weight.back() * times.back(), centre += weight.back() * b.mean();
  }
  middle /= weights, centre /= weights;
  double xx = 0, xy = 0;
  for (std::size_t i = 0; i < level.size(); ++i) {
    xx += weight[i] * (times[i] - middle) * (times[i] - middle);
    xy += weight[i] * (times[i] - middle) * (level[i].mean() - centre);
  }
  const double slope = xy / xx;
  double left = 0;
  for (std::size_t i = 0; i < level.size(); ++i)
    left += weight[i] * std::pow(level[i].mean() - centre - slope * (times[i] - middle), 2);
  return {slope * duration_, student_t(n - 2) * std::sqrt(left / (n - 2) / xx) * duration_};
}

double BlockMean::trend() const { return line().change; }

bool BlockMean::steady() const {
  const Line l = line();
  constexpr double rounding = 1e-9;  // of the mean: what a constant signal changes by
  return !(std::abs(l.change) > std::max({l.interval, interval(), rounding * std::abs(mean())}));
}

}  // namespace subsoil::sim
