#pragma once
/// How many samples a pixel gets, so that spheres come at a rate: half of them where that is missed, twice as many
/// where there is time for it. Of a window in a sphere, the window's are the last to go and the first to come back.
#include <cstdint>
#include <optional>
#include <string>

namespace equistream::serve {

/// A pixel's.
struct Samples {
    std::uint32_t looked_at = 1;        ///< of a window, or of a sphere without one
    std::optional<std::uint32_t> base;  ///< of the sphere around a window, never more
};
/// "4 samples a pixel", or "4 samples a pixel in the window, 1 around it".
std::string samples_text(const Samples& samples);

class Pace {
public:
    enum class Change { none, fewer, cannot_keep_up };

    /// Begins with one sample.
    Pace(std::uint32_t max_spp, double spheres_per_s, bool has_window)
        : max_spp_(max_spp), target_s_(1 / spheres_per_s) {
        if (has_window)
            samples_.base = 1;
    }

    Samples samples() const { return samples_; }
    /// One sphere with samples() took so long. `cannot_keep_up` is said once.
    Change took(double sphere_s);

private:
    bool rise();
    bool fall();

    Samples samples_;
    std::uint32_t max_spp_;
    double target_s_;
    int slow_ = 0, quick_ = 0;  // spheres in a row
    int quick_enough_ = 2;      // of them, for more samples; what has failed before is tried less readily
    bool has_risen_ = true;     // since samples were taken away
    bool has_said_so_ = false;
};

}  // namespace equistream::serve
