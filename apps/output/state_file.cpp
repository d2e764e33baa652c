#include "apps/output/state_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "apps/output/atomic_file.hpp"
#include "apps/output/hdf5.hpp"

namespace subsoil::app {

struct StateWriter::Impl {
  std::filesystem::path path;
  h5::Handle file;
};

StateWriter::StateWriter(const std::filesystem::path& path)
    : impl_(new Impl{path, h5::create_file(temporary_name(path))}) {}

StateWriter::~StateWriter() {
  if (!impl_->path.empty()) {
    impl_->file = {};
    std::error_code ignored;
    std::filesystem::remove(temporary_name(impl_->path), ignored);
  }
}

template <StateNumber T>
void StateWriter::put(const std::string& name, std::span<const T> values) {
  // Short arrays stay as they are; gzip on noise of long ones costs time and gains little, but ids and flags shrink.
  h5::write(impl_->file, name, values, 1, values.size() > 1024 ? 1 : -1);
}

void StateWriter::put_vectors(const std::string& name, std::span<const dem::Vec3> values) {
  static_assert(sizeof(dem::Vec3) == 3 * sizeof(double));
  h5::write(impl_->file, name, values.data(), h5::type_of<double>(),
            {values.size(), 3, h5::type_of<double>(), values.size() > 1024 ? 1 : -1});
}

void StateWriter::put_text(const std::string& name, const std::string& text) {
  h5::write_text(impl_->file, name, {text});
}

void StateWriter::commit() {
  h5::flush_to_disk(impl_->file);
  impl_->file = {};
  put_in_place(impl_->path);
  impl_->path.clear();
}

struct StateReader::Impl {
  std::filesystem::path path;
  h5::Handle file;
};

StateReader::StateReader(const std::filesystem::path& path) : impl_(new Impl{path, h5::open_file(path)}) {}
StateReader::~StateReader() = default;

void StateReader::require_format(std::int64_t number, const std::vector<std::string>& known) const {
  const std::string file = impl_->path.string();
  const auto refuse = [&](const std::string& what) {
    throw std::runtime_error(fmt::format(
        "{}: {}; this version reads states of format {}: go on with the version that wrote it, or start the "
        "run anew",
        file, what, number));
  };
  if (!has("format")) refuse("is no state, or one from before states had a format number");
  if (const auto its = value<std::int64_t>("format"); its != number) refuse(fmt::format("is of format {}", its));
  for (const std::string& name : h5::dataset_names(impl_->file)) {
    const auto covers = [&](const std::string& k) { return k.ends_with('/') ? name.starts_with(k) : name == k; };
    if (name != "format" && std::none_of(known.begin(), known.end(), covers))
      refuse("holds `" + name + "`, which this version does not know");
  }
}

bool StateReader::has(const std::string& name) const { return h5::exists(impl_->file, name); }

template <StateNumber T>
std::vector<T> StateReader::get(const std::string& name) const {
  if (!has(name)) throw std::runtime_error(impl_->path.string() + " is no full state: it holds no " + name);
  return h5::read<T>(impl_->file, name);
}

template <StateNumber T>
T StateReader::value(const std::string& name) const {
  const auto values = get<T>(name);
  if (values.size() != 1)
    throw std::runtime_error(
        fmt::format("{}: {} has {} values, one was expected", impl_->path.string(), name, values.size()));
  return values.front();
}

std::vector<dem::Vec3> StateReader::get_vectors(const std::string& name) const {
  const auto numbers = get<double>(name);
  std::vector<dem::Vec3> values(numbers.size() / 3);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
  return values;
}

std::string StateReader::text(const std::string& name) const {
  if (!has(name)) throw std::runtime_error(impl_->path.string() + " is no full state: it holds no " + name);
  return h5::read_text(impl_->file, name).at(0);
}

#define SUBSOIL_STATE_NUMBER(T)                                              \
  template void StateWriter::put<T>(const std::string&, std::span<const T>); \
  template std::vector<T> StateReader::get<T>(const std::string&) const;     \
  template T StateReader::value<T>(const std::string&) const;
SUBSOIL_STATE_NUMBER(double)
SUBSOIL_STATE_NUMBER(float)
SUBSOIL_STATE_NUMBER(std::int32_t)
SUBSOIL_STATE_NUMBER(std::int64_t)
SUBSOIL_STATE_NUMBER(std::uint8_t)
SUBSOIL_STATE_NUMBER(std::uint32_t)
SUBSOIL_STATE_NUMBER(std::uint64_t)
#undef SUBSOIL_STATE_NUMBER

std::filesystem::path state_path(const std::filesystem::path& directory, double time) {
  return directory / fmt::format("state-{:.9g}.h5", time);
}

std::optional<std::filesystem::path> latest_state(const std::filesystem::path& directory) {
  std::optional<std::filesystem::path> latest;
  double latest_time = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("state-") || !name.ends_with(".h5")) continue;
    double time = 0;
    const char* end = name.data() + name.size() - 3;
    if (std::from_chars(name.data() + 6, end, time).ptr != end) continue;
    if (!latest || time > latest_time) latest = entry.path(), latest_time = time;
  }
  return latest;
}

}  // namespace subsoil::app
