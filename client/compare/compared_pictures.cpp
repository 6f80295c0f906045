#include "compared_pictures.h"

#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>
#include <utility>

namespace equistream {

namespace {

namespace fs = std::filesystem;

/// One eye's pictures on one side of the comparison.
struct Side {
    fs::path place;         ///< a file, or a folder of frames
    std::string extension;  ///< empty for a file
    std::vector<std::int64_t> frames;

    bool is_file() const { return extension.empty(); }
    bool holds(std::int64_t frame) const { return std::binary_search(frames.begin(), frames.end(), frame); }
    fs::path file(std::int64_t frame) const { return place / frame_file_name(frame, extension); }
};

bool is_folder(const fs::path& path) {
    std::error_code ignored;
    return fs::is_directory(path, ignored);
}

Side open_side(const fs::path& place) {
    std::error_code ignored;
    if (fs::is_regular_file(place, ignored))
        return {place, "", {}};
    if (!is_folder(place))
        throw InputError(expected_found(place.string(), "a picture or a folder of frames", "nothing"));
    Side png{place, "png", list_frames(place, "png")};
    Side exr{place, "exr", list_frames(place, "exr")};
    if (!png.frames.empty() && !exr.frames.empty())
        throw InputError(
            expected_found(place.string(), "frames of one format", "both frame.NNNN.png and frame.NNNN.exr"));
    if (png.frames.empty() && exr.frames.empty())
        throw InputError(expected_found(place.string(), "frame.NNNN.png or frame.NNNN.exr", "no frame"));
    return png.frames.empty() ? exr : png;
}

std::vector<fs::path> roots_of(const PairingOptions& options) {
    std::vector<fs::path> roots{options.picture, options.truth};
    for (const auto& root : {options.second_picture, options.second_truth, options.gaps})
        if (root)
            roots.push_back(*root);
    return roots;
}

/// Subfolders to compare; {""} where the roots themselves are folders of frames or files.
std::vector<std::string> choose_eyes(const PairingOptions& options) {
    static constexpr std::array accepted{"left", "right", "centre", "small"};
    for (const std::string& eye : options.eyes)
        if (std::find(accepted.begin(), accepted.end(), eye) == accepted.end())
            throw InputError(expected_found("--eyes", "left, right, centre or small", "'" + eye + "'"));
    if (!options.eyes.empty())
        return options.eyes;
    const auto present = [&](const std::string& eye) {
        return is_folder(options.picture / eye) || is_folder(options.truth / eye);
    };
    std::vector<std::string> eyes;
    for (const char* eye : {"left", "right"})
        if (present(eye))
            eyes.emplace_back(eye);
    if (eyes.empty() && present("centre"))
        eyes.emplace_back("centre");
    if (eyes.empty())
        eyes.emplace_back();
    return eyes;
}

void require_frame(const std::vector<Side>& sides, std::int64_t frame) {
    for (const Side& side : sides)
        if (!side.holds(frame))
            throw InputError(expected_found(side.file(frame).string(), "a frame to compare", "no such file"));
}

/// A range may be far longer than what is there: it is followed to the first frame that a side lacks.
std::vector<std::int64_t> frames_of_range(std::int64_t first, std::int64_t last, const std::vector<Side>& sides) {
    std::vector<std::int64_t> frames;
    for (std::int64_t frame = first; frame <= last; ++frame) {
        require_frame(sides, frame);
        frames.push_back(frame);
    }
    return frames;
}

std::vector<std::int64_t> choose_frames(const PairingOptions& options, const std::vector<Side>& sides) {
    if (options.first_frame)
        return frames_of_range(*options.first_frame, *options.last_frame, sides);
    const std::vector<std::int64_t>& wanted = sides.front().frames;
    for (const std::int64_t frame : wanted)
        require_frame(sides, frame);
    for (const Side& side : sides)
        if (side.frames.size() != wanted.size())
            throw InputError(expected_found(side.place.string(),
                                            "the " + std::to_string(wanted.size()) + " frames of " +
                                                sides.front().place.string() + " (or give --frames)",
                                            std::to_string(side.frames.size()) + " frames"));
    return wanted;
}

/// Builds one pair from the files of all sides, in the order of roots_of.
PicturePair make_pair(const PairingOptions& options, std::optional<std::int64_t> frame,
                      const std::vector<fs::path>& files) {
    PicturePair pair{frame, files[0], files[1], {}, {}, {}};
    std::size_t next = 2;
    if (options.second_picture)
        pair.second_picture = files[next++];
    if (options.second_truth)
        pair.second_truth = files[next++];
    if (options.gaps)
        pair.gaps = files[next];
    return pair;
}

EyePairs pair_eye(const PairingOptions& options, const std::string& eye) {
    std::vector<Side> sides;
    for (const fs::path& root : roots_of(options))
        sides.push_back(open_side(eye.empty() ? root : root / eye));
    EyePairs eye_pairs{eye.empty() ? "view" : eye, {}};
    const auto files = std::count_if(sides.begin(), sides.end(), [](const Side& side) { return side.is_file(); });
    if (files != 0 && files != static_cast<std::ptrdiff_t>(sides.size()))
        throw InputError(expected_found(sides[0].place.string() + " and " + sides[1].place.string(),
                                        "only files or only folders", "both"));
    std::vector<fs::path> paths;
    if (files != 0 && options.first_frame)
        throw InputError(expected_found("--frames", "folders of frames to choose from",
                                        "the single file " + sides[0].place.string()));
    if (files != 0) {
        for (const Side& side : sides)
            paths.push_back(side.place);
        eye_pairs.pairs.push_back(make_pair(options, std::nullopt, paths));
        return eye_pairs;
    }
    for (const std::int64_t frame : choose_frames(options, sides)) {
        paths.clear();
        for (const Side& side : sides)
            paths.push_back(side.file(frame));
        eye_pairs.pairs.push_back(make_pair(options, frame, paths));
    }
    return eye_pairs;
}

void require_file(const std::filesystem::path& file, const std::string& expected) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
        throw InputError(expected_found(file.string(), expected, "no such file"));
}

ByteImage with_three_channels(ByteImage png) {
    if (png.channels() == 3)
        return png;
    ByteImage rgb(png.width(), png.height(), 3);
    for (std::size_t i = 0; i < rgb.samples().size(); ++i)
        rgb.samples()[i] = png.samples()[i / 3];
    return rgb;
}

void read_exr_planes(ScoredPicture& picture, std::optional<double> exposure, bool with_motion) {
    Frame frame;
    try {
        // Without motion a file is no error: it is read whole, since planes that are named must be there.
        frame = read_exr(picture.file, with_motion ? std::vector<std::string>{} : std::vector<std::string>{"colour"});
    } catch (const WorkError& error) {
        throw InputError(error.what());
    }
    const auto colour = frame.planes.find("colour");
    if (colour == frame.planes.end())
        throw InputError(expected_found(picture.file.string(), "colour channels R, G, B", "none"));
    picture.linear = true;
    picture.radiance = std::move(colour->second);
    picture.backward = std::move(frame.planes["backward"]);
    picture.forward = std::move(frame.planes["forward"]);
    picture.exposure = exposure.value_or(frame.info.exposure);
    picture.info = std::move(frame.info);
}

}  // namespace

std::vector<EyePairs> pair_pictures(const PairingOptions& options) {
    std::vector<EyePairs> eyes;
    for (const std::string& eye : choose_eyes(options))
        eyes.push_back(pair_eye(options, eye));
    return eyes;
}

ScoredPicture read_scored_picture(const std::filesystem::path& file, std::optional<double> exposure, bool with_motion) {
    require_file(file, "a picture");
    ScoredPicture picture;
    picture.file = file;
    if (file.extension() == ".exr")
        read_exr_planes(picture, exposure, with_motion);
    else if (file.extension() == ".png")
        picture.rgb = with_three_channels(read_picture(file));
    else
        throw InputError(expected_found(file.string(), "a .png or an .exr", "'" + file.extension().string() + "'"));
    return picture;
}

FloatImage display_values(const ScoredPicture& picture, const DisplayTransform& transform) {
    return picture.linear ? transform.to_display(picture.radiance.view(), picture.exposure)
                          : widen_8bit(picture.rgb.view());
}

ImageView<const std::uint8_t> display_8bit(const ScoredPicture& picture, const DisplayTransform& transform,
                                           ByteImage& made) {
    if (!picture.linear)
        return picture.rgb.view();
    made = quantise_8bit(display_values(picture, transform).view());
    return std::as_const(made).view();
}

FloatImage exposed_linear(const ScoredPicture& picture, const DisplayTransform& transform) {
    if (!picture.linear) {
        FloatImage linear = transform.to_linear(widen_8bit(picture.rgb.view()).view(), 1);
        for (float& value : linear.samples())
            value = std::clamp(value, 0.f, 1.f);
        return linear;
    }
    FloatImage exposed(picture.width(), picture.height(), 3);
    const auto channels = static_cast<std::size_t>(picture.radiance.channels());
    const auto factor = static_cast<float>(picture.exposure);
    const auto in = picture.radiance.samples();
    const auto out = exposed.samples();
    for (std::size_t i = 0; i < out.size(); ++i) {
        const float radiance = in[i / 3 * channels + i % 3];
        out[i] = std::isnan(radiance) ? 0.f : std::clamp(factor * radiance, 0.f, 1.f);
    }
    return exposed;
}

ByteImage read_mask(const std::filesystem::path& file) {
    require_file(file, "a mask of gap pixels");
    const ByteImage png = read_picture(file);
    const auto channels = static_cast<std::size_t>(png.channels());
    ByteImage mask(png.width(), png.height(), 1);
    for (std::size_t i = 0; i < mask.samples().size(); ++i) {
        const auto pixel = png.samples().subspan(i * channels, channels);
        mask.samples()[i] = std::any_of(pixel.begin(), pixel.end(), [](std::uint8_t v) { return v != 0; }) ? 255 : 0;
    }
    return mask;
}

}  // namespace equistream
