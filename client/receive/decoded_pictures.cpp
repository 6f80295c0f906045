#include "decoded_pictures.h"
#include "feeds.h"

#include <client/warp/engine.h>
#include <equistream/bound.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <glm/vec2.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

namespace equistream {

namespace {

/// Sums over squares of four, so that nothing is rounded.
constexpr int one_step = 4;

struct Squares {
    int width = 0, height = 0;
    Image<int> luma;       ///< sums
    FloatImage inverse_m;  ///< 1/r, NaN for no surface

    Squares(ImageView<const float> depth_m, ImageView<const std::uint8_t> picture_luma)
        : width(depth_m.width / 2), height(depth_m.height / 2), luma(width, height, 1), inverse_m(width, height, 1) {
        tbb::parallel_for(0, height, [&](int y) {
            const std::uint8_t* upper = picture_luma.row(2 * y);
            const std::uint8_t* lower = picture_luma.row(2 * y + 1);
            const float* depth = depth_m.row(2 * y);
            for (int x = 0; x < width; ++x) {
                *luma.pixel(x, y) = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
                *inverse_m.pixel(x, y) = 1 / depth[2 * x];
            }
        });
    }
};

constexpr int outside = -1;

/// Places along one axis: of the square before, the own, the next and the one behind that, towards `step`.
std::array<int, 4> places(int own, int step, int count, bool closes) {
    std::array<int, 4> found{};
    for (int i = 0; i < 4; ++i) {
        const int place = own + (i - 1) * step;
        found[std::size_t(i)] = closes ? (place + count) % count : place < 0 || place >= count ? outside : place;
    }
    return found;
}

/// The part of them that begins at (x, y). They stay where they are, and their owner with them.
template <typename Planes>
void keep(Planes& planes, glm::ivec2 from, glm::ivec2 size) {
    const auto keep_plane = [](auto& plane, glm::ivec2 at, glm::ivec2 kept) {
        plane.data = plane.pixel(at.x, at.y);
        plane.width = kept.x;
        plane.height = kept.y;
    };
    keep_plane(planes.y, from, size);
    for (auto* chroma : {&planes.cb, &planes.cr})
        keep_plane(*chroma, from / 2, (size + 1) / 2);
}

/// The part of `both` and `both_m` that begins at `from`, which is even; of its planes those of `picture`.
void keep(DecodedPicture& picture, const ByteImage& both, const FloatImage& both_m, glm::ivec2 from, glm::ivec2 size) {
    picture.width = size.x;
    picture.height = size.y;
    if (!picture.yuv.empty())
        keep(picture.yuv.planes, from, size);
    if (!picture.pq.empty())
        keep(picture.pq.planes, from, size);
    if (!both_m.empty()) {
        picture.depth_m = FloatImage(size.x, size.y, 1);
        for (int y = 0; y < size.y; ++y)
            std::copy_n(both_m.pixel(from.x, from.y + y), size.x, picture.depth_m.pixel(0, y));
    }
    if (both.empty())
        return;
    picture.rgb = ByteImage(size.x, size.y, 3);
    for (int y = 0; y < size.y; ++y)
        std::copy_n(both.pixel(from.x, from.y + y), 3 * size.x, picture.rgb.pixel(0, y));
}

}  // namespace

ByteImage luma_of(ImageView<const std::uint8_t> rgb) {
    ByteImage luma(rgb.width, rgb.height, 1);
    tbb::parallel_for(0, rgb.height, [&](int y) {
        const std::uint8_t* c = rgb.row(y);
        for (int x = 0; x < rgb.width; ++x, c += 3)
            *luma.pixel(x, y) = std::uint8_t(
                std::lround(16 + bt709::luma_scale * (bt709::kr * c[0] + bt709::kg * c[1] + bt709::kb * c[2])));
    });
    return luma;
}

ByteImage luma_of(const PqView& planes) {
    ByteImage luma(planes.y.width, planes.y.height, 1);
    tbb::parallel_for(0, luma.height(), [&](int y) {
        std::transform(planes.y.row(y), planes.y.row(y) + planes.y.width, luma.pixel(0, y),
                       [](std::uint16_t sample) { return std::uint8_t(sample >> 2); });
    });
    return luma;
}

FloatImage guided_depth(ImageView<const float> depth_m, ImageView<const std::uint8_t> luma,
                        const DepthAgreement& agreement, bool closes) {
    assert(depth_m.width == luma.width && depth_m.height == luma.height && depth_m.width % 2 == 0 &&
           depth_m.height % 2 == 0);
    const Squares squares(depth_m, luma);
    FloatImage guided_m(depth_m.width, depth_m.height, 1);
    tbb::parallel_for(0, depth_m.height, [&](int y) {
        const auto rows = places(y / 2, y % 2 == 0 ? -1 : 1, squares.height, false);
        for (int x = 0; x < depth_m.width; ++x) {
            const auto columns = places(x / 2, x % 2 == 0 ? -1 : 1, squares.width, closes);
            const int here = 4 * luma.row(y)[x];
            int nearest = std::abs(here - *squares.luma.pixel(columns[1], rows[1])) - one_step;
            const float* chosen = &depth_m.row(2 * rows[1])[2 * columns[1]];
            for (const auto& [across, down] : {std::array{1, 0}, {0, 1}, {1, 1}}) {
                // Along the row, the column or the diagonal.
                const auto place = [&, across = across, down = down](int i) {
                    return std::pair(columns[std::size_t(1 + across * i)], rows[std::size_t(1 + down * i)]);
                };
                const auto is_inside = [&](int i) { return place(i).first != outside && place(i).second != outside; };
                const auto at = [&](int i) {
                    return is_inside(i) ? *squares.inverse_m.pixel(place(i).first, place(i).second)
                                        : std::numeric_limits<float>::quiet_NaN();
                };
                // With nothing before or behind the two, in a corner, no slope tells whether they are one surface.
                if (!is_inside(1) || !(is_inside(-1) || is_inside(2)))
                    continue;
                const auto [column, row] = place(1);
                const int off = std::abs(here - *squares.luma.pixel(column, row));
                if (off > nearest || agreement.connected(at(-1), at(0), at(1), at(2)))
                    continue;
                nearest = off - 1;
                chosen = &depth_m.row(2 * row)[2 * column];
            }
            *guided_m.pixel(x, y) = *chosen;
        }
    });
    return guided_m;
}

DecodedPicture split_eyes(DecodedPicture& picture, StereoPacking packing) {
    const bool stacked = packing == StereoPacking::top_bottom;
    // Of even sides, as planes with half the samples of colour have to be; the second half begins where it would
    // without that, at an even sample too.
    const int both = stacked ? picture.height : picture.width, half = std::max(1, both / 4 * 2),
              second = both / 2 / 2 * 2;
    const glm::ivec2 size = stacked ? glm::ivec2(picture.width, half) : glm::ivec2(half, picture.height);
    const ByteImage both_rgb = std::exchange(picture.rgb, {});
    const FloatImage both_m = std::exchange(picture.depth_m, {});
    DecodedPicture right = picture;
    right.decode_ms = right.convert_ms = 0;  // the left one has them
    right.bytes = 0;
    keep(right, both_rgb, both_m, stacked ? glm::ivec2(0, second) : glm::ivec2(second, 0), size);
    keep(picture, both_rgb, both_m, {0, 0}, size);
    return right;
}

namespace {

std::size_t yuv_bytes(const DecodedPicture& picture) {
    return std::size_t(picture.width) * std::size_t(picture.height) * 3 / 2;
}

/// A tile says no more of a frame than how it was coded and where it lies.
FrameInfo of_frame(FrameInfo&& tile, const FrameInfo& main) {
    FrameInfo info = main;
    info.camera = tile.camera;
    info.depth_code = tile.depth_code;
    info.crf = tile.crf;
    info.visible_loss = tile.visible_loss;
    info.moving.clear();
    return info;
}

bool has_distances_of(const ReceivedPicture& base, const ReceivedPicture& tile) {
    return (base.depth_m.empty() || !tile.depth_m.empty()) && (base.specular.empty() || !tile.specular.empty());
}

/// Of a picture of ours: each eye's, with what it says of itself.
void split_posed_eyes(DecodedPictures& pictures, TrackRole role, std::optional<DecodedPicture>& right) {
    std::optional<DecodedPicture>& both = pictures.picture(role);
    if (!both || both->info->packing == StereoPacking::none)
        return;
    right = split_eyes(*both, both->info->packing);
    right->info = right_eye_of(*both->info);
    both->info->packing = StereoPacking::none;
}

void add_times(const ReceivedPicture& from, ReceivedPicture& to) {
    to.decode_ms += from.decode_ms;
    to.convert_ms += from.convert_ms;
}

void guide_depth(ReceivedPicture& picture) {
    const auto start = Clock::now();
    const DepthAgreement agreement{float(picture.info.depth_code->range.box_radius_m),
                                   float(std::sin(error_budget_rad(default_focal_length_px)))};
    const ByteImage luma = !picture.pq.empty()   ? luma_of(picture.pq.planes)
                           : picture.yuv.empty() ? luma_of(picture.rgb.view())
                                                 : ByteImage();
    picture.depth_m = guided_depth(picture.depth_m.view(), picture.yuv.empty() ? luma.view() : picture.yuv.planes.y,
                                   agreement, columns_close(picture.info.camera));
    picture.convert_ms += milliseconds_since(start);
}

}  // namespace

std::size_t DecodedPictures::bytes() const {
    std::size_t sum = 0;
    for (const auto& picture : by_role)
        if (picture)
            sum += picture->rgb.samples().size() + picture->depth_m.samples().size_bytes() +
                   (picture->yuv.empty() ? 0 : yuv_bytes(*picture)) +
                   (picture->pq.empty() ? 0 : 2 * yuv_bytes(*picture));
    return sum;
}

ReceivedFrame FrameMaker::make(DecodedFrame partial) {
    ReceivedFrame frame;
    frame.ordinal = partial.picture(TrackRole::main)->ordinal;
    frame.posed = partial.posed && !is_ods(partial.picture(TrackRole::main)->info->camera);
    if (partial.posed) {
        split_posed_eyes(partial, TrackRole::main, partial.right);
        split_posed_eyes(partial, TrackRole::depth, partial.right_depth);
    }
    if (!frame.posed)
        partial.right_depth.reset();
    frame.main = *give(partial, TrackRole::main, frame.posed);
    if (partial.right)
        frame.right = with_depth(std::move(*partial.right), partial.right_depth);
    if (frame.right)
        frame.main.convert_ms += frame.right->convert_ms;
    if (frame.posed) {
        give_images(partial, frame.main, TrackRole::reflections);
        frame.small = give(partial, TrackRole::small);
        frame.hidden = give(partial, TrackRole::hidden);
        frame.patches = give(partial, TrackRole::patches);
        require_patches_of_main(source_, frame);
        if (auto window = give_window(partial))
            look_through_window(source_, std::move(*window), frame);
        give_tiles(partial, frame);
    }
    return frame;
}

std::optional<ReceivedPicture> FrameMaker::give_window(DecodedPictures& pictures) {
    std::optional<ReceivedPicture> window = give(pictures, TrackRole::window);
    if (window)
        give_images(pictures, *window, TrackRole::window_reflections);
    return window;
}

/// Tiles of the whole sphere need no base around them. A tile without the distances that the base has would take them
/// from all others, and is left out.
void FrameMaker::give_tiles(DecodedFrame& partial, ReceivedFrame& frame) {
    std::vector<ReceivedPicture> tiles;
    for (auto& [place, pictures] : partial.tiles)
        if (auto tile = give_window(pictures); tile && has_distances_of(frame.main, *tile)) {
            tile->info = of_frame(std::move(tile->info), frame.main.info);
            tiles.push_back(std::move(*tile));
        }
    if (tiles.empty())
        return;
    const auto start = Clock::now();
    const std::string where = source_ + ": frame " + std::to_string(frame.main.info.index) + " of window";
    ReceivedPicture all = join_tiles(where, std::move(tiles), frame.main, options_.memory.get());
    all.convert_ms += milliseconds_since(start);
    const auto& camera = std::get<EquirectCamera>(all.info.camera);
    const bool is_whole = camera.range.is_full_sphere();
    look_through_window(source_, std::move(all), frame);
    if (is_whole)
        add_times(*std::exchange(frame.base, std::nullopt), frame.main);
}

ReceivedPicture FrameMaker::received(DecodedPicture&& colour) {
    ReceivedPicture picture;
    picture.info = std::move(*colour.info);
    picture.rgb = std::move(colour.rgb);
    picture.yuv = std::move(colour.yuv);
    picture.pq = std::move(colour.pq);
    picture.decoder = colour.decoder;
    picture.decode_ms = colour.decode_ms;
    picture.convert_ms = colour.convert_ms;
    bring_to_display(picture);
    return picture;
}

/// One view with its depth, where that came too.
std::optional<ReceivedPicture> FrameMaker::give(DecodedPictures& pictures, TrackRole role, bool posed) {
    std::optional<DecodedPicture>& colour = pictures.picture(role);
    if (!colour)
        return std::nullopt;
    count_(*colour);
    const auto depth_role = depth_role_of(role);
    if (!depth_role || !posed || !pictures.picture(*depth_role))
        return received(std::move(*colour));
    count_(*pictures.picture(*depth_role));
    return with_depth(std::move(*colour), pictures.picture(*depth_role));
}

/// `depth`: of the same view, where there is some.
ReceivedPicture FrameMaker::with_depth(DecodedPicture&& colour, std::optional<DecodedPicture>& depth) {
    ReceivedPicture picture = received(std::move(colour));
    if (!depth)
        return picture;
    require_same_view(picture, *depth);
    picture.depth_m = std::move(depth->depth_m);
    picture.info.depth_code = depth->info->depth_code;
    if (picture.info.depth_code->halved)
        guide_depth(picture);
    picture.decode_ms += depth->decode_ms;
    picture.convert_ms += depth->convert_ms;
    return picture;
}

void FrameMaker::bring_to_display(ReceivedPicture& picture) {
    if (picture.pq.empty() && options_.hdr_display)
        throw InputError(expected_found(source_, "an HDR stream (PQ, BT.2020, even sides), as HDR options are given",
                                        "another kind; leave these out"));
    if (picture.pq.empty() || options_.pq)
        return;
    const auto start = Clock::now();
    if (!display_)
        display_ = options_.hdr_display ? options_.hdr_display : std::make_shared<const HdrDisplay>();
    picture.rgb = quantise_8bit(display_->to_display(pq_to_rgb(picture.pq.planes).view()).view());
    picture.pq = {};
    picture.convert_ms += milliseconds_since(start);
}

/// Mirrors and glass of a picture, where they came as the track of this role.
void FrameMaker::give_images(DecodedPictures& pictures, ReceivedPicture& picture, TrackRole role) {
    std::optional<DecodedPicture>& images = pictures.picture(role);
    if (!images)
        return;
    require_same_view(picture, *images);
    count_(*images);
    picture.specular = FloatImage(images->width, images->height, 1);
    std::ranges::transform(images->depth_m.samples(), picture.specular.samples().begin(),
                           [](float distance_m) { return std::isnan(distance_m) ? 0.0f : 1.0f; });
    picture.virtual_depth_m = std::move(images->depth_m);
    picture.decode_ms += images->decode_ms;
    picture.convert_ms += images->convert_ms;
}

void FrameMaker::require_same_view(const ReceivedPicture& colour, const DecodedPicture& depth) const {
    const std::string where =
        source_ + ": frame " + std::to_string(colour.info.index) + " of " + track_name(depth.role);
    if (depth.width != colour.width() || depth.height != colour.height())
        throw WorkError(expected_found(where, size_text(colour.width(), colour.height()) + " as its colour has",
                                       size_text(depth.width, depth.height)));
    if (!same_camera(depth.info->camera, colour.info.camera) ||
        !same_pose(depth.info->camera_pose, colour.info.camera_pose))
        throw WorkError(expected_found(where, "the camera and pose of its colour", "others"));
}

}  // namespace equistream
