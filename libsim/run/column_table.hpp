#pragma once
#include <span>
#include <string>

#include "libsim/setup/fibre_facts.hpp"
#include "libsim/setup/world.hpp"

/// The one list of what series.csv holds: name, unit, meaning and where the number comes from. `Columns` reads it for
/// every run, docs/reference/output-variables.md shows it.
namespace subsoil::sim {

struct ColumnSources {
  const World& world;
  const coupling::Simulation& simulation;
  BuriedFibres& buried;
};

/// What a row holds of a column, and when it is read.
enum class Taken {
  instant,  ///< before the step, at t_n
  step,     ///< after it: forces of t_n, which only the step computes
  sample    ///< after it, in steps that end a row's interval: sums over all spheres
};

/// One column of an owner: OWNER and `name` make its name in the file.
template <class Owner>
struct ColumnOf {
  const char* name;
  const char* unit;
  double (*value)(const ColumnSources&, const Owner&);
  bool in_summary = false;
  bool whole = false;       ///< a whole number, which has no value between two instants
  bool of_machine = false;  ///< known where the machine's windows end
};

/// The columns of all owners of one kind, in their order.
template <class Owner>
struct ColumnFamily {
  const char* owner;  ///< as documents show it
  Taken taken;
  std::span<const ColumnOf<Owner>> columns;
  const char* meaning;
};

struct SoilOnBody {
  int body;
};
struct SoilAsWhole {};
struct FibresOfWorld {
  std::size_t index;
};
struct InletOfWorld {
  std::size_t index;
};

extern const ColumnFamily<SoilOnBody> soil_on_body_columns;
extern const ColumnFamily<SurfaceRecord> surface_columns;
extern const ColumnFamily<FixedBody> fixed_columns;
extern const ColumnFamily<SurfaceRecord> path_columns;   ///< of boundaries that a given motion moves
extern const ColumnFamily<SurfaceRecord> servo_columns;  ///< of boundaries with a servo
extern const ColumnFamily<SoilAsWhole> draft_columns;    ///< with a machine
extern const ColumnFamily<SoilAsWhole> bed_columns;
extern const ColumnFamily<SoilAsWhole> bond_columns;    ///< where a law has bonds
extern const ColumnFamily<SoilAsWhole> force_columns;   ///< with forces of a program on the spheres
extern const ColumnFamily<SoilAsWhole> frozen_columns;  ///< with an active region
extern const ColumnFamily<SoilAsWhole> window_columns;  ///< of a moving bed
extern const ColumnFamily<InletOfWorld> inlet_columns;
extern const ColumnFamily<FibresOfWorld> fibre_columns;

/// A group of the machine's columns as libmbd names them: OWNER.name, or OWNER's own where it is a fixed word.
struct MachineColumns {
  std::string owner;
  std::vector<std::pair<std::string, std::string>> columns;  ///< name, unit
  const char* meaning;
};
std::vector<MachineColumns> machine_columns();

/// The table of all columns for docs/reference/output-variables.md.
std::string columns_markdown();

}  // namespace subsoil::sim
