#pragma once
/// Collects what a host answers, tile by tile, into the planes of one frame.
#include "motion.h"
#include "reference_tiles.h"
#include "sampling.h"

#include <equistream/aov.h>
#include <equistream/equistream.h>
#include <equistream/frame.h>
#include <equistream/frame_part.h>
#include <equistream/image.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace equistream {

/// Camera poses of a frame and its neighbours.
struct FramePoses {
    Pose previous, here, next;
};

/// 32 x 32 pixels: enough rays to be worth a call, few enough to keep every core busy to the end.
inline constexpr int default_tile_side = 32;

struct FilmSettings {
    std::uint32_t samples_per_pixel = 1;
    std::vector<std::string> planes;  ///< names of the AOV catalogue, colour among them; "raw", "samples", "variance",
                                      ///< "reference", "reference_repeat" are not asked for
    /// By tile: colour passes, 0 for one whose colour comes from elsewhere; empty: samples_per_pixel for each.
    std::vector<std::uint32_t> tile_samples{};
    bool variance = false;  ///< planes "samples" and "variance" are made of what tiles bring
    bool guides = false;    ///< a denoiser's guides are taken, where a host has them, asked for or not
    int tile_side = default_tile_side;
    bool has_holes = false;       ///< pixels that nobody answers for are no part of the picture (finish)
    ReferenceTiles references{};  ///< colour passes alone, after all other tiles; "reference" is made of them
    /// By their ids less 1: what planes of group "cryptomatte" hold for objects and materials (cryptomatte.h).
    std::vector<float> object_ids{}, material_ids{};
    FramePart part{};  ///< whose tiles are handed out; with part 0 of several: none
};

/// Of the sums of references.
inline constexpr std::size_t reference_channels = 4;
/// The first half of a tile's passes, and the second: every other sample of the sequence lies in one side of its pixel.
inline constexpr std::uint32_t reference_halves = 2;

/// Tiles of a part, by their numbers: `first`, `first + step` and so on. Of none of several: all.
struct TileShare {
    std::uint32_t first, step;

    explicit TileShare(const FramePart& part)
        : first(part.is_one() ? part.number - 1 : 0), step(part.is_one() ? part.count : 1) {}
};

/// Of a picture, rows of tiles from the top down.
inline std::size_t tile_count(const FrameInfo& info, int tile_side) {
    const auto along = [&](int pixels) { return static_cast<std::size_t>((pixels + tile_side - 1) / tile_side); };
    return along(picture_width(info)) * along(picture_height(info));
}

/// Which pixels of a tile answers are of, row by row: those listed, or all.
struct TilePixels {
    const es_tile& tile;
    const std::vector<std::uint32_t>* listed = nullptr;  ///< within the tile

    std::uint32_t count() const {
        return listed == nullptr ? tile.pixel_count : static_cast<std::uint32_t>(listed->size());
    }
    glm::ivec2 at(std::uint32_t i) const {
        const auto pixel = static_cast<int>(listed == nullptr ? i : (*listed)[i]);
        return {tile.x + pixel % tile.width, tile.y + pixel / tile.width};
    }
};

/// Tiles may be filled by any number of threads, each tile by one at a time; the rest is for one thread.
class Film {
public:
    /// Of the picture that `info` is of: the camera's, or an atlas of patches.
    Film(const FrameInfo& info, const FramePoses& poses, FilmSettings settings);

    /// Hands out each tile once.
    std::optional<es_tile> next_tile();
    /// Whether `tile` is one of ours, unchanged.
    bool knows(const es_tile& tile) const;

    void put_surfaces(const TilePixels& pixels, const es_surface* surfaces);
    /// Adds one colour pass. Samples that are not finite are left out of their pixel's mean.
    /// Returns false, adding nothing, when the tile has had all its passes.
    bool add_radiance(const TilePixels& pixels, const float* rgba);
    /// Adds the guides of one colour pass, six numbers a pixel: albedo and normal. What is not finite counts as 0.
    /// Returns false, adding nothing, when the tile has had all its passes.
    bool add_guides(const TilePixels& pixels, const float* guides);

    /// Adds what one colour pass met first, two numbers a pixel: object and material, 0 for a miss.
    /// Returns false, adding nothing, when the tile has had all its passes.
    bool add_ids(const TilePixels& pixels, const std::uint32_t* ids);

    /// Whole planes; they take the place of what tiles say of them. The image must have the right shape.
    void put_plane(const std::string& name, FloatImage image);
    void put_plane(const std::string& name, IdImage image);
    bool wants(const std::string& name) const;
    const std::vector<std::string>& planes() const { return plane_names_; }
    /// Surfaces and guides of such a tile are taken and not kept.
    bool is_reference(std::uint32_t tile) const { return tile >= tile_count_; }
    /// Colour passes of a tile.
    std::uint32_t passes_of(std::uint32_t tile) const {
        if (is_reference(tile))
            return references_.samples;
        return tile_samples_.empty() ? samples_per_pixel_ : tile_samples_[tile];
    }
    /// Of a tile's colour pass, 0 and up; references have numbers of their own.
    std::uint32_t sample_number(std::uint32_t tile, std::uint32_t pass) const {
        return is_reference(tile) ? first_reference_sample + pass : pass;
    }
    bool takes_guides() const { return takes_guides_; }
    bool takes_ids() const { return wants("crypto_object") || wants("crypto_material"); }
    /// Where `finish` padded colour: 0 there; null where it did not.
    const ByteImage* padded() const { return answered_.empty() || whole_.contains("colour") ? nullptr : &answered_; }

    /// What is still missing of the part, in words; nothing when it is complete.
    std::optional<std::string> missing() const;
    /// Everything that the part's tiles have brought. Throws InputError where planes were handed over whole.
    std::string part_bytes();
    /// As many as part_bytes() would return of `part`.
    std::size_t part_size(const FramePart& part);
    /// Takes what part_bytes() of another film returned, as if tiles had brought it here. `bytes` are part_size() many.
    /// Throws InputError where they cannot have come from tiles.
    void put_part(const FramePart& part, const std::string& bytes);
    /// Colour samples that were not finite, of tiles only.
    std::int64_t left_out_samples() const;
    /// Moves the planes into `frame`, averaging colour. References are 0 where tiles brought none. "variance" is that
    /// of the mean's luminance, 0 of one sample. In holes alpha is 0, depth NaN and colour extrapolated from around
    /// them, but for planes that were handed over whole.
    void finish(Frame& frame);

private:
    struct TileProgress {
        std::uint32_t colour_passes = 0, guide_passes = 0, id_passes = 0;
        bool surfaces = false;
    };
    es_tile tile(std::uint32_t id) const;
    bool is_whole() const;
    std::uint32_t all_tiles() const { return tile_count_ + static_cast<std::uint32_t>(references_.corners.size()); }
    std::uint32_t tile_at(int x, int y) const {
        return static_cast<std::uint32_t>(y / tile_side_) * tiles_across_ + static_cast<std::uint32_t>(x / tile_side_);
    }
    void start_film();
    void start_once() {
        std::call_once(film_started_, [this] { start_film(); });
    }
    /// All memory that tiles of `share` fill, piece by piece, in an order that hangs on the frame's settings alone.
    void each_piece(const TileShare& share, const std::function<void(std::span<std::byte>)>& take);
    void mark_answered(const TilePixels& pixels);
    double* reference_sum(const es_tile& tile, std::uint32_t half);
    void average_colour();
    void average_references();
    void finish_guides();
    void rank_ids(const char* name, const std::vector<float>& ids);
    void leave_holes();
    float* real_target(const std::string& name);
    std::uint32_t* id_target(const std::string& name);

    bool closes_;  ///< column W is column 0
    int width_;
    int height_;
    int tile_side_;
    std::uint32_t tiles_across_;
    std::uint32_t tile_count_;
    FramePart part_;
    TileShare share_;  ///< that is handed out
    std::uint32_t samples_per_pixel_;
    std::vector<std::uint32_t> tile_samples_;
    bool takes_variance_, takes_guides_;
    Motion backward_;
    Motion forward_;
    std::vector<std::string> plane_names_;
    std::set<std::string> whole_;
    std::map<std::string, FloatImage, std::less<>> real_;
    std::map<std::string, IdImage, std::less<>> ids_;

    std::atomic<std::uint32_t> next_tile_{0};
    std::uint32_t first_tile_ = 0;  ///< that is handed out
    std::once_flag film_started_;
    bool has_holes_;
    ByteImage answered_;  ///< where pixels may be holes: 1 where one had an answer
    std::vector<TileProgress> progress_;
    FloatImage radiance_sum_, guide_sum_;
    Image<double> square_sum_;  ///< of luminance
    IdImage left_out_;          ///< colour samples that were not finite, per pixel
    ReferenceTiles references_;
    /// By reference tile, of the first half of its passes and then of the second, pixel by pixel: sums of radiance, and
    /// how many samples they are of.
    std::vector<double> reference_sums_;
    std::vector<float> object_ids_, material_ids_;
    std::array<std::vector<std::uint32_t>, 2> firsts_of_names_;  ///< of objects and of materials, by their ids less 1
};

// Pixels that nobody looks at, coloured so that a picture codes well.

/// Where `known` is 0: colour from the nearest known pixels, ever smoother with the distance to them (averages over
/// 2x2 blocks, again and again, put back where there was nothing), and alpha 0. `closes`: the last column is beside the
/// first. RGBA; `known` is one channel of the same size. All 0 where nothing is known.
void pad_colour(FloatImage& rgba, const ByteImage& known, bool closes);

}  // namespace equistream
