#pragma once

#include <optional>

namespace raybundle::test {

/// T of an optional<T>, or T itself: the type that an option's values have.
template <class T>
struct Plain {
  using Type = T;
};
template <class T>
struct Plain<std::optional<T>> {
  using Type = T;
};

}  // namespace raybundle::test
