#pragma once
/// Passes of Mitsuba's film gathered into the planes of a frame.
#include "scene_source.h"

namespace equistream::mitsuba_host {

class FramePlanes {
public:
    /// `aovs`: groups that the passes bring.
    FramePlanes(int width, int height, std::string_view aovs);

    void add(const PassResult& pass, std::uint32_t samples);
    /// In Mitsuba's world until now; from here on in ours. The sun's disc, which no frame of ours shows, becomes a
    /// miss.
    void bring_home(const WorldMap& world);
    /// Those of `aovs` alone. Throws WorkError with the plugin's words.
    void hand_over(es_frame* frame, std::string_view aovs) const;

    /// Samples that were not finite; each pass of a pixel counts as its samples.
    std::uint64_t left_out_samples() const { return left_out_; }

private:
    struct Plane {
        std::string name;
        int channels = 0;
        bool is_id = false;
        std::vector<float> values;
        std::vector<std::uint32_t> ids;
    };
    Plane* find(std::string_view name);
    void take_aovs(const PassResult& pass);

    int width_, height_;
    std::vector<double> colour_;
    std::vector<std::uint32_t> samples_;  // of each pixel's colour
    std::vector<Plane> planes_;
    std::uint64_t left_out_ = 0;
};

}  // namespace equistream::mitsuba_host
