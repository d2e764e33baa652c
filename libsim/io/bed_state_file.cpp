#include "libsim/io/bed_state_file.hpp"

namespace subsoil::sim {

void put_spheres(StateWriter& out, const std::string& folder, const dem::Bed::State& bed) {
  out.put(folder + "spheres", bed.spheres);
  out.put(folder + "ids", bed.ids);
  out.put(folder + "pair ids", bed.pair_ids);
  out.put(folder + "pairs", bed.pairs);
  out.put(folder + "surface ids", bed.surface_ids);
  out.put(folder + "surfaces", bed.surfaces);
}

void read_spheres(const StateReader& in, const std::string& folder, dem::Bed::State& bed) {
  bed.spheres = in.get<double>(folder + "spheres");
  bed.ids = in.get<std::int64_t>(folder + "ids");
  bed.pair_ids = in.get<std::int64_t>(folder + "pair ids");
  bed.pairs = in.get<double>(folder + "pairs");
  bed.surface_ids = in.get<std::int64_t>(folder + "surface ids");
  bed.surfaces = in.get<double>(folder + "surfaces");
}

void put_bed_state(StateWriter& out, const dem::Bed::State& bed) {
  put_spheres(out, "bed/", bed);
  out.put("bed/scalars", bed.scalars);
  if (!bed.kinds.empty()) out.put("bed/kinds", bed.kinds);
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
  read_spheres(in, "bed/", bed);
  bed.scalars = in.get<double>("bed/scalars");
  if (in.has("bed/kinds")) bed.kinds = in.get<std::int64_t>("bed/kinds");
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

}  // namespace subsoil::sim
