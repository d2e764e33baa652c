#pragma once
#include <cstddef>
#include <span>

namespace subsoil::mbd {

/// Weights of the values that a step is summed of, newest first, by order. Source: Hairer, Norsett, Wanner, Solving
/// Ordinary Differential Equations I, III.1.
inline constexpr double bashforth[6][6] = {
    {1.},
    {3. / 2, -1. / 2},
    {23. / 12, -16. / 12, 5. / 12},
    {55. / 24, -59. / 24, 37. / 24, -9. / 24},
    {1901. / 720, -2774. / 720, 2616. / 720, -1274. / 720, 251. / 720},
    {4277. / 1440, -7923. / 1440, 9982. / 1440, -7298. / 1440, 2877. / 1440, -475. / 1440},
};
inline constexpr double moulton[6][6] = {
    {1.},
    {1. / 2, 1. / 2},
    {5. / 12, 8. / 12, -1. / 12},
    {9. / 24, 19. / 24, -5. / 24, 1. / 24},
    {251. / 720, 646. / 720, -264. / 720, 106. / 720, -19. / 720},
    {475. / 1440, 1427. / 1440, -798. / 1440, 482. / 1440, -173. / 1440, 27. / 1440},
};

/// Of the corrector of an order, 1 to 6: one for each value.
inline std::span<const double> moulton_weights(int order) {
  return std::span(moulton[order - 1]).first(static_cast<std::size_t>(order));
}

}  // namespace subsoil::mbd
