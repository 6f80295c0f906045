#include "view_writer.h"

#include <equistream/error.h>
#include <equistream/locks.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <exception>
#include <system_error>

namespace equistream::play {

namespace fs = std::filesystem;

namespace {

/// High quality, so that what is judged is the stream that came in and not this one.
constexpr int video_crf = 12;

std::int64_t size_of(const fs::path& file) {
    std::error_code error;
    const auto size = fs::file_size(file, error);
    return error ? 0 : std::int64_t(size);
}

StreamSettings video_settings(Layout layout, ImageView<const std::uint8_t> rgb, const FrameInfo& info) {
    StreamSettings settings;
    settings.crf = video_crf;
    settings.frames_per_second = info.frames_per_second;
    settings.scene = info.scene;
    settings.tracks = {{TrackRole::main, rgb.width, rgb.height}};
    settings.tagged = layout == Layout::files;
    if (layout == Layout::side_by_side)
        settings.stereo = StereoPacking::side_by_side;
    return settings;
}

FloatImage with_alpha(const FloatImage& rgb, const ByteImage& origin) {
    FloatImage rgba(rgb.width(), rgb.height(), 4);
    for (int y = 0; y < rgb.height(); ++y)
        for (int x = 0; x < rgb.width(); ++x) {
            std::copy_n(rgb.pixel(x, y), 3, rgba.pixel(x, y));
            rgba.pixel(x, y)[3] = origin.pixel(x, y)[0] == std::uint8_t(PixelOrigin::gap) ? 0.0f : 1.0f;
        }
    return rgba;
}

FloatImage copy_of(ImageView<const float> plane) {
    FloatImage copy(plane.width, plane.height, 1);
    for (int y = 0; y < plane.height; ++y)
        std::copy_n(plane.row(y), plane.width, copy.pixel(0, y));
    return copy;
}

/// Scene-referred again: the display transform and the exposure are undone.
Frame linear_frame(const FinishedView& view, const DisplayTransform& display) {
    const FloatImage linear = display.to_linear(widen_8bit(view.picture.rgb().view()).view(), view.info.exposure);
    Frame frame;
    frame.info = view.info;
    frame.planes["colour"] = with_alpha(linear, view.picture.origin);
    if (view.depth_m.data != nullptr)
        frame.planes["depth"] = copy_of(view.depth_m);
    return frame;
}

}  // namespace

ViewWriter::ViewWriter(const Settings& settings, const std::string& name)
    : format_(settings.format), layout_(settings.layout), path_(settings.out) {
    if (!settings.out_is_video)
        path_ /= format_ == Format::mp4 ? name + ".mp4" : name;
    if (format_ == Format::exr)
        display_.emplace();
    const fs::path folder = format_ == Format::mp4 ? path_.parent_path() : path_;
    require_writable_folder(folder.empty() ? "." : folder);
}

void ViewWriter::write(const FinishedView& view) {
    if (format_ != Format::exr)
        return write(view.picture.rgb().view(), view.info);
    const fs::path file = path_ / frame_file_name(view.info.index);
    write_exr(file, linear_frame(view, *display_));
    bytes_of_pictures_ += size_of(file);
}

void ViewWriter::write(ImageView<const std::uint8_t> rgb, const FrameInfo& info) {
    if (format_ == Format::mp4) {
        if (!video_)
            video_ = std::make_unique<StreamWriter>(path_.string(), video_settings(layout_, rgb, info));
        return video_->write(TrackRole::main, rgb, info);
    }
    const fs::path file = path_ / frame_file_name(info.index, "png");
    write_picture(file, rgb);
    bytes_of_pictures_ += size_of(file);
}

void ViewWriter::finish() {
    if (video_)
        video_->finish();
}

EyesWriter::EyesWriter(const Settings& settings) : anaglyph_(settings.anaglyph) {
    if (settings.layout != Layout::files) {
        views_.emplace_back(settings, "both");
        return;
    }
    for (const char* eye : {"left", "right"})
        views_.emplace_back(settings, eye);
}

void EyesWriter::write(const FinishedView& left, const FinishedView& right) {
    if (views_.size() == 2) {
        views_.front().write(left);
        views_.back().write(right);
        return;
    }
    const ByteImage left_rgb = left.picture.rgb(), right_rgb = right.picture.rgb();
    const ByteImage both = anaglyph_ != nullptr
                               ? make_anaglyph(*anaglyph_, left_rgb.view(), right_rgb.view())
                               : packed_eyes(StereoPacking::side_by_side, left_rgb.view(), right_rgb.view());
    views_.front().write(both.view(), left.info);
}

void EyesWriter::finish() {
    std::exception_ptr problem;
    for (ViewWriter& views : views_) {
        try {
            views.finish();
        } catch (...) {
            problem = std::current_exception();
        }
    }
    if (problem)
        std::rethrow_exception(problem);
}

std::int64_t EyesWriter::bytes() const {
    std::int64_t bytes = 0;
    for (const ViewWriter& views : views_)
        bytes += views.bytes();
    return bytes;
}

}  // namespace equistream::play
