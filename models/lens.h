#pragma once

namespace raybundle {

/// Whether the lenses (f, k1, k2) are unknowns.
enum class Lens { free, fixed };

}  // namespace raybundle
