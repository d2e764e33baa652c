#pragma once
#include <map>
#include <string>
#include <vector>

#include "libmbd/base/body.hpp"
#include "libmbd/base/marker.hpp"
#include "libsim/document/document.hpp"
#include "libsim/keys/former_keys.hpp"
#include "libsim/keys/members.hpp"

namespace subsoil::sim {

struct Material;

/// Where each path of a document stands: "soil.bed.radius", "contacts[0].K_X", "machine.joints.H8".
using Places = std::map<std::string, Place>;

/// Place of a path, or of the nearest enclosing key that stands in the file.
Place place_of(const Places& places, std::string path);

/// What a reading shares: faults, the place of every path read, and what later keys name.
struct Reading {
  explicit Reading(Problems& list) : problems(list) {}
  Problems& problems;
  Places places{};
  std::vector<std::string> body_names{"ground"};             // [0] is ground
  std::vector<mbd::BodyState> body_poses{mbd::BodyState{}};  // start pose
  std::vector<mbd::Marker> markers{};
  std::vector<std::string> input_files{};
  std::vector<FormerKey> former{};                   // names that the file uses
  const std::vector<Material>* materials = nullptr;  // of the scenario that is read; null before its key is read

  /// Null for an index that is no body's.
  const mbd::BodyState* pose_of(int index) const;
};

/// Reads all of `document` by a declaration; unknown keys are refused.
void read_all(const Node& document, Reading& reading, const Declare& declare_document);

}  // namespace subsoil::sim
