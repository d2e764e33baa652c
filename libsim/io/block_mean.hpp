#pragma once
#include <limits>
#include <vector>

#include "libdem/base/archive.hpp"

namespace subsoil::sim {

/// Mean of a correlated signal over time with an interval, by block averaging (Flyvbjerg & Petersen 1989).
///
/// The signal is cut into blocks of equal duration, 32 to 63 once there are as many samples; neighbours are merged
/// while 6 are left. With n blocks of means m_i
///   s = sqrt( sum (m_i - m)^2 / (n (n - 1)) )
/// is the standard error of m if blocks are as long as the signal's memory, and too small otherwise: the maximum s of
/// all levels counts. The interval is t s with Student's t of 95 % and n - 1 degrees of freedom.
/// The trend is the change over the whole time of the straight line through the longest blocks (least squares). It is
/// a trend, and the signal not steady, when it is larger than its own interval of 95 % and than that of the mean.
/// Source: H. Flyvbjerg, H. G. Petersen, J. Chem. Phys. 91 (1989) 461.
class BlockMean {
 public:
  /// Blocks no shorter than this, s: of a periodic signal its period, for which blocks of parts of it know nothing.
  void take_blocks_of(double length) { length_ = length; }
  /// The value that held over `duration` s.
  void add(double duration, double value);

  double duration() const { return duration_; }
  double mean() const;
  double interval() const;  ///< half width; NaN below 6 blocks
  double trend() const;     ///< change over duration(); NaN below 6 blocks
  bool steady() const;      ///< true below 6 blocks: nothing is known

  void archive(Archive& a) {
    a("blocks", blocks_)("open", open_)("length", length_)("duration", duration_)("integral", integral_);
  }

 private:
  struct Block {
    double duration = 0, integral = 0;
    double mean() const { return integral / duration; }
    void archive(Archive& a) { a("duration", duration)("integral", integral); }
  };
  struct Line {
    double change, interval;
  };
  void take(double duration, double value);  ///< into the open block
  static std::vector<Block> merged(const std::vector<Block>& blocks);
  std::vector<Block> longest() const;
  Line line() const;

  static constexpr std::size_t most = 64, least = 6;
  std::vector<Block> blocks_;  ///< complete ones
  Block open_;
  double length_ = 0;  ///< s, of a complete block at least
  double duration_ = 0, integral_ = 0;
};

}  // namespace subsoil::sim
