#include "libsim/io/state_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "libsim/base/deflate.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/hdf5.hpp"
#include "libsim/io/hdf5_driver.hpp"
#include "libsim/io/read_guard.hpp"

namespace subsoil::sim {

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

namespace {

constexpr const char* checksum_name = "crc32";

/// CRC-32 of an array's bytes as they are in memory.
std::int64_t checksum_of(const void* data, std::size_t bytes) {
  return crc32({static_cast<const unsigned char*>(data), bytes});
}

/// Likewise of texts, each with the zero at its end.
std::int64_t checksum_of(const std::vector<std::string>& texts) {
  std::uint32_t sum = 0;
  for (const std::string& text : texts) sum = crc32(bytes_of({text.c_str(), text.size() + 1}), sum);
  return sum;
}

/// Throws std::runtime_error where a dataset has another checksum than the one that it was written with.
void compare(hid_t file, const std::string& name, std::int64_t sum) {
  const auto kept = h5::whole_attribute(file, name, checksum_name);
  if (kept && *kept != sum)
    throw std::runtime_error(fmt::format("`{}` is not what was written: the file is damaged", name));
}

/// With a checksum of its own: what a disk or a cable changed afterwards is refused when it is read.
template <class T>
void write_checked(hid_t file, const std::string& name, const void* data, hsize_t rows, hsize_t columns) {
  // Short arrays stay as they are; gzip on noise of long ones costs time and gains little, but ids and flags shrink.
  const h5::Handle set =
      h5::write_unlinked(file, name, data, h5::type_of<T>(), {rows, columns, h5::type_of<T>(), rows > 1024 ? 1 : -1});
  h5::set_attribute(set, checksum_name, checksum_of(data, rows * columns * sizeof(T)));
  h5::link(set, file, name);
  h5::status_of(file)->check();
}

}  // namespace

template <StateNumber T>
void StateWriter::put(const std::string& name, std::span<const T> values) {
  write_checked<T>(impl_->file, name, values.data(), values.size(), 1);
}

void StateWriter::put_vectors(const std::string& name, std::span<const dem::Vec3> values) {
  static_assert(sizeof(dem::Vec3) == 3 * sizeof(double));
  write_checked<double>(impl_->file, name, values.data(), values.size(), 3);
}

void StateWriter::put_texts(const std::string& name, const std::vector<std::string>& texts) {
  h5::write_text(impl_->file, name, texts);
  const h5::ReadGuard guard(impl_->file);
  const h5::Handle set(H5Dopen2(impl_->file, name.c_str(), H5P_DEFAULT), H5Dclose, "opening dataset " + name);
  h5::set_attribute(set, checksum_name, checksum_of(texts));
  h5::status_of(impl_->file)->check();
}

namespace {

/// Names of columns, how long each is, and all of them one behind the other.
template <class T>
struct Joined {
  std::vector<std::string> names;
  std::vector<std::int64_t> sizes;
  std::vector<T> values;

  void add(const std::string& name, const std::vector<T>& column) {
    names.push_back(name), sizes.push_back(static_cast<std::int64_t>(column.size()));
    values.insert(values.end(), column.begin(), column.end());
  }
  std::map<std::string, std::vector<T>, std::less<>> columns() const {
    std::map<std::string, std::vector<T>, std::less<>> out;
    std::size_t at = 0;
    for (std::size_t k = 0; k < names.size(); ++k) {
      const std::int64_t size = k < sizes.size() ? sizes[k] : -1;
      if (size < 0 || static_cast<std::size_t>(size) > values.size() - at)
        throw std::runtime_error("the sizes of its columns do not belong to them; the file is damaged");
      const auto from = values.begin() + static_cast<std::ptrdiff_t>(at);
      out[names[k]].assign(from, from + static_cast<std::ptrdiff_t>(size));
      at += static_cast<std::size_t>(size);
    }
    return out;
  }
};

}  // namespace

void StateWriter::put(const std::string& name, const Archive& archive) {
  Joined<double> numbers;
  std::size_t count = 0;  // of a bed many: a copy that grows would take twice their memory
  archive.each_column([&](const std::string&, const std::vector<double>& column) { count += column.size(); });
  numbers.values.reserve(count);
  archive.each_column(
      [&](const std::string& column, const std::vector<double>& values) { numbers.add(column, values); });
  put_texts(name + "/names", numbers.names);
  put(name + "/sizes", numbers.sizes);
  put(name + "/numbers", numbers.values);
  if (archive.texts().empty()) return;
  Joined<std::string> texts;
  for (const auto& [column, values] : archive.texts()) texts.add(column, values);
  put_texts(name + "/names of texts", texts.names);
  put(name + "/sizes of texts", texts.sizes);
  put_texts(name + "/texts", texts.values);
}

namespace {

// Behind what is HDF5, whose library passes over it: the checksum of all bytes before. A file whose structure is
// damaged may bring that library down, so that it is compared first.
constexpr std::string_view whole_file = "subsoil: all before has the crc32 ";
constexpr std::size_t trailer_length = whole_file.size() + 8 + 1;

std::string trailer_of(std::uint32_t sum) { return fmt::format("{}{:08x}\n", whole_file, sum); }

void append_trailer(const std::filesystem::path& file) {
  const std::string text = trailer_of(crc32_of_file(file));
  std::ofstream out(file, std::ios::binary | std::ios::app);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

/// Throws std::runtime_error where its bytes are not those before its trailer was written. A file without one passes.
void compare_trailer(const std::filesystem::path& file) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  if (unknown || size < trailer_length) return;
  std::ifstream in(file, std::ios::binary);
  std::string kept(trailer_length, ' ');
  in.seekg(static_cast<std::streamoff>(size - trailer_length));
  in.read(kept.data(), static_cast<std::streamsize>(trailer_length));
  if (!in || !kept.starts_with(whole_file) || kept == trailer_of(crc32_of_file(file, size - trailer_length))) return;
  throw std::runtime_error(file.string() + ": is not what was written: the file is damaged");
}

}  // namespace

void StateWriter::commit() {
  h5::close_file(impl_->file);
  append_trailer(temporary_name(impl_->path));
  put_in_place(impl_->path);
  impl_->path.clear();
}

struct StateReader::Impl {
  std::filesystem::path path;
  h5::Handle file;
};

StateReader::StateReader(const std::filesystem::path& path)
    : impl_(new Impl{path, (compare_trailer(path), h5::open_file(path))}) {}
StateReader::~StateReader() = default;

void StateReader::require_format(std::int64_t number, const std::vector<std::string>& known) const {
  const auto refuse = [&](const std::string& what) {
    throw std::runtime_error(
        fmt::format("{}; this version reads states of format {}: continue with the version that wrote it, or start the "
                    "run again",
                    what, number));
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
  if (!has(name)) throw std::runtime_error("is no full state: it holds no " + name);
  std::vector<T> values = h5::read<T>(impl_->file, name);
  compare(impl_->file, name, checksum_of(values.data(), values.size() * sizeof(T)));
  return values;
}

template <StateNumber T>
T StateReader::value(const std::string& name) const {
  const auto values = get<T>(name);
  if (values.size() != 1)
    throw std::runtime_error(fmt::format("{} has {} values, one was expected", name, values.size()));
  return values.front();
}

std::vector<dem::Vec3> StateReader::get_vectors(const std::string& name) const {
  const auto numbers = get<double>(name);
  std::vector<dem::Vec3> values(numbers.size() / 3);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
  return values;
}

Archive StateReader::archive(const std::string& name) const {
  Joined<double> numbers;
  numbers.names = texts(name + "/names"), numbers.sizes = get<std::int64_t>(name + "/sizes");
  numbers.values = get<double>(name + "/numbers");
  Joined<std::string> text;
  if (has(name + "/texts")) {
    text.names = texts(name + "/names of texts"), text.sizes = get<std::int64_t>(name + "/sizes of texts");
    text.values = texts(name + "/texts");
  }
  return {numbers.columns(), text.columns()};
}

std::vector<std::string> StateReader::texts(const std::string& name) const {
  if (!has(name)) throw std::runtime_error("is no full state: it holds no " + name);
  std::vector<std::string> values = h5::read_text(impl_->file, name);
  compare(impl_->file, name, checksum_of(values));
  return values;
}

std::string StateReader::text(const std::string& name) const {
  const std::vector<std::string> values = texts(name);
  if (values.empty()) throw std::runtime_error(name + " is empty: the file is damaged");
  return values.front();
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

std::filesystem::path checkpoint_path(const std::filesystem::path& directory, double time) {
  return directory / fmt::format("checkpoint-{:.9g}.h5", time);
}

namespace {

/// The time in state-0.25.h5 or checkpoint-0.25.h5.
std::optional<double> time_in(const std::string& name, std::string_view head) {
  if (!name.starts_with(head) || !name.ends_with(".h5")) return std::nullopt;
  double time = 0;
  const char* end = name.data() + name.size() - 3;
  if (std::from_chars(name.data() + head.size(), end, time).ptr != end) return std::nullopt;
  return time;
}

}  // namespace

std::vector<std::filesystem::path> states_in(const std::filesystem::path& directory) {
  std::vector<std::pair<double, std::filesystem::path>> found;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    for (const char* head : {"state-", "checkpoint-"})
      if (const auto time = time_in(entry.path().filename().string(), head)) found.push_back({*time, entry.path()});
  std::sort(found.rbegin(), found.rend());
  std::vector<std::filesystem::path> paths;
  for (auto& [time, path] : found) paths.push_back(std::move(path));
  return paths;
}

std::optional<std::filesystem::path> latest_state(const std::filesystem::path& directory) {
  for (const std::filesystem::path& path : states_in(directory))
    if (path.filename().string().starts_with("state-")) return path;
  return std::nullopt;
}

}  // namespace subsoil::sim
