#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "libsim/post/frames_file.hpp"

namespace subsoil::sim {

/// Pictures of a run's frames: the section one mean diameter thick through the middle of what moves, seen along z. All
/// on one scale, which takes in the soil but for a fiftieth that flies or rolls off, and every moving surface.
class SectionFilm {
 public:
  /// `frames`: which of the file's; `width`: pixels.
  SectionFilm(const FramesFile& file, std::vector<std::size_t> frames, std::string name, int width);

  std::size_t count() const { return frames_.size(); }
  /// The gnuplot script of a PNG.
  std::string script(std::size_t picture) const;

 private:
  struct Cut {
    float x, y, z, r, speed;
  };
  struct Side {
    double low, high;
  };
  /// An axis' numbers as they come.
  using Numbers = std::vector<double>;

  void find_middle();
  void bound();
  std::vector<Cut> cut(std::size_t frame) const;
  std::vector<float> vertices(std::size_t frame, const FrameSurface& s) const;
  std::string surface_block(const std::string& block, std::size_t frame, const FrameSurface& s) const;

  const FramesFile& file_;
  std::vector<std::size_t> frames_;
  std::string name_;
  int width_, height_ = 0;
  double middle_ = 0, half_ = 0, fastest_ = 0;
  Side x_{0, 1}, y_{0, 1};
};

}  // namespace subsoil::sim
