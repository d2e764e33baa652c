#include "apps/output/bed_state_file.hpp"

namespace subsoil::app {

void put_bed_state(StateWriter& out, const dem::Bed::State& bed) {
  out.put("bed/spheres", bed.spheres);
  out.put("bed/ids", bed.ids);
  out.put("bed/pair ids", bed.pair_ids);
  out.put("bed/pairs", bed.pairs);
  out.put("bed/surface ids", bed.surface_ids);
  out.put("bed/surfaces", bed.surfaces);
  out.put("bed/scalars", bed.scalars);
  if (!bed.calm.empty()) out.put("bed/calm", bed.calm), out.put("bed/frozen", bed.frozen);
  if (!bed.clumps.empty()) out.put("bed/clumps", bed.clumps);
  if (!bed.fixed.empty()) out.put("bed/fixed", bed.fixed);
  if (!bed.loads.empty()) out.put("bed/loads", bed.loads);
  if (bed.bonding.empty()) return;
  out.put("bed/bonding", bed.bonding);
  out.put("bed/bond ids", bed.bond_ids);
  out.put("bed/bonds", bed.bonds);
  out.put("bed/broken ids", bed.broken_ids);
  out.put("bed/broken", bed.broken);
}

dem::Bed::State bed_state_of(const StateReader& in) {
  dem::Bed::State bed;
  bed.spheres = in.get<double>("bed/spheres");
  bed.ids = in.get<std::int64_t>("bed/ids");
  bed.pair_ids = in.get<std::int64_t>("bed/pair ids");
  bed.pairs = in.get<double>("bed/pairs");
  bed.surface_ids = in.get<std::int64_t>("bed/surface ids");
  bed.surfaces = in.get<double>("bed/surfaces");
  bed.scalars = in.get<double>("bed/scalars");
  if (in.has("bed/calm")) {
    bed.calm = in.get<std::int64_t>("bed/calm");
    bed.frozen = in.get<double>("bed/frozen");
  }
  if (in.has("bed/clumps")) bed.clumps = in.get<double>("bed/clumps");
  if (in.has("bed/fixed")) bed.fixed = in.get<double>("bed/fixed");
  if (in.has("bed/loads")) bed.loads = in.get<double>("bed/loads");
  if (!in.has("bed/bonding")) return bed;
  bed.bonding = in.get<double>("bed/bonding");
  bed.bond_ids = in.get<std::int64_t>("bed/bond ids");
  bed.bonds = in.get<double>("bed/bonds");
  bed.broken_ids = in.get<std::int64_t>("bed/broken ids");
  bed.broken = in.get<double>("bed/broken");
  return bed;
}

}  // namespace subsoil::app
