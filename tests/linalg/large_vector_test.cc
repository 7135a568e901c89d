#include <raybundle/linalg/large_vector.h>

#include <cstddef>
#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

namespace raybundle::linalg {
namespace {

constexpr std::size_t sizes[] = {1, 7, 1000, 1 << 19, (1 << 20) + 3};  // up to 8 MB

TEST(LargeVector, BehavesLikeAVector) {
  for (const std::size_t size : sizes) {
    LargeVector<double> x(size);
    for (std::size_t i = 0; i < size; ++i) x[i] = static_cast<double>(i);
    LargeVector<double> copy = x;
    x.resize(2 * size);
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(x[i], static_cast<double>(i));
    EXPECT_EQ(copy.size(), size);
    const LargeVector<double> moved = std::move(copy);
    EXPECT_EQ(moved.back(), static_cast<double>(size - 1));
    x.assign(size, 3.5);
    EXPECT_EQ(x[size / 2], 3.5);
  }
  EXPECT_TRUE(LargeVector<double>().empty());
}

TEST(LargeVector, StartsAtACacheLine) {
  for (const std::size_t size : sizes) {
    const LargeVector<double> x(size);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(x.data()) % 64, 0U);
  }
}

}  // namespace
}  // namespace raybundle::linalg
