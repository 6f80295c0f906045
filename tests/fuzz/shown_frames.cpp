/// Frame data of whole frames, as it comes out of coded pictures, up to what both eyes see of them.
///
/// Seven bytes say how frames are shown; then comes what every picture's data is, each behind its length and how it
/// came.
#include "target.h"

#include <client/pipeline/cpu_pipeline.h>
#include <client/receive/decoded_pictures.h>
#include <client/stages/stages.h>
#include <equistream/colour.h>
#include <equistream/stream.h>
#include <equistream/yuv.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>

namespace equistream::fuzz {

namespace {

/// More would be slow, and shows nothing that these do not.
constexpr int max_pixels = 128 * 64, max_pictures = 28;

/// How a picture came, a bit each.
enum : std::uint8_t { begins_frame = 1, is_tile = 2, has_other_size = 4, is_of_other_kind = 8 };

/// What colours come as, and what is asked for: what is shown by `display` comes as `pq`, and as RGB to the pipeline.
enum class Kind { rgb, yuv, pq, display, rgb_for_display };

/// The last of what a frame is, where it is another's video.
constexpr std::array packings = {StereoPacking::none, StereoPacking::top_bottom, StereoPacking::side_by_side};

/// Has room every other time.
class SomeMemory : public PictureMemory {
public:
    std::shared_ptr<std::uint8_t> take(std::size_t bytes) override {
        has_room_ = !has_room_;
        return has_room_ ? std::shared_ptr<std::uint8_t>(new std::uint8_t[bytes], std::default_delete<std::uint8_t[]>())
                         : nullptr;
    }

private:
    bool has_room_ = false;
};

/// Planes of that size, of any samples up to `highest`.
template <typename T>
Yuv420Picture<const T> planes(int width, int height, unsigned highest, unsigned pattern) {
    const std::ptrdiff_t chroma = std::ptrdiff_t(width / 2) * (height / 2);
    const auto samples = std::make_shared<std::vector<T>>(std::size_t(std::ptrdiff_t(width) * height + 2 * chroma));
    for (std::size_t i = 0; i < samples->size(); ++i)
        (*samples)[i] = T((i * 37 + pattern * 101) % (highest + 1));
    const T* const y = samples->data();
    const T* const cb = y + std::ptrdiff_t(width) * height;
    return {{{y, width, height, 1, width},
             {cb, width / 2, height / 2, 1, width / 2},
             {cb + chroma, width / 2, height / 2, 1, width / 2}},
            samples};
}

/// Distances that a depth track can hold: from the nearest one on, without end, and where no surface is known.
FloatImage distances(int width, int height, const DepthCodeInfo& code, unsigned pattern) {
    const double near_m = code.range.near_m;
    FloatImage depth_m(width, height, 1);
    unsigned state = pattern * 2654435761u + 1;
    for (float& r : depth_m.samples()) {
        state = state * 1664525u + 1013904223u;
        const unsigned kind = state >> 28;
        r = kind == 0   ? std::numeric_limits<float>::quiet_NaN()
            : kind == 1 ? std::numeric_limits<float>::infinity()
                        : float(near_m) * (1 + float(state >> 8 & 0xff) / (kind < 8 ? 16 : 4096));
    }
    if (code.halved)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                *depth_m.pixel(x, y) = *depth_m.pixel(x / 2 * 2, y / 2 * 2);
    return depth_m;
}

void set_colours(DecodedPicture& picture, Kind kind, std::uint8_t how, unsigned pattern) {
    const bool may_have_planes = picture.width % 2 == 0 && picture.height % 2 == 0;
    const bool planar = (kind != Kind::rgb && kind != Kind::rgb_for_display) != ((how & is_of_other_kind) != 0);
    if (!planar || !may_have_planes)
        picture.rgb = synthetic::picture(picture.width, picture.height, pattern);
    else if (kind == Kind::pq || kind == Kind::display)
        picture.pq = planes<std::uint16_t>(picture.width, picture.height, 1023, pattern);
    else
        picture.yuv = planes<std::uint8_t>(picture.width, picture.height, 255, pattern);
}

DecodedPicture decoded(TaggedFrameInfo tagged, Kind kind, std::uint8_t how, unsigned pattern) {
    DecodedPicture picture;
    picture.role = tagged.role;
    picture.width = picture_width(tagged.info);
    picture.height = picture_height(tagged.info);
    if (how & has_other_size)
        picture.width += 2;
    if (is_depth(tagged.role)) {
        if (!tagged.info.depth_code)
            throw WorkError("a picture of depth that does not say how it is coded");  // the reader's part
        const bool is_even = picture.width % 2 == 0 && picture.height % 2 == 0;
        if (tagged.info.depth_code->halved && !(is_even && may_be_halved(tagged.role)))
            throw WorkError("a picture of depth that cannot be half of its colour");  // the same
        picture.depth_m = distances(picture.width, picture.height, *tagged.info.depth_code, pattern);
    } else {
        set_colours(picture, kind, how, pattern);
    }
    picture.info = std::move(tagged.info);
    return picture;
}

/// All of one frame. `left`: how many pictures may still come. `next`: one that was read and begins the next frame.
DecodedFrame take_frame(Choices& choices, Kind kind, int& left,
                        std::optional<std::pair<TaggedFrameInfo, std::uint8_t>>& next) {
    DecodedFrame frame;
    std::optional<std::int64_t> index;
    while (next || !choices.are_over()) {
        if (!next) {
            const auto how = choices.take<std::uint8_t>();
            const auto size = choices.take<std::uint16_t>();
            auto tagged = decode_frame_info(choices.take_bytes(size));
            const bool fits =
                tagged && std::int64_t(picture_width(tagged->info)) * picture_height(tagged->info) <= max_pixels;
            if (!fits)
                continue;
            if (--left < 0)
                break;
            next.emplace(std::move(*tagged), how);
        }
        if (index && (next->second & begins_frame))
            break;
        auto [tagged, how] = *std::exchange(next, std::nullopt);
        // Pictures of a frame are found by its number.
        index = tagged.info.index = index.value_or(tagged.info.index);
        const bool tiled = (how & is_tile) != 0 && may_be_tiled(tagged.role);
        const auto* sphere = std::get_if<EquirectCamera>(&tagged.info.camera);
        if (tiled && sphere == nullptr)
            continue;
        DecodedPictures& place = tiled ? frame.tiles[{sphere->range.longitude_min, sphere->range.latitude_max}] : frame;
        const TrackRole role = tagged.role;
        place.picture(role) = decoded(std::move(tagged), kind, how, unsigned(left));
    }
    return frame;
}

struct Viewer {
    explicit Viewer(Choices& choices) {
        const auto& engines = engine_stages();
        engine = choices.one_of(engines).name;
        constexpr std::array chains = {default_fill, "hidden,patches,earlier,small,base,spread", "small-wide,pushpull",
                                       "none"};
        ways.fill = choices.one_of(chains);
        ways.mirrors = MirrorTreatment(choices.below(3));
        ways.reliability = choices.yes();
        later_s = 0.05 * choices.below(5);
        // From where the source is, or as far as a head box reaches, or far out of it.
        offset_m = choices.one_of(std::array{0.0, 0.03, 0.5, 1e6});
        const int last = choices.below(15);
        kind = Kind(last % 5);
        packing = packings[std::size_t(last / 5)];
    }

    std::string engine;
    PipelineWays ways;
    double later_s = 0, offset_m = 0;
    Kind kind = Kind::rgb;
    StereoPacking packing = StereoPacking::none;
};

FeedOptions feed_options(Kind kind) {
    FeedOptions options{.depth = true, .specular = true};
    options.yuv = kind == Kind::yuv;
    options.pq = kind == Kind::pq;
    if (kind == Kind::yuv)
        options.memory = std::make_shared<SomeMemory>();
    static const auto display = std::make_shared<const HdrDisplay>();
    if (kind == Kind::display || kind == Kind::rgb_for_display)
        options.hdr_display = display;
    return options;
}

/// As others' video is given: without a pose, and perhaps with both eyes in each picture.
void make_foreign(DecodedFrame& frame, StereoPacking packing) {
    frame.posed = false;
    DecodedPicture& main = *frame.picture(TrackRole::main);
    frame.right = split_eyes(main, packing);
    for (DecodedPicture* eye : {&main, &*frame.right})
        eye->info->camera = EquirectCamera{eye->width, eye->height, {}};
}

void check(const PipelineEye& eye) {
    for (const std::uint8_t origin : eye.picture.origin.samples())
        require(origin < pixel_origin_count, "every pixel says who gave it");
    require(eye.picture.rgba.width() == eye.camera.width && eye.picture.rgba.height() == eye.camera.height,
            "an eye's picture has its size");
}

void read(Bytes bytes) {
    Choices choices(bytes);
    Viewer viewer(choices);
    const FeedOptions options = feed_options(viewer.kind);
    FrameMaker maker("fuzz", options, [](const DecodedPicture&) {});
    CpuPipeline pipeline;
    PipelineEye left, right;
    left.camera = right.camera = {40, 30, 1.4};
    std::shared_ptr<const ReceivedFrame> shown;
    std::optional<std::pair<TaggedFrameInfo, std::uint8_t>> next;
    int pictures = max_pictures;
    while (next || (!choices.are_over() && pictures > 0)) {
        DecodedFrame decoded = take_frame(choices, viewer.kind, pictures, next);
        if (!decoded.picture(TrackRole::main))
            continue;
        require(decoded.bytes() > 0, "a picture has samples");
        if (viewer.packing != StereoPacking::none)
            make_foreign(decoded, viewer.packing);
        const auto frame = std::make_shared<const ReceivedFrame>(maker.make(std::move(decoded)));
        const FrameInfo& info = frame->main.info;
        if (frame->right)
            require(frame->main.width() == frame->right->width() && frame->main.height() == frame->right->height(),
                    "both eyes are of one size");
        if (frame->main.rgb.empty() || !frame->posed)
            continue;  // for other pipelines
        if (shown == nullptr) {
            const DepthChoice choice =
                choose_depth({.source = "fuzz", .method = viewer.engine, .depth = ""},
                             {.plane = !frame->main.depth_m.empty(),
                              .code = info.depth_code ? std::optional(info.depth_code->code) : std::nullopt,
                              .eye_without_plane = Eye::left});
            viewer.ways.engine = choice.method;
            viewer.ways.by_depth = choice.depth != "none";
            pipeline.use(viewer.ways);
            pipeline.use(make_depth(choice.depth, nullptr, info, {}));
        } else {
            pipeline.remember({shown, &shown->main}, {shown, shown->base ? &*shown->base : nullptr});
        }
        const bool lacks_depth = viewer.ways.by_depth && frame->main.depth_m.empty();
        PipelineWays ways = viewer.ways;
        if (lacks_depth) {
            ways.engine = "rotation";
            ways.by_depth = false;
        }
        pipeline.use(ways);
        left.pose = right.pose = info.camera_pose;
        left.pose.position_m.x -= viewer.offset_m;
        right.pose.position_m += viewer.offset_m;
        PipelineTimes times;
        pipeline.render(*frame, left, right, pipeline.extrapolation_s(*frame, left, right, viewer.later_s, false),
                        times);
        check(left);
        check(right);
        shown = frame;
    }
}

class Script {
public:
    explicit Script(std::array<std::uint8_t, 7> viewer) : bytes_(viewer.begin(), viewer.end()) {}

    Script& add(std::uint8_t how, TrackRole role, const FrameInfo& info) {
        const std::vector<std::uint8_t> payload = encode_frame_info(role, info);
        bytes_.insert(bytes_.end(), {how, std::uint8_t(payload.size() & 0xff), std::uint8_t(payload.size() >> 8)});
        bytes_.insert(bytes_.end(), payload.begin(), payload.end());
        return *this;
    }
    const std::vector<std::uint8_t>& bytes() const { return bytes_; }

private:
    std::vector<std::uint8_t> bytes_;
};

FrameInfo with_depth(FrameInfo info) {
    info.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.1, 0.4, true}, 0};
    return info;
}

FrameInfo sphere(std::int64_t index) {
    FrameInfo info;
    info.index = index;
    info.time_s = double(index) / 30;
    info.head_radius_m = 0.1;
    info.camera = EquirectCamera{64, 32, {}};
    info.crf = 24.0f;
    return info;
}

/// Of the last of a script's seven bytes.
std::uint8_t shown_as(Kind kind, StereoPacking packing = StereoPacking::none) {
    return std::uint8_t(5 * (std::ranges::find(packings, packing) - packings.begin()) + int(kind));
}

std::vector<std::uint8_t> whole_sphere(Kind kind) {
    Script script({3, 0, 0, 1, 2, 1, shown_as(kind)});
    for (std::int64_t index = 0; index < 2; ++index) {
        FrameInfo moving = sphere(index), patches = sphere(index), small = sphere(index);
        moving.moving = {{{{{1, 0, -2}, {0, 3, 0}}, {}}, 0.1f, 1.5f, {{7, 40, 60}, {8, 0, 12}, {8, 40, 60}}}};
        patches.patches =
            PatchAtlas{64, 32, 16, {}, {{0.05, 0, 0}, {-0.05, 0, 0}}, 2, 1, {{0, 1, 1, true}, {1, 3, 0, true}}};
        small.camera = PerspectiveCamera{32, 24, 1.6};
        small.camera_pose.position_m.x = 0.03;
        script.add(begins_frame, TrackRole::main, moving)
            .add(0, TrackRole::depth, with_depth(sphere(index)))
            .add(0, TrackRole::reflections, with_depth(sphere(index)))
            .add(0, TrackRole::hidden, sphere(index))
            .add(0, TrackRole::hidden_depth, with_depth(sphere(index)))
            .add(0, TrackRole::small, small)
            .add(0, TrackRole::patches, patches)
            .add(0, TrackRole::patches_depth, with_depth(patches));
    }
    return script.bytes();
}

FrameInfo with_half_depth(FrameInfo info) {
    info = with_depth(std::move(info));
    info.depth_code->halved = true;
    return info;
}

std::vector<std::uint8_t> window_and_base(Kind kind) {
    Script script({4, 0, 0, 1, 0, 1, shown_as(kind)});
    const WindowGrid grid{128, 64, 48, 32};
    for (std::int64_t index = 0; index < 3; ++index) {
        FrameInfo window = sphere(index);
        window.camera = window_camera(grid, {int(16 * index), 16});
        script.add(begins_frame, TrackRole::main, sphere(index))
            .add(0, TrackRole::depth, with_half_depth(sphere(index)))
            .add(0, TrackRole::window, window)
            .add(0, TrackRole::window_depth, with_half_depth(window))
            .add(0, TrackRole::window_reflections, with_depth(window));
    }
    return script.bytes();
}

std::vector<std::uint8_t> tiles(Kind kind) {
    Script script({5, 1, 0, 0, 0, 2, shown_as(kind)});
    const TileGrid tiling{4, 2};
    const WindowGrid grid = tile_grid(128, tiling);
    for (std::int64_t index = 0; index < 2; ++index) {
        script.add(begins_frame, TrackRole::main, sphere(index)).add(0, TrackRole::depth, with_depth(sphere(index)));
        // Some, and then all of them.
        const std::vector<int> numbers =
            index == 0 ? std::vector<int>{3, 0, 4} : std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7};
        for (const int number : numbers) {
            FrameInfo tile = sphere(index);
            tile.camera = window_camera(grid, tile_place(grid, tiling, number));
            script.add(is_tile, TrackRole::window, tile).add(is_tile, TrackRole::window_depth, with_depth(tile));
        }
    }
    return script.bytes();
}

std::vector<std::uint8_t> both_eyes(Kind kind, StereoPacking packing) {
    Script script({0, 0, 0, 0, 0, 0, shown_as(kind, packing)});
    script.add(begins_frame, TrackRole::main, sphere(0)).add(begins_frame, TrackRole::main, sphere(1));
    return script.bytes();
}

Seeds seeds() {
    Seeds seeds{both_eyes(Kind::rgb, StereoPacking::top_bottom), both_eyes(Kind::yuv, StereoPacking::side_by_side),
                both_eyes(Kind::pq, StereoPacking::top_bottom)};
    for (const Kind kind : {Kind::rgb, Kind::yuv, Kind::pq, Kind::display})
        for (auto* const make : {whole_sphere, window_and_base, tiles})
            seeds.push_back(make(kind));
    return seeds;
}

}  // namespace

const Target shown_frames_target{"shown_frames", read, seeds, 60, damage_frame_data};

}  // namespace equistream::fuzz
