#include "libsim/scenario/sections/placement.hpp"

#include <cmath>

#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/keys/printer.hpp"
#include "libsim/keys/reader.hpp"
#include "libsim/keys/schema.hpp"

namespace subsoil::sim {

namespace {

/// Angles about the world's axes, made one rotation.
class Turns final : public Compound {
 public:
  explicit Turns(Rotation& rotation) : rotation_(rotation) {}
  void read(Reader& reader, const Field& field) override {
    reader.leaf(field, [&](const Node& node) {
      if (reader.holds("axis") || reader.holds("angle"))
        throw Refusal("stands beside `axis` and `angle`, which have the same meaning", "keep one of them");
      const std::vector<double> a = numbers_of(node, "rad", 3);
      const auto turn = [](const Vec3& v) { return dem::Quaternion::from_rotation_vector(v); };
      const dem::Quaternion q = turn({0, 0, a[2]}) * turn({0, a[1], 0}) * turn({a[0], 0, 0});
      const Vec3 v{q.x, q.y, q.z};
      const double sine = dem::norm(v);
      if (sine > 0) rotation_ = {v * (1 / sine), 2 * std::atan2(sine, q.w)};
    });
  }
  void print(Printer&, const Field&) const override {}
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "3 numbers rad", "left out", "", field.meaning);
  }
  void outline(Schema& schema, const Field& field) const override {
    schema.add(field, numbers_form("rad", 3));
    for (const char* other : {"axis", "angle"}) schema.rule(not_beside(field.key, other));
  }

 private:
  Rotation& rotation_;
};

}  // namespace

void describe(Fields& v, Rotation& r) {
  v.vector("axis", r.axis, "1", "axis of the rotation; any length");
  v.quantity("angle", r.angle, "rad", "(-inf, inf)", "angle about it, right-handed");
  Turns turns(r);
  v.visit_compound({"turns", "instead of both: angles about the world's x, then y, then z axis"}, turns);
}

void describe(Fields& v, Box& b) {
  v.vector("size", b.size, "m", "edge lengths x y z");
  v.vector("at", b.at, "m", "its corner of least coordinates");
}

}  // namespace subsoil::sim
