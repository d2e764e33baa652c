/// What this machine can do at most: memory bandwidth and multiply-adds in double precision; one line of JSON.
///
/// Bandwidth by a += s b over arrays far larger than any cache: 24 bytes an element, all of them moved (the usual triad
/// a = b + s c moves a fourth number unseen, the line of `a` that is about to be overwritten). Flops by chains of
/// independent multiply-adds in registers. Compiled for the machine that compiles it. Best of several rounds.
///
///     machine_peak [threads]
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <experimental/simd>
#include <memory>

namespace {

using Pack = std::experimental::native_simd<double>;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Bytes per second.
double bandwidth(int threads) {
  constexpr long length = 1L << 25;  // 256 MiB each
  const auto a = std::make_unique_for_overwrite<double[]>(length), b = std::make_unique_for_overwrite<double[]>(length);
  double *x = a.get(), *y = b.get(), best = 1e300;
#pragma omp parallel for num_threads(threads)
  for (long i = 0; i < length; ++i) x[i] = 0, y[i] = 1;  // each page by the thread that will use it
  for (int round = 0; round < 10; ++round) {
    const double from = now();
#pragma omp parallel for num_threads(threads)
    for (long i = 0; i < length; ++i) x[i] += 0.5 * y[i];
    best = std::min(best, now() - from);
  }
  return 24.0 * length / best;
}

/// Flops of one thread in a second; ten chains hide the latency of four cycles on two ports.
double multiply_adds() {
  constexpr int chains = 10;
  constexpr long count = 20'000'000;
  Pack sum[chains];
  for (int k = 0; k < chains; ++k) sum[k] = 1e-3 * k;
  const Pack factor = 0.999999, term = 1e-6;
  const double from = now();
  for (long i = 0; i < count; ++i)
    for (int k = 0; k < chains; ++k) sum[k] = sum[k] * factor + term;
  const double took = now() - from;
  double all = 0;
  for (const Pack& s : sum) all += std::experimental::reduce(s);
  if (all < 0) std::printf("never\n");  // the sums must be of use, or the loop is left out
  return 2.0 * chains * count * static_cast<double>(Pack::size()) / took;
}

double flops(int threads) {
  double best = 0;
  for (int round = 0; round < 5; ++round) {
    double together = 0;
#pragma omp parallel num_threads(threads) reduction(+ : together)
    together += multiply_adds();
    best = std::max(best, together);
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::max(1, std::atoi(argv[1])) : omp_get_max_threads();
  std::printf("{\"threads\": %d, \"bytes per s\": %.4g, \"flops per s\": %.4g}\n", threads, bandwidth(threads),
              flops(threads));
}
