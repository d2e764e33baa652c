#pragma once
#include <mpi.h>

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <vector>

/// Arrays of any length between processes: MPI counts in `int`, beds of 10^8 spheres do not fit.
namespace subsoil::mpi {

inline constexpr std::size_t kMostBytes = std::size_t{1} << 30;  ///< of one message

/// use(first byte, bytes) for messages that make up an array.
template <class Use>
void in_messages(void* data, std::size_t bytes, const Use& use) {
  for (std::size_t at = 0; at < bytes; at += kMostBytes)
    use(static_cast<char*>(data) + at, static_cast<int>(std::min(kMostBytes, bytes - at)));
}

/// From rank 0 to all.
template <class T>
void broadcast(std::vector<T>& values, MPI_Comm all) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::size_t count = values.size();
  MPI_Bcast(&count, sizeof count, MPI_BYTE, 0, all);
  values.resize(count);
  in_messages(values.data(), count * sizeof(T),
              [&](void* from, int bytes) { MPI_Bcast(from, bytes, MPI_BYTE, 0, all); });
}

/// Of all ranks, in their order, behind each other on rank 0; elsewhere empty.
template <class T>
std::vector<T> gather(std::vector<T> mine, MPI_Comm all) {
  static_assert(std::is_trivially_copyable_v<T>);
  int rank = 0, ranks = 1;
  MPI_Comm_rank(all, &rank), MPI_Comm_size(all, &ranks);
  std::size_t count = mine.size();
  if (rank != 0) {
    MPI_Send(&count, sizeof count, MPI_BYTE, 0, 0, all);
    in_messages(mine.data(), count * sizeof(T),
                [&](void* from, int bytes) { MPI_Send(from, bytes, MPI_BYTE, 0, 0, all); });
    return {};
  }
  for (int other = 1; other < ranks; ++other) {
    MPI_Recv(&count, sizeof count, MPI_BYTE, other, 0, all, MPI_STATUS_IGNORE);
    const std::size_t before = mine.size();
    mine.resize(before + count);
    in_messages(mine.data() + before, count * sizeof(T),
                [&](void* to, int bytes) { MPI_Recv(to, bytes, MPI_BYTE, other, 0, all, MPI_STATUS_IGNORE); });
  }
  return mine;
}

}  // namespace subsoil::mpi
