#pragma once
/// Processor time of the calling thread, by stage. Read once a batch of rays, so that it costs next to nothing.
#include <ctime>

namespace equistream::embree_host {

class StageClock {
public:
    StageClock() : last_s_(now_s()) {}

    /// Time since the last lap.
    double lap() {
        const double now = now_s();
        const double taken = now - last_s_;
        last_s_ = now;
        return taken;
    }

private:
    static double now_s() {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    }
    double last_s_;
};

}  // namespace equistream::embree_host
