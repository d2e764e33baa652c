#pragma once

#include <cstddef>
#include <vector>

namespace subsoil::mbd {

/// What wheels of one track have pressed into the ground: the deepest sinkage z >= 0 (m) passed at each x, on a
/// grid, linear between the grid's points. Belongs to the ground, so a second wheel or pass finds it.
/// Storage grows in blocks of 1000 points on either side and is untouched while a wheel stays inside it. Beyond 1e8
/// points from the origin pressing throws std::runtime_error.
class Rut {
 public:
  /// What presses a rut has 256 points of its grid on its length: a wheel on its radius, a stamp on its length. A point
  /// has 1024 on the machine's length: while it rises, what it has just left counts as rut for as far as the grid is
  /// wide.
  static double spacing_for(double size, double machine) { return size > 0 ? size / 256 : machine / 1024; }

  explicit Rut(double spacing = 1e-3) : spacing_(spacing) {}
  double spacing() const { return spacing_; }  ///< of the grid, m

  /// Depth at x and its slope dz/dx there.
  struct Depth {
    double z = 0, slope = 0;
  };
  Depth at(double x) const;
  /// A wheel passed from (x0, z0) to (x1, z1), straight between.
  void press(double x0, double z0, double x1, double z1);
  /// A flat foot stood on [x0, x1] at depth z: every place of it is that deep.
  void press_flat(double x0, double x1, double z);
  /// A disk of this radius stood at x with its lowest point at depth z: its circle, as a parabola.
  void press_disk(double x, double z, double radius);

  bool operator==(const Rut&) const = default;
  template <class A>
  void archive(A& a) {
    a("spacing", spacing_)("first", first_)("depths", depths_);  // grid index, and depths from there on
  }

 private:
  double stored(long i) const;
  void deepen(long i, double z);
  double spacing_;
  long first_ = 0;
  std::vector<double> depths_;
};

}  // namespace subsoil::mbd
