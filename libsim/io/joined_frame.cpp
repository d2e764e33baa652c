#include "libsim/io/joined_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace subsoil::sim {
namespace {

/// All parts behind each other.
template <class T>
std::vector<T> behind_each_other(hid_t file, const std::vector<std::string>& parts, const std::string& name) {
  std::vector<T> all;
  for (const std::string& part : parts) {
    const std::vector<T> some = h5::read<T>(file, part + "/" + name);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

void require_part(hid_t file, const std::string& group, const std::string& part) {
  const std::filesystem::path where = h5::external_target(file, group, part);
  if (where.empty() || std::filesystem::exists(where)) return;
  throw std::runtime_error(
      fmt::format("{}: is missing, with spheres of {}; keep run.h5 and all of the folder frames together",
                  where.string(), group.substr(0, group.rfind('/'))));
}

}  // namespace

JoinedFrame::JoinedFrame(hid_t file, std::string group) : file_(file), group_(std::move(group)) {
  const std::string parts = group_ + "/parts";
  if (!h5::exists(file_, parts)) return;
  for (const std::string& name : h5::names_in(file_, parts)) {
    require_part(file_, parts, name);
    parts_.push_back(parts + "/" + name);
  }
}

bool JoinedFrame::holds(const std::string& name) const {
  if (h5::exists(file_, group_ + "/" + name)) return true;
  return in_parts() && std::all_of(parts_.begin(), parts_.end(),
                                   [&](const std::string& part) { return h5::exists(file_, part + "/" + name); });
}

std::string JoinedFrame::place(const std::string& name) const {
  const std::string own = group_ + "/" + name;
  return !in_parts() || h5::exists(file_, own) ? own : parts_.front() + "/" + name;
}

const std::vector<std::size_t>& JoinedFrame::order() const {
  if (!order_.empty()) return order_;
  const auto ids = behind_each_other<std::int64_t>(file_, parts_, "id");
  order_.resize(ids.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
  for (std::size_t k = 1; k < order_.size(); ++k)
    if (ids[order_[k - 1]] == ids[order_[k]])
      throw std::runtime_error(fmt::format("{}: sphere {} is in two parts", group_, ids[order_[k]]));
  return order_;
}

template <class T>
std::vector<T> JoinedFrame::read(const std::string& name) const {
  if (!in_parts() || h5::exists(file_, group_ + "/" + name)) return h5::read<T>(file_, group_ + "/" + name);
  const std::vector<std::size_t>& rows = order();
  const std::vector<T> all = behind_each_other<T>(file_, parts_, name);
  const std::size_t width = rows.empty() ? 1 : all.size() / rows.size();
  if (all.size() != width * rows.size())
    throw std::runtime_error(fmt::format("{}: ids and {} of its parts differ in length", group_, name));
  std::vector<T> out;
  out.reserve(all.size());
  for (const std::size_t row : rows)
    for (std::size_t d = 0; d < width; ++d) out.push_back(all[row * width + d]);
  return out;
}
template std::vector<float> JoinedFrame::read(const std::string&) const;
template std::vector<double> JoinedFrame::read(const std::string&) const;
template std::vector<std::int32_t> JoinedFrame::read(const std::string&) const;
template std::vector<std::int64_t> JoinedFrame::read(const std::string&) const;

}  // namespace subsoil::sim
