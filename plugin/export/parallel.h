#pragma once
/// Spreads independent pieces of one frame over the cores that this process may use. Plain threads: a plugin that is
/// loaded into foreign renderers should not bring a task scheduler of its own.
#include <equistream/threads.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace equistream {

/// Runs work(worker_state, index) for index 0 .. count-1 in any order; each thread has one state made by make_state().
/// The first exception stops the rest and is thrown again here.
template <typename MakeState, typename Work>
void for_each_index(int count, MakeState make_state, Work work) {
    std::atomic<int> next{0};
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto run = [&] {
        try {
            auto state = make_state();
            for (int index = next++; index < count; index = next++)
                work(state, index);
        } catch (...) {
            const std::lock_guard lock(failure_mutex);
            if (!failure)
                failure = std::current_exception();
            next = count;
        }
    };
    const int cores = static_cast<int>(usable_processors());
    {
        std::vector<std::jthread> helpers;
        try {
            for (int i = 1; i < std::min({cores, count, 16}); ++i)
                helpers.emplace_back(run);
        } catch (const std::system_error&) {
            // There are no more threads to be had. This one does the work too.
        }
        run();
    }
    if (failure)
        std::rethrow_exception(failure);
}

/// The same of a picture's rows: work(row).
template <typename Work>
void for_each_row(int height, const Work& work) {
    constexpr int rows_at_a_time = 8;
    for_each_index((height + rows_at_a_time - 1) / rows_at_a_time, [] { return 0; },
                   [&](int, int piece) {
                       for (int y = piece * rows_at_a_time; y < std::min(height, (piece + 1) * rows_at_a_time); ++y)
                           work(y);
                   });
}

}  // namespace equistream
