#pragma once
/// How many samples a pixel gets, so that spheres come at a rate: half of them where that is missed, twice as many
/// where there is time for it.
#include <cstdint>

namespace equistream::serve {

class Pace {
public:
    enum class Change { none, fewer, more, cannot_keep_up };

    /// `most_spp` is what it begins with and never exceeds.
    Pace(std::uint32_t most_spp, double spheres_per_s)
        : spp_(most_spp), most_spp_(most_spp), target_s_(1 / spheres_per_s) {}

    std::uint32_t spp() const { return spp_; }
    /// One sphere with spp() samples took so long. `cannot_keep_up` is said once.
    Change took(double sphere_s);

private:
    std::uint32_t spp_, most_spp_;
    double target_s_;
    int slow_ = 0, quick_ = 0;  // spheres in a row
    bool has_said_so_ = false;
};

}  // namespace equistream::serve
