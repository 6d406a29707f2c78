#include "numerics/recent.h"

#include <gtest/gtest.h>

namespace irt::numerics {
namespace {

TEST(Recent, MakesOnceWhatIsAskedForAgainAndForgetsTheOldest) {
  Recent<int, int> recent;
  int made = 0;
  const auto ask = [&](int key) {
    return *recent.get(key, [&] {
      ++made;
      return std::make_shared<const int>(10 * key);
    });
  };
  for (int round = 0; round < 2; ++round)
    for (int key = 0; key < 8; ++key) EXPECT_EQ(ask(key), 10 * key);
  EXPECT_EQ(made, 8);
  ask(8);
  ask(0);
  EXPECT_EQ(made, 10);
  ask(8);
  EXPECT_EQ(made, 10);
}

TEST(Recent, KeepsOnlyWhatIsSmall) {
  Recent<int, int> recent;
  int made = 0;
  for (int round = 0; round < 2; ++round)
    recent.get(
        1, [&] { return std::make_shared<const int>(++made); }, [](const int&) { return false; });
  EXPECT_EQ(made, 2);
}

}  // namespace
}  // namespace irt::numerics
