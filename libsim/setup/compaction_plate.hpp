#pragma once
#include "coupling/servo.hpp"
#include "libdem/packing/settle.hpp"

namespace subsoil::sim {

/// A rigid plate that a servo presses on a bed while it settles.
class CompactionPlate final : public dem::BedLoad {
 public:
  /// @param boundary the plate, at y = 0 of its own axes @param step of settling, s
  CompactionPlate(const dem::Bed& bed, int boundary, double pressure, double step);

  void begin(dem::Bed& bed) override;
  void advance(dem::Bed& bed, double dt) override;
  bool holds() const override;
  std::string state() const override;
  void end(dem::Bed& bed) override;
  Archive::Columns save() const override;
  void restore(const Archive::Columns& saved) override;

 private:
  void archive(Archive& a);

  int boundary_;
  double area_;  ///< m2
  coupling::Servo servo_;
  coupling::ServoState now_;
  double start_ = 0;  ///< height of the plate, m
};

}  // namespace subsoil::sim
