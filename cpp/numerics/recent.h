// What was made last from which key, for things that cost more to make than a frame has time for. Safe to share between threads.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

namespace irt::numerics {

template <class Key, class Made>
class Recent {
 public:
  // Made by `make` where it is not there, by two threads at once if both ask for it first; kept where it is `small`.
  template <class Make>
  std::shared_ptr<const Made> get(const Key& key, const Make& make, bool (*small)(const Made&) = [](const Made&) { return true; }) {
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [known, made] : entries_)
        if (known == key) return made;
    }
    std::shared_ptr<const Made> made = make();
    if (!small(*made)) return made;
    const std::lock_guard lock(mutex_);
    entries_.emplace_front(key, made);
    if (entries_.size() > kEntries) entries_.pop_back();
    return made;
  }

 private:
  static constexpr std::size_t kEntries = 8;
  std::mutex mutex_;
  std::deque<std::pair<Key, std::shared_ptr<const Made>>> entries_;
};

}  // namespace irt::numerics
