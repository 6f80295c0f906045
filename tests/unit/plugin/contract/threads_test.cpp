#include <equistream/threads.h>

#include <gtest/gtest.h>

#include <sched.h>

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>

namespace equistream {
namespace {

TEST(Processors, AreThoseThatTheProcessMayUse) {
    cpu_set_t all;
    ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
    EXPECT_EQ(int(usable_processors()), CPU_COUNT(&all));
    int last = CPU_SETSIZE - 1;
    while (!CPU_ISSET(last, &all))
        --last;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(last, &one);
    ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
    EXPECT_EQ(usable_processors(), 1u);
    EXPECT_EQ(sched_setaffinity(0, sizeof all, &all), 0);
}

/// Each thread gets a copy. None can be made when none is left, as where the system has no thread left.
struct Work {
    Work(std::atomic<int>& copies, std::atomic<int>& counted) : left(copies), runs(counted) {}
    Work(const Work& other) : left(other.left), runs(other.runs) {
        if (left-- <= 0)
            throw std::system_error(EAGAIN, std::generic_category());
    }
    void operator()() const { ++runs; }

    std::atomic<int>&left, &runs;
};

TEST(Threads, WorkGoesOnWithAsManyAsThereAre) {
    std::atomic<int> left = 1000, runs = 0;
    start_threads(50, Work(left, runs)).clear();
    EXPECT_EQ(runs, 50);
    left = 30;
    runs = 0;
    start_threads(50, Work(left, runs)).clear();
    EXPECT_GT(runs, 0);
    EXPECT_LE(runs, 30);
    left = 0;
    try {
        start_threads(50, Work(left, runs));
        ADD_FAILURE() << "nobody works";
    } catch (const WorkError& error) {
        EXPECT_EQ(std::string(error.what()), "no thread could be started: " + std::generic_category().message(EAGAIN));
    }
}

}  // namespace
}  // namespace equistream
