// Helpers: all work is done once, whoever comes, also from several callers at once and after an exception.
#include "numerics/crew.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#ifdef __linux__
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>
#endif

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

#ifdef __linux__
TEST(Crew, KeepsOffTheProcessorOfItsCaller) {
  cpu_set_t allowed;
  ASSERT_EQ(sched_getaffinity(0, sizeof allowed, &allowed), 0);
  if (CPU_COUNT(&allowed) < 2 || crew_size() < 2) GTEST_SKIP() << "there is one processor";
  // Callers may be moved, and helpers stay away: whoever is moved or left alone tries again.
  bool met = false;
  for (int round = 0; round < 1000 && !met; ++round) {
    std::atomic<bool> came{false}, may_share{false};
    const int before = sched_getcpu();
    by_crew([&](std::size_t worker) {
      if (worker > 0) {
        cpu_set_t mine;
        may_share = may_share || sched_getaffinity(0, sizeof mine, &mine) != 0 || CPU_ISSET(before, &mine);
        came = true;
      }
      for (int wait = 0; worker == 0 && wait < 1000 && !came; ++wait) std::this_thread::yield();
    });
    if (sched_getcpu() != before || !came) continue;
    met = true;
    EXPECT_FALSE(may_share);
  }
  EXPECT_TRUE(met);
}

TEST(Crew, LeavesForkedChildrenWhereTheyAre) {
  cpu_set_t allowed;
  ASSERT_EQ(sched_getaffinity(0, sizeof allowed, &allowed), 0);
  if (CPU_COUNT(&allowed) < 2) GTEST_SKIP() << "there is one processor";
  by_crew([](std::size_t) {});
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    bool same = true;
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (!CPU_ISSET(cpu, &allowed)) continue;
      cpu_set_t one, after;
      CPU_ZERO(&one);
      CPU_SET(cpu, &one);
      sched_setaffinity(0, sizeof one, &one);
      sched_setaffinity(0, sizeof allowed, &allowed);
      by_crew([](std::size_t) {});
      same = same && sched_getaffinity(0, sizeof after, &after) == 0 && CPU_EQUAL(&allowed, &after);
    }
    _exit(same ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}
#endif

}  // namespace
}  // namespace irt::numerics
