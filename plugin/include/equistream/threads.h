#pragma once
/// Number of usable processors, and starting threads.
#include <equistream/error.h>

#include <sched.h>

#include <algorithm>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace equistream {

/// Number of processors that this thread may run on, at least 1. taskset, a container or a cluster's job may allow
/// fewer than the machine has.
inline unsigned usable_processors() {
    cpu_set_t usable;
    if (sched_getaffinity(0, sizeof usable, &usable) == 0)
        return static_cast<unsigned>(CPU_COUNT(&usable));
    return std::max(1u, std::thread::hardware_concurrency());  // more than the set has room for
}

/// Starts `count` threads that each call a copy of `work`, or fewer if the system refuses more. Throws WorkError if it
/// refuses the first one. The destructors of the threads join them.
template <typename Work>
std::vector<std::jthread> start_threads(unsigned count, const Work& work) {
    std::vector<std::jthread> threads;
    threads.reserve(count);
    try {
        while (threads.size() < count)
            threads.emplace_back(work);
    } catch (const std::system_error& problem) {
        if (threads.empty())
            throw WorkError(std::string("no thread could be started: ") + problem.code().message());
    }
    return threads;
}

}  // namespace equistream
