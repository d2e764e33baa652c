#include "libsim/run/wear.hpp"

#include <algorithm>

#include "libsim/base/json.hpp"
#include "libsim/run/frame_loads.hpp"

namespace subsoil::sim {

double archard_volume(const WearSection& wear, const dem::FaceLoad& load) {
  return wear.has_archard() ? *wear.coefficient / *wear.hardness * load.rubbing : 0;
}

double finnie_volume(const WearSection& wear, const dem::FaceLoad& load) {
  return wear.has_finnie() ? *wear.finnie * load.cutting : 0;
}

namespace {

Json wear_json(const WearSection& wear, std::span<const dem::FaceLoad> loads, const std::vector<double>& areas,
               double duration) {
  dem::FaceLoad sum;
  double area = 0, pressed = 0, archard = 0, finnie = 0;
  for (std::size_t t = 0; t < areas.size(); ++t) {
    sum += loads[t], area += areas[t];
    if (areas[t] == 0) continue;  // beyond a periodic side
    if (loads[t].impulse != 0) pressed += areas[t];
    archard = std::max(archard, archard_volume(wear, loads[t]) / areas[t]);
    finnie = std::max(finnie, finnie_volume(wear, loads[t]) / areas[t]);
  }
  Json json{{"area [m2]", area},
            {"area touched [m2]", pressed},
            {"mean normal force [N]", duration > 0 ? sum.impulse / duration : 0},
            {"normal work [J]", sum.normal_work},
            {"shear work [J]", sum.shear_work},
            {"normal force times sliding distance [N m]", sum.rubbing}};
  if (wear.has_archard())
    json["Archard"] = {{"worn volume [m3]", archard_volume(wear, sum)}, {"greatest depth of a triangle [m]", archard}};
  if (wear.has_finnie())
    json["Finnie"] = {{"worn volume [m3]", finnie_volume(wear, sum)}, {"greatest depth of a triangle [m]", finnie}};
  return json;
}

}  // namespace

void write_wear(Summary& summary, const World& world) {
  for (const SurfaceRecord& s : world.surfaces)
    if (s.wear) {
      const FacesOfMesh faces = faces_of(world, s);
      summary.section("wear")[s.name] = wear_json(*s.wear, loads_of(world, s, faces), faces.areas, world.bed->time());
    }
}

}  // namespace subsoil::sim
