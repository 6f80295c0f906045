#pragma once
/// Radiance carried from frame to frame: each pixel's mean over the frames so far, found again by exact motion.
///
/// A pixel looks up where its surface was in the frame before, or, in a mirror or a pane, where what it shows was
/// (Schied et al., "Spatiotemporal Variance-Guided Filtering", 2017, for the first; Zimmer et al., "Path-space Motion
/// Estimation", 2015, for the second). What is found there counts if it is the same thing: same ids and kind, normals
/// alike, and as deep as the point is from the camera that was. It is weighed by its number of samples, so that the
/// mean over a still pixel is the mean of all its samples. Where anything moved, `frames` bounds that number. What
/// moves less than 1/256 of a pixel a frame stays in its pixel, and counts for so many frames that its mean lags a
/// quarter of a pixel, or for `frames` if that is more.
///
/// Where one surface slides along another, a pixel shows of both. Such rims move with the nearer one, as antialiasing
/// over time has it (Karis, "High Quality Temporal Supersampling", 2014), remember little, and give nothing to pixels
/// that are no rims: otherwise what comes out behind an edge would be smeared with the edge's colour.
///
/// A denoiser goes first, frame by frame: what it leaves differs from frame to frame, so that a mean loses it, while
/// the mean's own noise, resampled over and over, hangs together from pixel to pixel and would pass for detail. Its
/// frames are carried on by the same weights. Where nothing moves, the mean of what it was given is at last nearer to
/// the truth, so the two are mixed by their errors (James and Stein, "Estimation with Quadratic Loss", 1961).
///
/// A change of light shows as a difference between the mean and a quicker one over neighbourhoods, beyond what their
/// variances explain (the idea of A-SVGF, Schied et al. 2018, and of ReLAX's two histories). It is taken for the mean's
/// bias b. An eye sees the mean of many pixels k, and so less of noise of variance V, but all of the bias: the mean is
/// worth as many samples as one of variance V + k b^2.
///
/// A mean that is resampled over and over loses detail, and lacks it in the next frame too, while noise is new in every
/// frame. An innovation is how far a frame is off what was carried to it. The product of two in a row is at most zero
/// on average where no detail is lost, and else the square of what is lost (Mehra, "On the Identification of Variances
/// and Adaptive Kalman Filtering", 1970).
#include <equistream/frame.h>
#include <equistream/rec709.h>

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace equistream {

/// What a frame must carry for it besides colour, by groups of the AOV catalogue (no forward motion, no materials).
inline constexpr const char* history_aovs = "depth,motion,normal,ids,specular,virtual";

/// One sequence's memory. One thread at a time; it computes on several. From the third frame of one size on it takes
/// no memory of a picture's size.
class History {
public:
    /// `frames`, at least 1: so many earlier ones count at most where anything moved.
    explicit History(std::uint32_t frames) : frames_(static_cast<float>(frames)) {}

    /// Which frame the motion of another one leads to.
    struct Before {
        std::int64_t index;
        Pose camera_pose;
    };

    /// Turns a frame's colour into the mean of all frames, and fills planes "samples" and "variance" (aov.h). A frame
    /// that is denoised also has plane "raw", which becomes the mean of what it was. Where the frame has them samples
    /// and variance are its own: of their mean. Otherwise every pixel with finite colour has info.samples_per_pixel of
    /// them, and variance is learnt from frame to frame. Unless `before` is the frame last given, the memory begins
    /// anew. The frame has history_aovs and is no atlas of patches.
    void accumulate(Frame& frame, const Before& before);

    /// The frame last given could not be kept: it can be given again.
    void take_back();

    /// Samples a pixel for each tile of the next frame, row by row, `next.samples_per_pixel` on average: more where the
    /// mean is uncertain for its brightness, half to four times as many. Empty where there is nothing to go by.
    std::vector<std::uint32_t> samples_by_tile(const FrameInfo& next, int tile_side) const;

private:
    /// What is known of a pixel's radiance.
    struct Mean {
        glm::vec4 colour{0};
        glm::vec3 denoised{0};
        float count = 0;     ///< independent samples that it is worth
        float variance = 0;  ///< of one sample's luminance
        float freedom = 0;   ///< degrees of it
        float recent = 0;    ///< luminance over the last few frames
        float recent_count = 0;
        float innovation = 0;  ///< of the last frame's luminance; 0: nothing was carried to it
        float most = 0;        ///< frames that count at most
        bool stayed = false;   ///< in its pixel
    };
    /// What its centre's ray met.
    struct Seen {
        glm::vec3 point_m{0};  ///< from the camera, in the world's axes; of what has no end its direction
        float shown_m = 0;     ///< virtual depth
        glm::vec3 normal{0};
        std::uint32_t object = 0, instance = 0;
        bool specular = false, endless = false;
        bool fixed = true;  ///< has not moved by itself
        bool rim = false;   ///< another thing, which moves otherwise, may show in it
    };
    /// What this frame alone says of a pixel.
    struct Fresh {
        glm::vec4 colour{0};
        glm::vec3 denoised{0};
        float level = 0;     ///< luminance
        float count = 0;     ///< samples
        float variance = 0;  ///< of one of them
        float freedom = 0;
    };
    struct Sought;
    /// Between the two means of a pixel, or summed over some.
    struct Change {
        float difference = 0, variance = 0, level = 0, count = 0;
    };

    /// First samples of what a frame brings; null where it does not say.
    struct Planes {
        explicit Planes(const Frame& frame);
        const float *colour, *backward, *virtual_backward;
        const float *raw = nullptr, *samples = nullptr, *variance = nullptr;
        float samples_a_pixel;
    };
    struct Poses {
        Pose before, now;
    };

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    void resize(const FrameInfo& info);
    void see(const Frame& frame);
    void find_rims(const Planes& planes);
    glm::ivec2 nearest_around(int x, int y) const;
    bool is_rim(const Planes& planes, int x, int y) const;
    double pixel_rad() const;
    static Fresh fresh(const Planes& planes, std::size_t pixel);
    Mean carried(const Planes& planes, int x, int y, const Poses& poses);
    Sought sought(const Planes& planes, int x, int y, const Poses& poses) const;
    bool is_same(const Sought& sought, int x, int y) const;
    bool is_own_rim(const Sought& sought, int x, int y) const;
    bool goes_along(const Sought& sought, int x, int y) const;
    std::ptrdiff_t place(int x, int y) const;
    Mean found(const Sought& sought) const;
    bool sharpen(Mean& mean, const Sought& sought, glm::ivec2 corner, glm::vec2 past) const;
    Change change(const Mean& carried, const Fresh& fresh) const;
    void find_changes();
    void find_lost_detail(const Planes& planes);
    void find_shares();
    template <typename Use>
    void sum_around(int radius, const Use& use);
    static void forget_changed(Mean& carried, float bias2);
    static void forget_lost(Mean& carried, float lost, float fresh_count);
    void mix(Mean& carried, const Fresh& fresh) const;
    void write(Frame& frame) const;

    float frames_;
    std::optional<Before> last_, before_last_;  ///< the latter where the last frame went on from it
    double exposure_ = 1;
    Camera camera_;
    int width_ = 0, height_ = 0;
    bool closes_ = false, north_pole_ = false, south_pole_ = false;
    std::array<std::vector<Mean>, 2> means_;  ///< now, before
    std::array<std::vector<Seen>, 2> seen_;
    std::vector<Change> changes_, row_sums_;
    std::vector<float> bias2_;
    std::vector<float> lost_;    ///< detail, squared, over the noise of the frame and of the mean together
    std::vector<float> shares_;  ///< of the mean in what is shown, beside the denoised one
};

}  // namespace equistream
