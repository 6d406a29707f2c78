// See crew.h.
#include "numerics/crew.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#ifdef __linux__
#include <sched.h>
#include <unistd.h>
#endif

namespace irt::numerics {
namespace {

struct Job {
  const std::function<void(std::size_t)>* work;
  std::size_t taken = 1, inside = 0;
};

class Crew {
 public:
  Crew() {
    for (std::size_t k = 1; k < crew_size(); ++k) {
      std::thread helper([this] { help(); });
#ifdef __linux__
      helpers_.push_back(helper.native_handle());
#endif
      helper.detach();
    }
  }

  void run(const std::function<void(std::size_t)>& work) {
    Job job{&work};
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(&job);
      keep_off_this_processor();
    }
    come_.notify_all();
    const auto finish = [&] {
      std::unique_lock lock(mutex_);
      std::erase(jobs_, &job);
      left_.wait(lock, [&] { return job.inside == 0; });
    };
    try {
      work(0);
    } catch (...) {
      finish();
      throw;
    }
    finish();
  }

 private:
  // Linux likes to wake a helper on its waker's processor, where one of them waits for milliseconds: longer than most jobs take.
  void keep_off_this_processor() {
#ifdef __linux__
    const int here = sched_getcpu();
    cpu_set_t others;
    // A forked child has none of the helpers.
    if (here < 0 || here == kept_off_ || getpid() != process_ || sched_getaffinity(0, sizeof others, &others) != 0) return;
    CPU_CLR(here, &others);
    if (CPU_COUNT(&others) == 0) return;
    for (const pthread_t helper : helpers_) pthread_setaffinity_np(helper, sizeof others, &others);
    kept_off_ = here;
#endif
  }

  [[noreturn]] void help() {
    std::unique_lock lock(mutex_);
    for (;;) {
      Job* job = nullptr;
      come_.wait(lock, [&] {
        const auto open = std::find_if(jobs_.begin(), jobs_.end(), [](const Job* j) { return j->taken < crew_size(); });
        job = open == jobs_.end() ? nullptr : *open;
        return job != nullptr;
      });
      const std::size_t worker = job->taken++;
      ++job->inside;
      lock.unlock();
      (*job->work)(worker);
      lock.lock();
      if (--job->inside == 0) left_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable come_, left_;
  std::deque<Job*> jobs_;
#ifdef __linux__
  std::vector<pthread_t> helpers_;
  int kept_off_ = -1;
  const pid_t process_ = getpid();
#endif
};

}  // namespace

std::size_t crew_size() {
  static const std::size_t size = std::clamp(std::thread::hardware_concurrency(), 1u, 16u);
  return size;
}

void by_crew(const std::function<void(std::size_t)>& work) {
  // Never destroyed: helpers wait in it when the process ends.
  static Crew* const crew = new Crew;
  crew->run(work);
}

}  // namespace irt::numerics
