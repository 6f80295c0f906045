#pragma once
/// How many threads work is worth, and starting them.
#include <equistream/error.h>

#include <sched.h>

#include <algorithm>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace equistream {

/// How many processors this thread may run on, 1 at least: taskset, a container or a cluster's job may leave it few of
/// the machine's.
inline unsigned usable_processors() {
    cpu_set_t usable;
    if (sched_getaffinity(0, sizeof usable, &usable) == 0)
        return static_cast<unsigned>(CPU_COUNT(&usable));
    return std::max(1u, std::thread::hardware_concurrency());  // more than the set has room for
}

/// So many threads that share `work`, or as many of them as the system allows. Throws WorkError where it allows none.
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
