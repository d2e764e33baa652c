#pragma once

namespace subsoil::mbd {

/// A coordinate of a body in the world.
enum class Coordinate { x, y, angle };

}  // namespace subsoil::mbd
