#pragma once
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/base/vec3.hpp"

/// Full states, from which a run can start again: named arrays in a file of their own.
namespace subsoil::sim {

/// Types an array of a state may have. A name may hold slashes; they become groups.
template <class T>
concept StateNumber = std::same_as<T, double> || std::same_as<T, float> || std::same_as<T, std::int32_t> ||
    std::same_as<T, std::int64_t> || std::same_as<T, std::uint8_t> || std::same_as<T, std::uint32_t> ||
    std::same_as<T, std::uint64_t>;

/// Collects a state in a file beside `path` and puts it in place by commit(): until then, and in a crash, an older file
/// of that name and all other states stay as they are. Without commit() nothing is left.
class StateWriter {
 public:
  explicit StateWriter(const std::filesystem::path& path);
  ~StateWriter();
  StateWriter(const StateWriter&) = delete;
  StateWriter& operator=(const StateWriter&) = delete;

  template <StateNumber T>
  void put(const std::string& name, std::span<const T> values);
  template <StateNumber T>
  void put(const std::string& name, const std::vector<T>& values) {
    put(name, std::span<const T>(values));
  }
  template <StateNumber T>
  void put(const std::string& name, T value) {
    put(name, std::span<const T>(&value, 1));
  }
  void put_vectors(const std::string& name, std::span<const dem::Vec3> values);
  void put(const std::string& name, const Archive& archive);
  void put_text(const std::string& name, const std::string& text) { put_texts(name, {text}); }
  void put_texts(const std::string& name, const std::vector<std::string>& texts);
  /// States which arrays there are and what they hold; a change in either takes the next number.
  void put_format(std::int64_t number) { put("format", number); }
  void commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What it throws leaves the file's name to whoever reads it, but where the file cannot be opened.
class StateReader {
 public:
  explicit StateReader(const std::filesystem::path& path);
  ~StateReader();
  StateReader(const StateReader&) = delete;
  StateReader& operator=(const StateReader&) = delete;

  /// Throws std::runtime_error unless the file has this format, and for any array that is not among `known`, which may
  /// end in a slash: all of that group.
  void require_format(std::int64_t number, const std::vector<std::string>& known) const;
  bool has(const std::string& name) const;
  /// Throws std::runtime_error naming the array when it is missing or of another type.
  template <StateNumber T>
  std::vector<T> get(const std::string& name) const;
  /// The one value of an array of length 1.
  template <StateNumber T>
  T value(const std::string& name) const;
  std::vector<dem::Vec3> get_vectors(const std::string& name) const;
  Archive archive(const std::string& name) const;
  std::string text(const std::string& name) const;
  std::vector<std::string> texts(const std::string& name) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// DIR/state-0.25.h5 for 0.25 s.
std::filesystem::path state_path(const std::filesystem::path& directory, double time);
/// DIR/checkpoint-0.25.h5: one that the run makes by itself, and takes away again.
std::filesystem::path checkpoint_path(const std::filesystem::path& directory, double time);
/// States and checkpoints in a directory, the latest time first.
std::vector<std::filesystem::path> states_in(const std::filesystem::path& directory);
/// The state of the latest time in a directory, checkpoints left out.
std::optional<std::filesystem::path> latest_state(const std::filesystem::path& directory);

}  // namespace subsoil::sim
