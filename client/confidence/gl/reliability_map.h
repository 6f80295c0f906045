#pragma once
/// The reliability map (reliability.h) on the GPU, for all eyes at once.
#include <client/fill/gl/gap_resample.h>
#include <client/reflections/gl/specular.h>
#include <client/warp/gl/eye_targets.h>

#include <client/confidence/reliability.h>

#include <array>
#include <span>

namespace equistream::gl {

/// Finished pictures, as engine and fill passes left them in `targets`.
struct JudgedEyes {
    std::span<const EyeView> eyes;  ///< their depth_m is not read
    const EyeDepth& depth;          ///< texture 0: nothing is known of their depth
    const EyeTargets& targets;
    /// What each eye's picture is made of, with the main source's grid; null: the source that estimate() is given.
    std::array<const SourceView*, max_eyes> sources{};

    const SourceView& source(std::size_t eye, const SourceView& main) const {
        return sources[eye] != nullptr ? *sources[eye] : main;
    }
};

class ReliabilityMap {
public:
    ReliabilityMap();

    /// Fills texture(). Of the source's textures only the grid and, where its view has one, the specular mask are read.
    /// Storage is kept as long as the targets' size stays; what comes after needs no barrier of its own, as in
    /// Resample.
    void estimate(const SpecularSource& source, const JudgedEyes& judged, const ReliabilityOptions& options = {});

    /// A layer for each eye: the probability, 0 to 1 (GL_R8).
    GLuint texture() const { return reliability_.name(); }
    /// EyePicture::reliability. Waits for the GPU.
    void download(int eye, EyePicture& picture) const;

private:
    void size_for(const EyeTargets& targets);
    void find_fill_depth(const EyeTargets& targets);
    void set_numbers(const SourceView& source, const JudgedEyes& judged, const ReliabilityOptions& options);

    Program surroundings_pass_, rows_pass_, column_steps_pass_, fill_depth_pass_, map_pass_;
    GapTiles filled_{GapTiles::Of::not_source};
    Size size_;
    int eyes_ = 0;
    Texture surroundings_, rows_, column_steps_, fill_depth_, reliability_, shares_;
    Buffer numbers_;
    EyeBlocks blocks_;
};

}  // namespace equistream::gl
