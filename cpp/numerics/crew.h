// Helpers that wait for work. Threads made for each call of a few milliseconds often began after it, and had to be waited for all the same.
#pragma once

#include <cstddef>
#include <functional>

namespace irt::numerics {

// How many may take part in a job: one for each processor, sixteen at most.
std::size_t crew_size();

// work(0) by the caller, and work(1) ... work(crew_size() - 1) by helpers as they come; returns when all that have begun are done. Helpers that come
// after the caller's own return are not waited for, so work has to be claimed, not dealt out.
void by_crew(const std::function<void(std::size_t)>& work);

}  // namespace irt::numerics
