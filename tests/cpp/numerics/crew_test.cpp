// Helpers: all work is done once, whoever comes, also from several callers at once and after an exception.
#include "numerics/crew.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace irt::numerics {
namespace {

TEST(Crew, DoesEachPieceOfWorkOnce) {
  std::vector<std::thread> callers;
  std::atomic<int> wrong{0};
  for (int caller = 0; caller < 4; ++caller)
    callers.emplace_back([&] {
      for (int round = 0; round < 200; ++round) {
        std::atomic<std::size_t> next{0};
        std::vector<int> done(17, 0), there(crew_size(), 0);
        by_crew([&](std::size_t worker) {
          ++there[worker];
          for (std::size_t k; (k = next++) < done.size();) ++done[k];
        });
        for (const int n : done) wrong += n != 1;
        for (const int n : there) wrong += n > 1;
        wrong += there[0] != 1;
      }
    });
  for (std::thread& t : callers) t.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Crew, OutlivesWhatItsCallerThrows) {
  EXPECT_THROW(by_crew([](std::size_t worker) {
                 if (worker == 0) throw std::runtime_error("no");
               }),
               std::runtime_error);
  std::atomic<bool> came{false};
  by_crew([&](std::size_t worker) { came = came || worker == 0; });
  EXPECT_TRUE(came);
}

}  // namespace
}  // namespace irt::numerics
