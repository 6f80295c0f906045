#pragma once
/// Takes the noise of few samples out of a frame's colour, by Open Image Denoise. What it does is a bias: the mean of
/// many denoised frames is not the truth (docs/results/denoise.md has by how much).
#include <equistream/denoise_quality.h>
#include <equistream/frame.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace equistream {

namespace oidn {
class Device;
}

/// One thread at a time; it copies on several, whatever `threads` is.
class Denoiser {
public:
    /// `quality` is not off. `threads`: of a CPU, 0 for all. Throws InputError where there is no library, in one line
    /// that says how to get it.
    Denoiser(DenoiseQuality quality, unsigned threads);
    ~Denoiser();

    /// Library, version, quality: what a manifest says.
    const std::string& description() const { return description_; }

    /// Replaces R, G and B of plane "colour" (linear radiance; A stays). Guides are planes "guide_albedo" and
    /// "guide_normal" where the frame has them, which are taken to be free of noise; else "albedo" and "normal", else
    /// none. A full circle is seamless, and so are its poles. Numbers that are not finite count as 0. Takes the memory
    /// of one block, whatever the size; the second frame of a size takes no more. Throws WorkError.
    void denoise(Frame& frame);

private:
    class Blocks;
    struct Job {
        int width = 0, height = 0;
        std::size_t images = 0;
        float exposure = 0;
        bool filtered_guides = false;
        bool operator==(const Job&) const = default;
    };
    void prepare(const Job& job);
    void release();
    void fill(const Blocks& blocks, int block, const FloatImage& image, std::size_t slot, float least, float most);

    std::shared_ptr<const oidn::Device> device_;
    DenoiseQuality quality_;
    std::string description_;

    // One block: colour, then guides.
    void* filter_ = nullptr;
    std::array<void*, 3> buffers_{};
    Job job_;
    std::vector<float> staging_;
    FloatImage noisy_;  // of a frame of several blocks, whose edges still need it
};

}  // namespace equistream
