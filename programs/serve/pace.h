#pragma once
/// How many samples a pixel gets, so that spheres come at a rate: half of them where that is missed, twice as many
/// where there is time for it.
#include <cstdint>

namespace equistream::serve {

class Pace {
public:
    enum class Change { none, fewer, cannot_keep_up };

    /// Begins with one sample.
    Pace(std::uint32_t max_spp, double spheres_per_s) : max_spp_(max_spp), target_s_(1 / spheres_per_s) {}

    std::uint32_t spp() const { return spp_; }
    /// One sphere with spp() samples took so long. `cannot_keep_up` is said once.
    Change took(double sphere_s);

private:
    std::uint32_t spp_ = 1, max_spp_;
    double target_s_;
    int slow_ = 0, quick_ = 0;  // spheres in a row
    int quick_enough_ = 2;      // of them, for more samples; what has failed before is tried less readily
    bool has_said_so_ = false;
};

}  // namespace equistream::serve
